"""The walks of docs/architecture.md name files and functions that are there; every room has its line in the table."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / 'wholearm_ros'
PAGE = (ROOT / 'docs' / 'architecture.md').read_text(encoding='utf-8')
WALKS = dict(re.findall(r'^## (From .+?)\n(.*?)(?=^## |\Z)', PAGE, flags=re.S | re.M))
NOT_CODE = {'contact_plan', 'joint_states', 'joint_commands'}  # topics


def definitions(path: Path) -> set[str]:
    """Functions, methods and classes of a file."""
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
    return {n.name for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, kinds)}


@pytest.mark.parametrize('walk', WALKS)
def test_files_and_functions_of_a_walk_exist(walk):
    words = re.findall(r'`([^`]+)`', WALKS[walk])
    room, there = PACKAGE, set()
    for word in words:
        if word.endswith('.py'):  # one without its room lies in the room of the one before
            path = PACKAGE / word if '/' in word else room / word
            assert path.exists(), word
            room, there = path.parent, there | definitions(path)
    names = [word for word in words if not word.endswith('.py') and word not in NOT_CODE]
    assert len(names) >= 7
    for name in names:
        assert set(name.split('.')) <= there, name


def test_there_are_two_walks():
    assert len(WALKS) == 2


def test_every_room_is_in_the_table():
    rooms = {path.parent.name for path in PACKAGE.glob('*/__init__.py')}
    assert rooms == set(re.findall(r'^\| `(\w+)/`', PAGE, flags=re.M))
