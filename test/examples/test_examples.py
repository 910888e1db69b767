"""Every example runs, in a directory of its own, and prints what it says; the public API is lazy and whole."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import wholearm_ros as wa

ROOT = Path(__file__).parents[2]
BAG = ROOT / 'bags' / 'asymmetric_hexagon'
WORDS = {
    '1_plan_and_simulate': ((), ['at the goal', 'film_strip.png']),
    '2_your_polygon': ((), ['plan']),
    '3_perturb': ((), ['of 5 at the goal']),
    '5_read_a_bag': ((str(BAG), 'report.html'), ['joint states', 'report.html']),
}


def run_example(name: str, directory: Path, *arguments: str) -> str:
    environment = {**os.environ, 'PYTHONPATH': str(ROOT)}
    done = subprocess.run(
        [sys.executable, ROOT / 'examples' / f'{name}.py', *arguments],
        cwd=directory,
        env=environment,
        capture_output=True,
        text=True,
        timeout=280,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize('name', WORDS)
def test_an_example_runs(name, tmp_path):
    arguments, words = WORDS[name]
    told = run_example(name, tmp_path, *arguments)
    assert all(word in told for word in words), told


def test_the_plan_service_is_called(tmp_path):
    pytest.importorskip('rclpy', reason='needs ROS 2')
    from conftest import fresh_domain

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('ROS_DOMAIN_ID', fresh_domain())
        patch.setenv('PYTHONPATH', str(ROOT))
        node = subprocess.Popen(
            [sys.executable, '-m', 'wholearm_ros.nodes.contact_state_planner'],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            assert run_example('4_call_the_plan_service', tmp_path).startswith('True')
        finally:
            node.terminate()
            node.wait(20)


def test_every_example_is_run():
    found = {path.stem for path in (ROOT / 'examples').glob('*.py')}
    of_the_graph = {'4_call_the_plan_service', '6_drive_your_own_hand'}  # test/ros/test_own_hand.py
    assert found == {*WORDS, *of_the_graph}


def test_the_public_names_exist():
    assert all(callable(getattr(wa, name)) for name in wa.__all__)
    assert set(wa.__all__) == set(wa._HOMES)


def test_importing_the_package_imports_no_room():
    code = "import sys, wholearm_ros; print([m for m in sys.modules if 'numpy' in m or 'wholearm_ros.' in m])"
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == '[]'


def test_the_notebook_runs(tmp_path, monkeypatch):
    """Every cell, in a kernel of its own; it is kept without outputs."""
    nbformat = pytest.importorskip('nbformat', reason='nbclient is not installed')
    client = pytest.importorskip('nbclient', reason='nbclient is not installed')
    monkeypatch.setenv('PYTHONPATH', str(ROOT))
    notebook = nbformat.read(ROOT / 'examples' / '7_notebook.ipynb', as_version=4)
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == 'code']
    assert not any(cell.outputs for cell in code)
    resources = {'metadata': {'path': str(tmp_path)}}
    client.NotebookClient(notebook, timeout=200, resources=resources).execute()
    told = ''.join(out.get('text', '') for cell in code for out in cell.outputs)
    assert 'of 5 at the goal' in told and (tmp_path / 'figures' / 'film_strip.png').exists()
