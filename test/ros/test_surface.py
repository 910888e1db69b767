"""What people expect of any node: namespaces, remapping, simulated time, parameter files."""

import subprocess
import sys
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import GetParameters

from wholearm_ros.launcher.client import Client, GraphError
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.messages import NANOSECONDS, to_nanoseconds
from wholearm_ros.ros.node.node import DOUBLE

pytestmark = pytest.mark.timeout(280)
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


def test_two_graphs_in_two_namespaces_do_not_hear_each_other(graph):
    graph.start(('hand_hardware',))
    with graph.processes.__class__(graph.processes.log_of('x').parent / '..') as others:
        others.start(
            'hand_hardware',
            {'pacing': 'lockstep', 'scenario': 'regular_hexagon'},
            namespace='/other',
        )
        second = Client(name='other_client', namespace='/other')
        try:
            described = graph.listen(channels.ROBOT_DESCRIPTION)
            heard = []
            second.node.create_subscription(
                channels.ROBOT_DESCRIPTION.type,
                channels.ROBOT_DESCRIPTION.name,
                heard.append,
                channels.LATCHED,
            )
            graph.wait(lambda: described, 'the first description')
            second.wait(lambda: heard, 60.0, 'the second description')
            assert len(described) == len(heard) == 1
        finally:
            second.close()


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
