"""Compiled code on disk is that of the present sources, of every file that a kernel reads."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import wholearm_ros
from wholearm_ros.kernels import SOURCES

ONE = 'from wholearm_ros.kernels import kernel\n@kernel\ndef one():\n    return 1\n'
BOTH = """from wholearm_ros.kernels import kernel
from wholearm_ros.kernels.first import one
@kernel
def both():
    return one() + 10
"""


@pytest.fixture
def package(tmp_path):
    """A package whose kernel `both` calls one of another file."""
    rooms = tmp_path / 'wholearm_ros'
    kernels = Path(wholearm_ros.__file__).parent / 'kernels' / '__init__.py'
    for room in ('kernels', 'model'):
        (rooms / room).mkdir(parents=True)
        (rooms / room / '__init__.py').write_text('')
    (rooms / '__init__.py').write_text('')
    for source in SOURCES[1:]:
        (rooms / source).write_text('')
    shutil.copy(kernels, rooms / 'kernels' / '__init__.py')
    (rooms / 'kernels' / 'first.py').write_text(ONE)
    (rooms / 'kernels' / 'second.py').write_text(BOTH)
    return tmp_path


def answer(package) -> int:
    code = 'from wholearm_ros.kernels.second import both; print(both())'
    done = subprocess.run(
        [sys.executable, '-c', code],
        cwd=package,
        env={'PYTHONPATH': str(package), 'PATH': ''},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return int(done.stdout)


def test_a_kernel_follows_a_change_in_a_file_that_it_calls(package):
    assert answer(package) == 11
    assert list((package / 'wholearm_ros' / 'kernels' / '__pycache__').glob('*.nbc'))
    first = package / 'wholearm_ros' / 'kernels' / 'first.py'
    first.write_text(ONE.replace('return 1', 'return 2  # another size: Python compares seconds'))
    assert answer(package) == 12
