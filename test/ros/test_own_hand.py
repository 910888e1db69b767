"""The example of a hand of one's own turns the hexagon in the place of `hand_hardware`."""

import subprocess
import sys
from pathlib import Path

import pytest

from wholearm_ros.ros.interface import channels

pytestmark = pytest.mark.timeout(280)
EXAMPLE = Path(__file__).parents[2] / 'examples' / '6_drive_your_own_hand.py'
OTHERS = (
    'mode_switcher',
    'velocity_controller',
    'torque_controller',
    'trajectory_generator',
    'contact_state_planner',
)


@pytest.fixture
def own_hand(domain):
    """The example as a process, in lockstep."""
    process = subprocess.Popen([sys.executable, EXAMPLE, '--ros-args', '-p', 'lockstep:=true'])
    yield process
    process.terminate()
    assert process.wait(20) == 0


def test_the_command_runs_with_a_hand_of_ones_own(own_hand):
    done = subprocess.run(
        [sys.executable, '-m', 'wholearm_ros', 'run', '--no-hardware', '--pacing', 'lockstep']
        + ['--rate', '250'],
        capture_output=True,
        text=True,
        timeout=200,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert 'was felt at its goal' in done.stdout and own_hand.poll() is None


def test_a_hand_of_ones_own_turns_the_hexagon_and_obeys_stop_and_reset(own_hand, graph):
    graph.start(OTHERS, torque_controller={'motor_rate': 250.0})
    graph.client.wait_for_graph(120.0)
    result = graph.execute(graph.plan().id)
    assert result['outcome'] == 'succeeded', result  # felt at the goal
    assert graph.client.call(channels.HARDWARE_STOP, 60.0).success
    assert graph.client.call(channels.RESET, 60.0).success
    assert own_hand.poll() is None
