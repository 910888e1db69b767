"""ros2_control in both directions: its drives as our hand, our stand-in as its robot. What stands
for its nodes behaves as their sources say (`ros2_control_rig.py`)."""

import json
import subprocess
import sys
import time
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import ros2_control_rig
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from wholearm_ros import load_scenario
from wholearm_ros.control.command_watchdog import BRAKE, DRIVEN, HOLD, STOPPED, ZERO_TORQUE
from wholearm_ros.launcher.client import GraphError
from wholearm_ros.model.hand import JOINT_NAMES
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.nodes.ros2_control_bridge import DECLARED
from wholearm_ros.package_share import share_directory, shipped_scenarios
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.joint_state_serialization import reading_of
from wholearm_ros.ros.interface.messages import effort_bytes, to_joints, values_of
from wholearm_ros.ros.visualization.robot_description import topic_system, urdf

pytestmark = pytest.mark.timeout(100)
RIG = Path(ros2_control_rig.__file__)
OURS = ros2_control_rig.OURS
RATE = 100.0
PATIENT = {'command_timeout': 0.2, 'hold_time': 0.5}  # machines may be loaded
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


def test_an_active_bridge_ends_by_a_signal_and_leaves_zero_torque(robot, rig):
    graph, of_robot, _ = robot
    bridged(graph, rig)
    commands = graph.listen(COMMANDS)
    assert change(graph, Transition.TRANSITION_ACTIVATE)
    graph.wait(lambda: commands and any(commands[-1].data), 'torques that hold the fingers')
    graph.client.watch = lambda: None
    process, began = graph.processes._running['ros2_control_bridge'], time.monotonic()
    process.terminate()
    assert process.wait(timeout=60) == 0
    assert time.monotonic() - began < 3.0
    graph.wait(lambda: not any(commands[-1].data), 'zero torque')
    assert 'Traceback' not in graph.processes.log_of('ros2_control_bridge').read_text()


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


def test_the_hand_feels_through_the_bridge(robot, rig):
    """The whole loop but the planner; whether what is felt is right is a matter of the rate."""
    graph, _, states = robot
    graph.wait(lambda: states, 'the robot')
    rig()
    loop = {'probe': True, 'joint_states_timeout': 2.0, 'max_tracking_error': 3.0}
    graph.start(
        ('mode_switcher', 'velocity_controller', 'torque_controller', 'trajectory_generator'),
        'realtime',
        mode_switcher=loop,
        velocity_controller=SOFT,
        torque_controller={'motor_rate': RATE},
    )
    own = {**OURS, **PATIENT, **SOFT, 'states_timeout': 1.0}
    graph.processes.start('ros2_control_bridge', own)
    modes = graph.listen(channels.MODE)
    graph.client.wait_for_subscribers(60.0, ((channels.JOINT_COMMANDS, 1), (channels.GOAL, 1)))
    graph.client.wait_for_subscribers(60.0, ((channels.VELOCITY_SETPOINT, 1),))
    graph.client.activate('ros2_control_bridge', 30.0)
    graph.wait(lambda: graph.client.latest.progress.get('angles'), 'angles')
    before = joints(states).angles
    graph.client.feel()
    moved = 0.0

    def ended():
        nonlocal moved
        moved = max(moved, float(abs(joints(states).angles - before).max()))
        return graph.client.latest.result

    graph.wait(ended, 'result', 60.0)
    assert 'probing' in [m.data for m in modes], graph.client.latest.result
    assert moved > 0.05, 'the fingers were opened and closed'


@pytest.mark.faults
@pytest.mark.timeout(280)
def test_the_command_runs_on_drives_under_ros2_control(robot, rig, tmp_path):
    """Whether a real-time run on a loaded machine reaches its goal is for `benchmarks/bridge.py`."""
    graph, _, states = robot
    graph.wait(lambda: states, 'the robot')
    rig()
    params = tmp_path / 'drives.yaml'
    own = {**OURS, **PATIENT, **SOFT, 'states_timeout': 1.0}
    params.write_text(json.dumps({'/**/ros2_control_bridge': {'ros__parameters': own}}))
    before = joints(states).angles
    done = subprocess.run(
        [sys.executable, '-m', 'wholearm_ros', 'run', '--hardware', 'ros2_control']
        + ['--params', params, '--rate', str(RATE), '--attempts', '1'],
        capture_output=True,
        text=True,
        timeout=200,
    )
    told = done.stdout + done.stderr
    assert done.returncode in (0, 1) and 'activating the motors' in told, told
    assert '1. attempt' in told and 'failed:' not in told, told
    graph.spin(0.5)
    assert abs(joints(states).angles - before).max() > 0.2, 'the fingers were moved'


def test_drives_that_are_not_there_are_said_to_be(graph):
    graph.processes.start('ros2_control_bridge', {})
    graph.client.wait_for_publishers(60.0, ((channels.JOINT_STATES, 1),))
    graph.wait(lambda: graph.client.latest.told_by, 'diagnostics')
    with pytest.raises(GraphError, match='not active after 2 s: no joint states on /joint_states'):
        graph.client.activate('ros2_control_bridge', 2.0)


def test_a_finger_that_is_no_rectangle_is_described_by_boxes_of_its_area_and_centre():
    scenario = load_scenario('hooked_fingers')
    robot = ElementTree.fromstring(urdf(scenario))
    for link, finger in zip(robot.findall('link')[1:], (scenario.hand.left, scenario.hand.right)):
        boxes = link.findall('collision')
        places = [list(map(float, b.find('origin').get('xyz').split())) for b in boxes]
        sizes = [list(map(float, b.find('geometry/box').get('size').split())) for b in boxes]
        shaft, hook = finger.shape.parts
        assert len(boxes) == 24, 'twelve a part'
        for part, its in ((Polygon(shaft), slice(0, 12)), (Polygon(hook), slice(12, 24))):
            areas = np.array([x * y for x, y, _ in sizes[its]])
            assert areas.sum() == pytest.approx(part.area, rel=0.02)
            centre = areas @ np.array(places[its])[:, :2] / areas.sum()
            np.testing.assert_allclose(centre, part.centroid, atol=2e-4)
        told = link.find('inertial/origin').get('xyz').split()
        np.testing.assert_allclose([float(v) for v in told[:2]], finger.shape.centre, atol=1e-6)


def test_the_shipped_description_and_controllers_are_those_of_the_code():
    config = share_directory() / 'config'
    made = urdf(load_scenario('asymmetric_hexagon'), topic_system('/robot'))
    assert (config / 'ros2_control.urdf').read_text() == made
    system = ElementTree.fromstring(made).find('ros2_control')
    assert [j.get('name') for j in system.findall('joint')] == list(JOINT_NAMES)
    assert all(
        [c.get('name') for c in j.findall('command_interface')] == ['effort']
        for j in system.findall('joint')
    )
    told = yaml.safe_load((config / 'ros2_control.yaml').read_text())
    bridge = told['/wholearm/ros2_control_bridge']['ros__parameters']
    declared = {p.name: p.default for p in DECLARED}
    assert bridge == {name: declared[name] for name in bridge}, 'as the defaults'
    assert told['effort_controller']['ros__parameters']['joints'] == bridge['joints']
    assert 'ros2_control' not in shipped_scenarios()
