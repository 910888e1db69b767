"""The package as users install it: what it imports is declared, and the wheel alone plans from another directory."""

import ast
import os
import re
import shutil
import subprocess
import sys
import tarfile
import venv
from importlib import metadata
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / 'wholearm_ros'
NO_WHEEL = {'tf2_msgs'}  # part of a ROS 2 installation only; ros/interface/frames.py does without


def declared(*extras: str) -> set:
    """Distributions that setup.py asks for directly, and those of the extras."""
    return {
        _normal(re.match(r'[\w.-]+', line)[0])
        for line in metadata.requires('wholearm_ros')
        if (extra := re.search(r'extra == ["\']([\w-]+)', line)) is None or extra[1] in extras
    }


def with_dependencies(names: set) -> set:
    """The distributions and whatever they ask for in turn, without extras."""
    found, open_ = set(), list(names)
    while open_:
        name = open_.pop()
        if name in found:
            continue
        try:
            lines = metadata.requires(name) or ()
        except metadata.PackageNotFoundError:
            continue  # for another platform or Python
        found.add(name)
        open_ += [_normal(re.match(r'[\w.-]+', ln)[0]) for ln in lines if 'extra ==' not in ln]
    return found


def imported() -> dict:
    """Top-level module that is not of the standard library → the files that import it."""
    modules = {}
    for path in PACKAGE.rglob('*.py'):
        for node in ast.walk(ast.parse(path.read_text())):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and not node.level:
                names = [node.module]
            for name in (n.partition('.')[0] for n in names):
                if name not in sys.stdlib_module_names and name != 'wholearm_ros':
                    modules.setdefault(name, []).append(path.relative_to(ROOT).as_posix())
    return modules


def test_what_is_imported_is_declared():
    """Not merely there because something else brought it; ROS packages may come with the wheels of ROS."""
    providers = metadata.packages_distributions()
    direct = declared('pybullet', 'mujoco', 'ros-wheels', 'cluster', 'console')
    of_ros = with_dependencies({name for name in direct if name.startswith('ros-')})
    undeclared = {
        module: files[:3]
        for module, files in imported().items()
        if module not in NO_WHEEL
        and not {_normal(p) for p in providers.get(module, [module])} & (direct | of_ros)
    }
    if os.environ.get('ROS_DISTRO'):
        undeclared = {m: f for m, f in undeclared.items() if not m.endswith('_msgs')}
    assert not undeclared


@pytest.fixture(scope='module')
def tree(tmp_path_factory) -> Path:
    """A copy of the repository to build from."""
    copy = tmp_path_factory.mktemp('tree') / 'wholearm_ros'
    ignored = shutil.ignore_patterns(
        '.git', '.*_cache', '.venv', 'runs', 'build', 'install', 'log', '*.egg-info', '__pycache__'
    )
    shutil.copytree(ROOT, copy, ignore=ignored, symlinks=True)
    return copy


@pytest.fixture(scope='module')
def installed(tree, tmp_path_factory) -> Path:
    """The bin/ of a fresh environment that holds the wheel and its declared requirements, and nothing else.

    The requirements are links to those of this environment (nothing is downloaded), only what setup.py asks for and
    what that asks for: a module that the test tools alone brought is not there.
    """
    base = tmp_path_factory.mktemp('wheel')
    pip = [sys.executable, '-m', 'pip', '-q', '--disable-pip-version-check']
    wheel_command = [
        *pip,
        'wheel',
        '--no-deps',
        '--no-build-isolation',
        '--no-index',
        '-w',
        base,
        tree,
    ]
    _checked(base, *wheel_command)
    [wheel] = base.glob('*.whl')
    home = base / 'environment'
    venv.create(home, with_pip=False, symlinks=True)
    [site] = home.glob('lib/python*/site-packages')
    for name in with_dependencies(declared()):
        for part in {Path(f).parts[0] for f in metadata.files(name) or ()} - {
            '..',
            '__pycache__',
            'bin',
        }:
            source = Path(metadata.distribution(name).locate_file(part))
            if source.exists() and not (site / part).exists():
                (site / part).symlink_to(source)
    install = [
        *pip,
        '--python',
        home / 'bin' / 'python',
        'install',
        '--no-deps',
        '--no-index',
        wheel,
    ]
    _checked(base, *install)
    _take_compiled_kernels(site / 'wholearm_ros')
    return home / 'bin'


