"""docs/paper_map.md names functions and tests that exist."""

import ast
import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / 'docs' / 'paper_map.md').read_text(encoding='utf-8')
NAMES = set(re.findall(r'`([^`]+)`', PAGE))
FUNCTIONS = sorted(
    n
    for n in NAMES
    if re.match(r'(kernels|mechanics|rollout|planning|trajectory|planner|simulation)\.[\w.]+$', n)
    and not n.endswith('.py')
)
TESTS = sorted(n for n in NAMES if '::' in n)


def test_the_page_names_enough_to_be_worth_holding_to():
    assert len(FUNCTIONS) > 35 and len(TESTS) > 40
    for equation in range(1, 7):
        assert f'| ({equation})' in PAGE
    for algorithm in ('MAIN_RANDOM_SEARCH', 'NEW_SUBGOAL', 'MAIN_TRAJECTORY', 'GET_TORQUE'):
        assert f'## {algorithm}' in PAGE


@pytest.mark.parametrize('name', FUNCTIONS)
def test_a_function_named_there_exists(name):
    parts = name.split('.')
    depth = 2
    thing = importlib.import_module('.'.join(['wholearm_ros', *parts[:depth]]))
    for part in parts[depth:]:
        thing = getattr(thing, part)
    assert callable(thing) or isinstance(thing, property)


@pytest.mark.parametrize('name', TESTS)
def test_a_test_named_there_exists(name):
    path, test = name.split('::')
    tree = ast.parse((ROOT / 'test' / path).read_text(encoding='utf-8'))
    assert test in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def test_fields_named_there_exist():
    """`Class.field` of the table of symbols."""
    classes = {
        'QuasiStatics': 'mechanics.quasistatic',
        'TorqueRange': 'mechanics.torque_range',
        'World': 'mechanics.world',
        'ManipulationTrajectory': 'model.trajectory',
        'Finger': 'model.hand',
        'ExecutionOptions': 'trajectory.execution_options',
        'Subgoal': 'model.plan',
        'SearchOptions': 'planning.routes',
        'ControlMode': 'trajectory.control_mode',
    }
    named = [n.split('.') for n in NAMES if n.split('.')[0] in classes and n.count('.') == 1]
    assert len(named) > 10
    for owner, field in named:
        thing = getattr(importlib.import_module(f'wholearm_ros.{classes[owner]}'), owner)
        fields = getattr(thing, '__dataclass_fields__', ())
        assert field in fields or hasattr(thing, field), f'{owner}.{field}'
