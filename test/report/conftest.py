"""One planned and executed run for all tests of the reports, and the same run as bags written without ROS."""

from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.model.hand import JOINT_NAMES
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.report.run_view import view_of
from wholearm_ros.simulation.closed_loop import run

CONFIG = Path(__file__).parents[2] / 'config'
CLOCK = 5.0  # [s] of the bag's stamps at the first setpoint
STORE = get_typestore(Stores.ROS2_JAZZY)


@pytest.fixture(scope='session')
def made():
    """(plan, trajectory, record) of the asymmetric hexagon on the planar hand."""
    scenario = load_scenario(CONFIG / 'asymmetric_hexagon.yaml')
    answer = plan_and_verify(scenario, PlanRequest(samples=2))
    return answer.plan, answer.trajectory, run(scenario, answer.trajectory, backend='planar')


@pytest.fixture(scope='session')
def told(made):
    """(plan, trajectory, run) as the figures take them."""
    plan, trajectory, record = made
    return plan, trajectory, view_of(record, plan.scenario)


@pytest.fixture(scope='session', params=['mcap', 'sqlite3'])
def bag(request, made, tmp_path_factory):
    path = tmp_path_factory.mktemp('bags') / request.param
    with Writer(path, version=9, storage_plugin=StoragePlugin[request.param.upper()]) as writer:
        _write(writer, *made)
    return path


@pytest.fixture(scope='session')
def bag_mcap(made, tmp_path_factory):
    """The run as an MCAP bag."""
    path = tmp_path_factory.mktemp('bags') / 'mcap'
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        _write(writer, *made)
    return path


@pytest.fixture
def bag_of_a_long_ramp(made, tmp_path):
    """Of a mode switcher with `ramp` 1.1 s."""
    path = tmp_path / 'bag'
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        _write(writer, *made, ramp=1.1)
    return path


def _write(writer, plan, trajectory, record, ramp=None):
    """ramp [s]: as the mode switcher of the run was told, on mode_switcher/progress; None: an old bag, without it."""
    t = STORE.types
    stamp = lambda s: t['builtin_interfaces/msg/Time'](int(s), round((s % 1.0) * 1e9))
    header = lambda s: t['std_msgs/msg/Header'](stamp(s), 'palm')
    string, joint = t['std_msgs/msg/String'], t['sensor_msgs/msg/JointState']
    connections = {}

    def put(topic, seconds, message):
        kind = message.__msgtype__
        if topic not in connections:
            connections[topic] = writer.add_connection(f'/wholearm/{topic}', kind, typestore=STORE)
        writer.write(connections[topic], round(seconds * 1e9), STORE.serialize_cdr(message, kind))

    put('contact_state_planner/contact_plan', 1.0, string(plan.to_json()))
    put('trajectory_generator/manipulation_trajectory', 2.0, string(trajectory.to_json()))
    put('mode_switcher/mode', CLOCK, string('dwell'))
    if ramp is not None:
        told = {
            'trajectory start': round((CLOCK + ramp) * 1e9),
            'stamp': round((CLOCK + 1.0) * 1e9),
        }
        pairs = [t['diagnostic_msgs/msg/KeyValue'](key, str(value)) for key, value in told.items()]
        status = t['diagnostic_msgs/msg/DiagnosticStatus'](0, 'switcher', '', '', pairs)
        put('mode_switcher/progress', CLOCK + 1.0, status)
    offset, ramp = CLOCK - record.times[0], ramp or ControlOptions().ramp
    for k, own in enumerate(record.times):
        s = own + offset
        names = list(JOINT_NAMES)[::-1]  # a hand may name them in any order
        put(
            'joint_states',
            s,
            joint(
                header(s),
                names,
                *(
                    np.array(values[k][::-1])
                    for values in (record.angles, record.velocities, record.efforts)
                ),
            ),
        )
        if own - record.times[0] <= ramp + trajectory.duration:
            put(
                'velocity_setpoint',
                s,
                joint(header(s), names[:1], np.zeros(1), np.zeros(1), np.zeros(1)),
            )
        if k % 10 == 0:
            x, y, turn = record.poses[k]
            pose = t['geometry_msgs/msg/Pose'](
                t['geometry_msgs/msg/Point'](x, y, 0.0),
                t['geometry_msgs/msg/Quaternion'](0.0, 0.0, np.sin(turn / 2), np.cos(turn / 2)),
            )
            put('object_pose', s, t['geometry_msgs/msg/PoseStamped'](header(s), pose))
    over = CLOCK + ramp + trajectory.duration
    values = {'outcome': 'succeeded', 'reason': 'led to its end', 'stamp': str(round(over * 1e9))}
    pairs = [t['diagnostic_msgs/msg/KeyValue'](key, value) for key, value in values.items()]
    put(
        'trajectory_generator/result',
        over,
        t['diagnostic_msgs/msg/DiagnosticStatus'](0, 'generator', '', '', pairs),
    )
