"""The launch file starts what the Python launcher starts, with the same parameters.

There is no wheel of `launch`: its few names are stood in for by records of what they were given. What `ros2 launch` makes of
the file is tried where ROS 2 is installed.
"""

import runpy
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from wholearm_ros.launcher.launcher import RunOptions, node_parameters
from wholearm_ros.model.choices import Hardware

FILE = Path(__file__).parents[2] / 'launch' / 'wholearm.launch.py'
NAMES = {
    'launch': ['LaunchDescription'],
    'launch.actions': [
        'DeclareLaunchArgument',
        'EmitEvent',
        'RegisterEventHandler',
        'SetEnvironmentVariable',
    ],
    'launch.conditions': ['IfCondition'],
    'launch.event_handlers': ['OnProcessExit'],
    'launch.events': ['Shutdown'],
    'launch.substitutions': ['LaunchConfiguration', 'PythonExpression'],
    'launch_ros': [],
    'launch_ros.actions': ['Node'],
    'launch_ros.parameter_descriptions': ['ParameterValue'],
}


class Record:
    """What it was made with."""

    def __init__(self, *given, **named):
        self.given, self.named = given, named


@pytest.fixture
def description(monkeypatch):
    for module, names in NAMES.items():
        stand_in = ModuleType(module)
        vars(stand_in).update({name: type(name, (Record,), {}) for name in names})
        monkeypatch.setitem(sys.modules, module, stand_in)
    parts = runpy.run_path(str(FILE))['generate_launch_description']().given[0]
    return {
        kind: [part for part in parts if type(part).__name__ == kind]
        for kind in ('DeclareLaunchArgument', 'Node', 'SetEnvironmentVariable')
    }


def test_the_nodes_and_their_parameters_are_those_of_the_launcher(description):
    started = {
        node.named['executable']: set(node.named['parameters'][-1]) for node in description['Node']
    }
    run = RunOptions('asymmetric_hexagon', record=Path('bag'))
    wanted = {
        **node_parameters(run),
        **node_parameters(replace(run, hardware=Hardware.ros2_control.value)),
    }
    assert started == {name: set(parameters) for name, parameters in wanted.items()}


def test_every_argument_is_used_and_every_used_one_is_declared_and_described(description):
    declared = {
        argument.given[0]: argument.named for argument in description['DeclareLaunchArgument']
    }
    assert all(
        told['description'] and isinstance(told['default_value'], str) for told in declared.values()
    )
    used = set()
    for part in (*description['Node'], *description['SetEnvironmentVariable']):
        used |= set(_configurations(part))
    assert used == set(declared)


def _configurations(part):
    """Names of the launch configurations anywhere in `part`."""
    if type(part).__name__ == 'LaunchConfiguration':
        yield part.given[0]
    elif isinstance(part, Record):
        for inner in (*part.given, *part.named.values()):
            yield from _configurations(inner)
    elif isinstance(part, (list, tuple)):
        for inner in part:
            yield from _configurations(inner)
    elif isinstance(part, dict):
        for inner in part.values():
            yield from _configurations(inner)