def test_the_wheel_alone_plans_simulates_and_reports_from_another_directory(installed, tmp_path):
    code = 'import wholearm_ros; print(wholearm_ros.__file__)'
    where = _run(tmp_path, installed / 'python', '-c', code)
    assert str(installed.parent) in where.stdout
    (tmp_path / 'my.yaml').write_text((ROOT / 'config' / 'asymmetric_hexagon.yaml').read_text())
    planned = _run(tmp_path, installed / 'wholearm', 'plan', 'my.yaml', '--json', 'plan.json')
    assert planned.returncode == 0, planned.stdout + planned.stderr
    assert (tmp_path / 'plan.json').stat().st_size > 1000
    # Neither an engine nor ROS is there: our own physics is the default.
    executed = _run(tmp_path, installed / 'wholearm', 'simulate', 'plan.json', '--run', 'run.json')
    assert executed.returncode == 0, executed.stdout + executed.stderr
    reported = _run(tmp_path, installed / 'wholearm', 'report', 'run.json', '-o', 'report.html')
    assert reported.returncode == 0, reported.stdout + reported.stderr
    assert (tmp_path / 'report.html').stat().st_size > 100_000


def test_the_wheel_tells_what_it_is(installed):
    [told] = installed.parent.glob('lib/python*/site-packages/wholearm_ros-*.dist-info/METADATA')
    text = told.read_text()
    assert '# wholearm_ros' in text and 'Classifier: Operating System :: POSIX :: Linux' in text
    assert 'Description-Content-Type: text/markdown' in text
    assert '](docs/' not in text and '](config/' not in text  # they lead nowhere off the repository


def test_the_source_distribution_holds_docs_and_tests(tree, tmp_path):
    code = f'from setuptools import build_meta; build_meta.build_sdist({str(tmp_path)!r})'
    _checked(tree, sys.executable, '-c', code)
    [archive] = tmp_path.glob('*.tar.gz')
    with tarfile.open(archive) as opened:
        names = {name.partition('/')[2] for name in opened.getnames()}
    assert {'docs/scenario.md', 'docs/images/scenario.png', 'examples/7_notebook.ipynb'} <= names
    assert {'test/packaging/test_wheel.py', 'CITATION.cff', 'mkdocs.yml', 'Makefile'} <= names
    assert {'config/wholearm.rviz', 'bags/README.md', '.ci/run'} <= names
    assert not [name for name in names if '__pycache__' in name]


def _run(directory: Path, *command) -> subprocess.CompletedProcess:
    environment = {
        k: v for k, v in os.environ.items() if not k.startswith(('PYTHON', 'VIRTUAL_ENV'))
    }
    return subprocess.run(
        command,
        check=False,
        cwd=directory,
        env=environment,
        capture_output=True,
        text=True,
        timeout=280,
    )


def _checked(directory: Path, *command) -> None:
    done = _run(directory, *command)
    assert done.returncode == 0, done.stdout + done.stderr


def _take_compiled_kernels(target: Path) -> None:
    """The kernels' machine code of this tree, so that the test does not compile for a minute; numba asks for the same
    time of change and size of a source file, else it compiles."""
    for source in PACKAGE.rglob('*.py'):
        there = target / source.relative_to(PACKAGE)
        if there.exists() and there.read_bytes() == source.read_bytes():
            stamp = source.stat()
            os.utime(there, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
    compiled = PACKAGE.rglob('__pycache__/*.nb[ic]')
    for cached in (*compiled, PACKAGE / 'kernels' / '__pycache__' / 'sources.sha256'):
        there = target / cached.relative_to(PACKAGE)
        there.parent.mkdir(exist_ok=True)
        shutil.copy2(cached, there)


def _normal(name: str) -> str:
    return re.sub(r'[-_.]+', '-', name).lower()
