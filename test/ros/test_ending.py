"""Every node ends by a signal in each phase of its life: exit code 0, in time, without a traceback."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest
from ros_graph import WAIT, WHOLE

from wholearm_ros.launcher.map_maker import POLITE
from wholearm_ros.model.scenario import CCW, GoalOnEdge, StartOnEdge
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.planner.face_map import Refused
from wholearm_ros.planner.map_store import MapStore
from wholearm_ros.ros.interface import channels

WITHIN = 3.0  # [s]
SIGNALS = [signal.SIGINT, signal.SIGTERM]
NODES = (
    'hand_hardware',
    'mode_switcher',
    'velocity_controller',
    'torque_controller',
    'trajectory_generator',
    'reorientation',
    'object_observer',
    'bag_recorder',
    'bag_player',
    'ros2_control_bridge',
)
BAG = Path(__file__).parents[2] / 'bags' / 'asymmetric_hexagon'
PLAYING = {
    'waits for subscribers': {'wait_for_subscribers': 600.0},
    'waits for the next message': {'rate': 0.001},
    'stays after the end': {'rate': 1000.0, 'topics': ['contact_plan'], 'stay': True},
}
QUICK = {
    'hand_hardware': {'motor_rate': 250.0, 'backend': 'planar'},
    'torque_controller': {'motor_rate': 250.0},
}


def started(node, *parameters, **environment):
    command = [sys.executable, '-m', f'wholearm_ros.nodes.{node}', '--ros-args']
    for parameter in parameters:
        command += ['-p', parameter]
    return subprocess.Popen(
        command,
        env={**os.environ, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def ended(process, number):
    """What it printed; fails unless it ended well and in time."""
    began = time.monotonic()
    process.send_signal(number)
    told, _ = process.communicate(timeout=60)
    assert time.monotonic() - began < WITHIN
    assert process.returncode == 0 and 'Traceback' not in told, told
    return told


@pytest.mark.parametrize('number', SIGNALS)
@pytest.mark.parametrize('node', NODES)
def test_a_node_alone_ends_by_a_signal(graph, node, number, tmp_path):
    """hand_hardware in real time has a thread that goes on stepping the hand."""
    path = {'bag_recorder': tmp_path / 'bag', 'bag_player': BAG}.get(node)
    parameters = [f'path:={path}'] if path else []
    said = graph.listen(channels.DIAGNOSTICS)
    process = started(node, *parameters)
    graph.wait(lambda: any(node in m.status[0].name for m in said), node)
    ended(process, number)


@pytest.mark.parametrize('number', SIGNALS)
def test_a_planner_that_compiles_its_kernels_ends_by_a_signal(graph, number, tmp_path):
    said = graph.listen(channels.PLANNER_STATUS)
    process = started('contact_state_planner', NUMBA_CACHE_DIR=str(tmp_path))
    graph.wait(lambda: any('compiled' in m.message for m in said), 'contact_state_planner')
    ended(process, number)
    assert not any(m.message == 'ready' for m in said)


@pytest.mark.parametrize('number', SIGNALS)
def test_a_planner_that_plans_ends_by_a_signal(graph, number):
    said = graph.listen(channels.PLANNER_STATUS)
    process = started('contact_state_planner', 'search:=random')
    graph.wait(lambda: any(m.message == 'ready' for m in said), 'contact_state_planner')
    service = channels.PLAN_SCENARIO
    client = graph.node.create_client(service.type, service.name)
    graph.wait(client.service_is_ready, service.name, WAIT)
    client.call_async(service.type.Request())
    graph.wait(lambda: any(m.message.startswith('planning') for m in said), 'planning')
    ended(process, number)


@pytest.mark.parametrize('doing', PLAYING)
def test_a_player_ends_by_a_signal(graph, doing):
    said = graph.listen(channels.DIAGNOSTICS)
    told = [f'{name}:={json.dumps(value)}' for name, value in PLAYING[doing].items()]
    process = started('bag_player', f'path:={BAG}', *told)
    graph.wait(lambda: said, 'bag_player')
    ended(process, signal.SIGTERM)


@pytest.mark.parametrize('mode', ['quasi_static', 'probing'])
def test_every_node_of_a_run_ends_by_a_signal(graph, mode, tmp_path):
    """All at once, as a machine does that is shut down: none can count on another."""
    nodes = (*WHOLE, 'bag_recorder')
    graph.start(nodes, **QUICK, bag_recorder={'path': str(tmp_path / 'bag')})
    graph.client.wait_for_graph(WAIT, recorded=True)
    graph.client.wait_for_supervisor(WAIT, recorded=True)
    graph.client.reorient()
    graph.wait(lambda: graph.client.latest.mode == mode, mode)
    graph.client.watch = lambda: None
    processes = {node: graph.processes._running[node] for node in nodes}

    began = time.monotonic()
    for process in processes.values():
        process.send_signal(signal.SIGTERM)
    left = {}
    for node, process in processes.items():
        assert process.wait(timeout=60) == 0, node
        left[node] = time.monotonic() - began  # at most: others were waited for before
    assert max(left.values()) < WITHIN, left
    said = {node: graph.processes.log_of(node).read_text() for node in nodes}
    assert not [node for node, told in said.items() if 'Traceback' in told], said


def test_a_planner_that_makes_a_map_publishes_it_and_ends_with_what_it_started(graph, tmp_path):
    scenario = load_scenario('asymmetric_hexagon')
    maps = graph.listen(channels.FACE_MAP)
    process = started(
        'contact_state_planner',
        'map_jobs:=1',
        WHOLEARM_MAPS=str(tmp_path),
    )

    graph.wait(lambda: maps and json.loads(maps[-1].data)['making'], 'a map', WAIT)
    (child,) = Path(f'/proc/{process.pid}/task/{process.pid}/children').read_text().split()
    assert os.getpriority(os.PRIO_PROCESS, int(child)) == POLITE
    start, goal = StartOnEdge(0, 0.0), GoalOnEdge(1, CCW)
    found = Refused(start, goal, 'as another process would keep it')
    MapStore(scenario, tmp_path).save(replace(scenario, start=start, goal=goal), found)
    graph.wait(lambda: found.to_dict() in json.loads(maps[-1].data)['refused'], 'what was found')
    ended(process, signal.SIGINT)
    limit = time.monotonic() + WAIT  # what is polite is slow to end on a busy machine
    while _state(child) not in ('', 'Z'):
        assert time.monotonic() < limit, 'the map is still being made'
        time.sleep(0.05)


STUCK = """
import ctypes
from wholearm_ros.ros.node.node import WholeArmNode
from wholearm_ros.ros.node.run import run_node
class Stuck(WholeArmNode):
    def destroy_node(self):
        ctypes.PyDLL(None).sleep(60)
run_node(lambda: Stuck('stuck', ()))
"""


def test_a_node_whose_middleware_keeps_the_interpreter_is_ended_by_the_kernel(graph):
    """PyDLL calls what waits without letting other threads run, as the middleware was seen to."""
    said = graph.listen(channels.DIAGNOSTICS)
    process = subprocess.Popen([sys.executable, '-c', STUCK])
    graph.wait(lambda: any('stuck' in s.name for m in said for s in m.status), 'stuck', WAIT)
    process.send_signal(signal.SIGTERM)
    assert process.wait(WITHIN) == -signal.SIGALRM


def _state(pid):
    """The letter of a process's state, '' when it is gone."""
    stat = Path(f'/proc/{pid}/stat')
    return stat.read_text().rpartition(')')[2].split()[0] if stat.exists() else ''
