"""What can go wrong on the real graph, and what each node does about it (docs/faults.md)."""
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rosbags.highlevel import AnyReader

from ros_graph import ALL
from wholearm_ros.ros import channels
from wholearm_ros.ros.bag_reader import Bag
from wholearm_ros.ros.messages import values_of
from wholearm_ros.ros.processes import NodeDied

pytestmark = [pytest.mark.faults, pytest.mark.timeout(200)]


def started_run(graph, pacing, **parameters):
    """The graph with a run under way; (modes, diagnostics by node)."""
    graph.start(ALL, pacing, **parameters)
    modes, said = graph.listen(channels.MODE), {}
    graph.node.create_subscription(channels.DIAGNOSTICS.type, channels.DIAGNOSTICS.name,
                                   lambda m: said.update({s.name.split('/')[-1]: s for s in m.status}),
                                   channels.DIAGNOSTICS.qos)
    graph.client.wait_for_graph(120.0)
    graph.client.send_goal(graph.plan().id)
    graph.wait(lambda: modes and modes[-1].data not in ('idle',), 'the run to begin')
    graph.client.watch = lambda: None
    return modes, said


@pytest.mark.parametrize('victim', ['velocity_controller', 'torque_controller', 'mode_switcher'])
def test_a_node_killed_while_running_leaves_the_hand_safe(graph, victim):
    modes, said = started_run(graph, 'realtime')
    os.kill(graph.processes.pid(victim), signal.SIGKILL)
    graph.wait(lambda: 'hand_hardware' in said and values_of(said['hand_hardware'])['state'] == 'limp', 'zero torque')
    assert said['hand_hardware'].level == DiagnosticStatus.ERROR
    assert int(values_of(said['hand_hardware'])['watchdog trips']) >= 1
    with pytest.raises(NodeDied, match=f'{victim} was killed by SIGKILL'):
        graph.processes.check()


def test_the_hardware_killed_while_running_stops_the_run(graph):
    modes, said = started_run(graph, 'realtime')
    os.kill(graph.processes.pid('hand_hardware'), signal.SIGKILL)
    graph.wait(lambda: graph.client.heard.result, 'result')
    assert graph.client.heard.result['outcome'] == 'aborted'
    assert 'no joint_states' in graph.client.heard.result['reason']
    assert modes[-1].data == 'stopped'


def test_a_stopped_and_continued_process_is_waited_for_in_lockstep(graph):
    started_run(graph, 'lockstep', hand_hardware={'motor_rate': 250.0}, torque_controller={'motor_rate': 250.0})
    pid = graph.processes.pid('velocity_controller')
    os.kill(pid, signal.SIGSTOP)
    graph.spin(1.0)
    os.kill(pid, signal.SIGCONT)
    graph.wait(lambda: graph.client.heard.result, 'result')
    assert graph.client.heard.result['outcome'] == 'succeeded'


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_a_killed_recorder_leaves_a_bag_that_opens(graph, tmp_path, storage):
    path = tmp_path / 'bag'
    graph.processes.start('bag_recorder', {'path': str(path), 'storage': storage})
    graph.start(('hand_hardware',), 'realtime')
    states = graph.listen(channels.JOINT_STATES)
    graph.wait(lambda: (path / 'metadata.yaml').exists() and len(states) > 1500, 'a second and a half of states')
    os.kill(graph.processes.pid('bag_recorder'), signal.SIGKILL)
    killed = states[-1].header.stamp.sec + 1e-9 * states[-1].header.stamp.nanosec
    with AnyReader([path]) as reader:
        assert reader.message_count > 0
    with Bag(path) as bag:
        stamps, _ = bag.joint_table('joint_states')
    assert killed - stamps[-1] < 1.0, 'at most the last second is lost'
    graph.client.watch = lambda: None


@pytest.mark.parametrize('node, parameters, told', [
    ('bag_recorder', {'path': '/proc/nowhere/bag'}, 'cannot be written'),
    ('bag_recorder', {'topics': ['nothing']}, 'allowed'),
    ('bag_player', {'path': '/nowhere'}, 'no such bag'),
    ('hand_hardware', {'motor_rate': 1e9}, 'motor_rate'),
    ('hand_hardware', {'pacing': 'slow'}, "'realtime', 'lockstep'"),
    ('velocity_controller', {'kp': float('nan')}, 'kp'),
    ('hand_hardware', {'scenario': '/nowhere.yaml'}, '/nowhere.yaml')])
def test_a_node_that_cannot_start_as_told_says_why(domain, tmp_path, node, parameters, told):
    command = [sys.executable, '-m', f'wholearm_ros.nodes.{node}', '--ros-args']
    for name, value in parameters.items():
        command += ['-p', f'{name}:={".nan" if value != value else value}']
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert done.returncode == 2 and told in done.stderr, done.stderr


def test_a_refused_parameter_says_why(graph):
    graph.start(('velocity_controller',))
    client = graph.node.create_client(SetParameters, 'velocity_controller/set_parameters')
    graph.wait(client.service_is_ready, 'parameter service')

    def set_to(name, value):
        request = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
        future = client.call_async(request)
        graph.wait(future.done, 'answer')
        return future.result().results[0]
    assert set_to('kp', 25.0).successful
    for name, value in (('kp', -1.0), ('kp', float('nan')), ('kp', 'high'), ('scenario', 'other')):
        refused = set_to(name, value)
        assert not refused.successful and refused.reason, name


@pytest.mark.parametrize('moment', ['starting', 'planning', 'executing'])
def test_ctrl_c_leaves_no_process_and_no_shared_memory(domain, tmp_path, moment):
    before = set(Path('/dev/shm').iterdir())
    run = subprocess.Popen([sys.executable, '-m', 'wholearm_ros', 'run', '--pacing', 'lockstep'], text=True,
                           stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    sign = {'starting': 'starting', 'planning': 'planning', 'executing': 'dwell'}[moment]
    lines = iter(run.stdout.readline, '')
    assert any(sign in line for line in lines)
    children = [int(pid) for task in Path(f'/proc/{run.pid}/task').iterdir()
                for pid in (task / 'children').read_text().split()]
    run.send_signal(signal.SIGINT)
    assert run.wait(timeout=60) == 130
    deadline = time.monotonic() + 10
    while any(Path(f'/proc/{pid}').exists() for pid in children) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not [pid for pid in children if Path(f'/proc/{pid}').exists()]
    ours = {p for p in set(Path('/dev/shm').iterdir()) - before if 'fast' in p.name}
    assert not {p for p in ours if not _used(p)}


def _used(path: Path) -> bool:
    for process in Path('/proc').glob('[0-9]*'):
        try:
            if str(path) in (process / 'maps').read_text():
                return True
        except OSError:  # ended meanwhile, or somebody else's
            continue
    return False
