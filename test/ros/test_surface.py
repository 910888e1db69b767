"""What people expect of any node: namespaces, remapping, simulated time, parameter files."""

import json
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import GetParameters
from ros_graph import ALL, WAIT, Graph

from wholearm_ros.launcher.client import GraphError
from wholearm_ros.model.scenario_file import load_scenario, scenario_to_dict
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.messages import NANOSECONDS, to_nanoseconds
from wholearm_ros.ros.node.node import DOUBLE

pytestmark = pytest.mark.timeout(280)
FRAMES = (channels.PALM_FRAME, channels.OBJECT_FRAME, *channels.FINGER_FRAMES)
CONTROL = Path(__file__).parents[2] / 'config' / 'control.yaml'


@pytest.fixture
def node_process(domain):
    """Starts a node with arguments after --ros-args; ends it."""
    started = []

    def start(node, *arguments):
        started.append(
            subprocess.Popen(
                [sys.executable, '-m', f'wholearm_ros.nodes.{node}', '--ros-args', *arguments]
            )
        )

    yield start
    for process in started:
        process.terminate()
        assert process.wait(timeout=30) == 0


def test_another_namespace_and_a_remapped_topic(graph, node_process):
    node_process(
        'velocity_controller',
        '-r',
        '__ns:=/second/hand',
        '-r',
        '__node:=pd',
        '-r',
        'joint_commands:=/drive/commands',
    )
    names = graph.node.get_node_names_and_namespaces
    graph.wait(lambda: ('pd', '/second/hand') in names(), 'the node')
    graph.wait(lambda: graph.node.count_publishers('/drive/commands') == 1, 'its remapped commands')
    graph.wait(
        lambda: graph.node.count_subscribers('/second/hand/joint_states') == 1, 'its joint states'
    )
    assert graph.node.count_publishers('/wholearm/joint_commands') == 0


@pytest.fixture
def two_hands(domain, tmp_path):
    """Two whole graphs in lockstep, each in a namespace of its own and with an object of its own."""
    hands, scenario = {}, scenario_to_dict(load_scenario('asymmetric_hexagon'))
    for side, mass in (('left', 0.353), ('right', 0.34)):
        (tmp_path / side).mkdir()
        scenario['object']['mass'] = mass
        hands[side], told = Graph(tmp_path / side, side), {'scenario': json.dumps(scenario)}
        hands[side].start(
            (*ALL, 'object_observer'),
            **{node: told for node in ('contact_state_planner', 'object_observer')},
            hand_hardware={**told, 'motor_rate': 250.0, 'backend': 'planar'},
            torque_controller={**told, 'motor_rate': 250.0},
            velocity_controller=told,
            trajectory_generator=told,
        )
    yield hands
    for hand in hands.values():
        hand.close()


def test_two_hands_in_two_namespaces_of_one_domain(two_hands):
    """Both turn their objects at once; on /tf, which they share, no frame of one is the other's."""
    telling = (channels.MARKERS, channels.TRANSFORMS, channels.OBJECT_POSE)
    telling += (channels.OBJECT_ESTIMATE, channels.JOINT_TRAJECTORY, channels.ROBOT_DESCRIPTION)
    heard = {
        side: {topic: hand.listen(topic) for topic in telling} for side, hand in two_hands.items()
    }
    for hand in two_hands.values():
        hand.client.wait_for_graph(WAIT)
        hand.plan()
    assert len({hand.client.latest.plan.id for hand in two_hands.values()}) == 2
    for hand in two_hands.values():
        hand.client.send_goal(hand.client.latest.plan.id)
    for side, hand in two_hands.items():
        hand.wait(lambda: hand.client.latest.result, 'result')
        assert hand.client.latest.result['outcome'] == 'succeeded', side
        assert hand.client.latest.poses, 'poses in the frame of its palm'

        palm, *others = (f'{side}/{name}' for name in FRAMES)
        told = heard[side]
        hand.wait(lambda: all(told.values()), 'every topic')
        frames = {m.child_frame_id for m in told[channels.TRANSFORMS]}
        assert frames == set(others)
        stamped = [
            *(marker for array in told[channels.MARKERS] for marker in array.markers),
            *(m for topic in telling[1:5] for m in told[topic]),
        ]
        assert {m.header.frame_id for m in stamped} == {palm}
        links = ElementTree.fromstring(told[channels.ROBOT_DESCRIPTION][-1].data).iter('link')
        assert {link.get('name') for link in links} == {palm, *others[1:]}

        for frame, allowed in ((palm, True), ('palm', False)):
            request = channels.PLAN.type.Request()
            request.start.header.frame_id = request.goal.header.frame_id = frame
            answer = hand.client.call(channels.PLAN, WAIT, request)
            assert answer.plan.header.frame_id == palm
            reason = hand.client.latest.planner['message']
            assert ('frame_id' not in reason) == allowed, reason


def test_frames_of_the_default_namespace_have_their_plain_names():
    assert channels.frame_in('/wholearm', 'palm') == channels.frame_in('/', 'palm') == 'palm'
    assert channels.frame_in('/lab/left', 'palm') == 'lab/left/palm'


def test_a_second_node_of_one_name_is_noticed_by_both_and_by_the_launcher(graph, node_process):
    told = []
    graph.node.create_subscription(DiagnosticArray, '/diagnostics', told.append, channels.RELIABLE)
    graph.client.wait_until_alone(['velocity_controller'], 5.0)
    for _ in range(2):
        node_process('velocity_controller')
    graph.wait(
        lambda: [s.message for m in told[-2:] for s in m.status] == [DOUBLE, DOUBLE], 'both say so'
    )
    with pytest.raises(GraphError, match='velocity_controller: there already'):
        graph.client.wait_until_alone(['velocity_controller'], 2.0)


def test_simulated_time_is_honoured(graph, node_process):
    graph.start(('hand_hardware',))  # in lockstep: it publishes /clock, which stands at one second
    told = []
    graph.node.create_subscription(DiagnosticArray, '/diagnostics', told.append, channels.RELIABLE)
    node_process('trajectory_generator', '-p', 'use_sim_time:=true')

    def stamps():
        return [
            to_nanoseconds(m.header.stamp)
            for m in told
            if m.status[0].name.endswith('/trajectory_generator')
        ]

    graph.wait(lambda: NANOSECONDS in stamps(), 'a report at simulated time')


def test_a_parameter_file(graph, node_process, tmp_path):
    file = tmp_path / 'control.yaml'
    file.write_text(CONTROL.read_text().replace('kp: 30.0', 'kp: 12.5'))
    node_process('velocity_controller', '--params-file', str(file))
    answer = graph.client.call(
        channels.Service('velocity_controller/get_parameters', GetParameters),
        60.0,
        GetParameters.Request(names=['kp', 'kd']),
    )
    assert [v.double_value for v in answer.values] == [12.5, 0.85]
