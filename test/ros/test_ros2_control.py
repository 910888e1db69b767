"""ros2_control in both directions: its drives as our hand, our stand-in as its robot. What stands
for its nodes behaves as their sources say (`ros2_control_rig.py`)."""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import ros2_control_rig
from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from wholearm_ros.control.command_watchdog import BRAKE, DRIVEN, HOLD, STOPPED, ZERO_TORQUE
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.joint_state_serialization import reading_of
from wholearm_ros.ros.interface.messages import effort_bytes, to_joints, values_of

pytestmark = pytest.mark.timeout(100)
RIG = Path(ros2_control_rig.__file__)
OURS = ros2_control_rig.OURS
RATE = 100.0
PATIENT = {'command_timeout': 0.2}  # machines may be loaded
SOFT = {'kp': 1.0, 'kd': 0.15}  # two periods of delay in the loop
ROBOT = {'backend': 'planar', 'motor_rate': RATE, 'command_stamps': 'arrival', **PATIENT}
COMMANDS = channels.Topic('/effort_controller/commands', Float64MultiArray, channels.NEWEST)
ROBOT_STATES = channels.Topic('/robot/joint_states', JointState, channels.RELIABLE)
CHANGE = channels.Service('ros2_control_bridge/change_state', ChangeState)


@pytest.fixture
def rig(domain):
    """`rig(options)` starts it; it ends with the test."""
    started = []

    def start(*options):
        started.append(subprocess.Popen([sys.executable, RIG, str(RATE), *options]))
        return started[-1]

    start.started = started
    yield start
    for process in started:
        process.kill()
        process.wait()


@pytest.fixture
def robot(graph):
    """Our stand-in as the robot behind JointStateTopicSystem; (graph, its health, its states)."""
    graph.processes.start('hand_hardware', {'pacing': 'realtime', **ROBOT}, '/robot')
    graph.client.watch = graph.processes.check
    return graph, health_of(graph, '/robot/hand_hardware'), graph.listen(ROBOT_STATES)


def health_of(graph, node):
    """The newest values that `node` reports on /diagnostics."""
    newest = {}

    def hear(message):
        for status in message.status:
            if status.name == node:
                newest.update(values_of(status), message=status.message)

    graph.node.create_subscription(DiagnosticArray, '/diagnostics', hear, channels.RELIABLE)
    return newest


def joints(states):
    return to_joints(reading_of(states[-1]))[1]


def test_the_stand_in_is_the_robot_of_somebodys_ros2_control(robot, rig):
    graph, health, states = robot
    process, commands = rig('--plain'), graph.talk(COMMANDS)
    graph.wait(lambda: int(health.get('refused messages', 0)) > 10, 'NaN commands')
    assert health['state'] == BRAKE, 'before the first command there are only NaN'
    told = Float64MultiArray(data=[-1.5, 1.75])
    graph.wait(lambda: commands.publish(told) or health['state'] == DRIVEN, 'commands')
    until, since = time.monotonic() + 1.5, int(health['left commands'])
    graph.wait(lambda: time.monotonic() > until, 'a constant torque')
    assert health['state'] == DRIVEN and int(health['late commands']) == 0, health
    assert int(health['left commands']) > since + 50
    assert joints(states).efforts.tolist() == [-1.5, 1.75]
    process.kill()
    graph.wait(lambda: health['state'] == ZERO_TORQUE, 'the watchdog')


def change(graph, transition):
    """Whether the bridge made it."""
    request = ChangeState.Request(transition=Transition(id=transition))
    return graph.client.call(CHANGE, 60.0, request).success


def bridged(graph, rig, *options):
    """Rig and bridge, configured; (the bridge's health, its joint states)."""
    rig(*options)
    graph.processes.start('ros2_control_bridge', {**OURS, **PATIENT, **SOFT, 'states_timeout': 1.0})
    health = health_of(graph, '/wholearm/ros2_control_bridge')
    ours = graph.listen(channels.JOINT_STATES)
    graph.wait(lambda: int(health.get('states', 0)) > 10, 'states of the broadcaster')
    assert not ours, 'not configured: nothing is passed on'
    assert change(graph, Transition.TRANSITION_CONFIGURE)
    graph.wait(lambda: ours and np.isfinite(joints(ours).angles).all(), 'joint states')
    return health, ours


def test_joints_are_mapped_and_the_motors_are_off_until_activated(robot, rig):
    graph, of_robot, theirs = robot
    graph.wait(lambda: of_robot and theirs, 'the robot')
    health, ours = bridged(graph, rig)
    commands = graph.listen(COMMANDS)
    assert np.allclose(joints(ours).angles, joints(theirs).angles, atol=1e-6)
    assert tuple(ours[-1].name) == ('left_finger_joint', 'right_finger_joint')
    now = graph.node.get_clock().now().nanoseconds
    assert abs(now - reading_of(ours[-1]).stamp) < 5e9, 'stamped here'
    talker = graph.talk(channels.JOINT_COMMANDS)
    talker.publish(effort_bytes(reading_of(ours[-1]).stamp, 0, 3.0))
    graph.spin(0.3)
    graph.wait(lambda: of_robot and health['lifecycle'] == 'inactive', 'reports')
    assert not commands and of_robot['state'] == BRAKE

    assert change(graph, Transition.TRANSITION_ACTIVATE)
    graph.wait(lambda: of_robot['state'] == DRIVEN, 'torques at the robot')
    held = joints(theirs).angles
    graph.spin(1.0)
    assert health['state'] == BRAKE and abs(joints(theirs).angles - held).max() < 0.3
    assert change(graph, Transition.TRANSITION_DEACTIVATE)
    graph.wait(lambda: not any(commands[-1].data), 'zero torque')
    heard = len(commands)
    graph.spin(0.3)
    assert len(commands) == heard, 'and silence'


def test_watchdog_stop_reset_and_states_that_end(robot, rig):
    graph, _, theirs = robot
    health, ours = bridged(graph, rig, '--no-effort')
    commands = graph.listen(COMMANDS)
    assert change(graph, Transition.TRANSITION_ACTIVATE)
    talker = graph.talk(channels.JOINT_COMMANDS)
    graph.wait(lambda: joints(ours).efforts.all(), 'efforts: the last ones that were told')
    weights = joints(ours).efforts

    def command():
        for joint in (0, 1):
            talker.publish(effort_bytes(reading_of(ours[-1]).stamp, joint, weights[joint] * 1.01))

    def commanded(state):
        command()
        return health['state'] == state

    graph.wait(lambda: commanded(DRIVEN), 'our commands')
    assert np.isfinite(weights).all() and abs(weights).max() > 0.01
    sent = OURS['signs'] * np.array(commands[-1].data)
    assert np.allclose(sent, weights * 1.01, atol=1e-9), 'their sign, ours is the other'
    graph.wait(lambda: health['state'] == HOLD, 'hold')
    graph.wait(lambda: health['state'] == ZERO_TORQUE, 'zero torque')
    assert not any(commands[-1].data)
    assert graph.client.call(channels.RESET, 60.0).success
    graph.wait(lambda: commanded(DRIVEN), 'commands after the reset')
    assert graph.client.call(channels.HARDWARE_STOP, 60.0).success
    graph.wait(lambda: commanded(STOPPED), 'the stop')
    assert any(commands[-1].data), 'it holds'
    rig.started[-1].kill()
    graph.wait(lambda: int(health['silences']) == 1, 'silence')
    graph.wait(lambda: not any(commands[-1].data), 'zero torque')
    assert 'no joint states' in health['message'] and health['state'] == STOPPED
