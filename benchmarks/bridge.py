"""The closed loop with the drives under ros2_control against the stand-in alone: rate and latency, how fast watchdog, stop and
activation act, and whole runs of both hexagons. What stands for ros2_control is test/ros2_control_rig.py.

python benchmarks/bridge.py [--rate 500] [--seconds 10] [--repeats 20] [--runs 10]
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from std_msgs.msg import Float64MultiArray

sys.path.insert(0, str(Path(__file__).parents[1] / 'test'))
import ros2_control_rig
from ros_graph import Graph

from wholearm_ros.launcher.launcher import LOOP_PRIORITY
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.messages import values_of

LOOP = ('mode_switcher', 'velocity_controller', 'torque_controller', 'trajectory_generator')
WAIT = 120.0  # [s]
COMMANDS = channels.Topic('/effort_controller/commands', Float64MultiArray, channels.NEWEST)
BRIDGE = 'ros2_control_bridge'
CHANGE = channels.Service(f'{BRIDGE}/change_state', ChangeState)
PLANAR = {'pacing': 'realtime', 'backend': 'planar', 'priority': LOOP_PRIORITY}


@contextmanager
def robot(rate, scratch, scenario):
    """Our stand-in in /robot behind ros2_control, in a graph of its own."""
    graph, hand = Graph(scratch), {**PLANAR, 'motor_rate': rate, 'command_stamps': 'arrival'}
    graph.processes.start('hand_hardware', {**hand, 'scenario': scenario}, '/robot')
    rig = subprocess.Popen([sys.executable, ros2_control_rig.__file__, str(rate)])
    try:
        yield graph
    finally:
        rig.kill()
        rig.wait()
        graph.close()


def hold(graph, rate, hand):
    """Starts the loop and lets it feel: at the end it holds, and the loop goes on."""
    for name in LOOP[:3]:
        rated = {'motor_rate': rate} if name == 'torque_controller' else {}
        graph.processes.start(name, {'priority': LOOP_PRIORITY, **rated})
    graph.processes.start('trajectory_generator', {})
    graph.health, graph.modes = {}, graph.listen(channels.MODE)
    graph.node.create_subscription(
        channels.DIAGNOSTICS.type,
        channels.DIAGNOSTICS.name,
        lambda m: [graph.health.update(values_of(s)) for s in m.status if s.name == hand],
        channels.DIAGNOSTICS.qos,
    )
    graph.client.wait_for_subscribers(
        WAIT, ((channels.VELOCITY_SETPOINT, 1), (channels.TORQUE_SETPOINT, 1), (channels.GOAL, 1))
    )
    if hand.endswith(BRIDGE):
        graph.client.activate(BRIDGE, WAIT)
    feel(graph)


def feel(graph):
    graph.wait(lambda: graph.client.latest.progress.get('angles'), 'angles', WAIT)
    graph.client.feel()
    graph.wait(lambda: graph.client.latest.result, 'result', WAIT)


def loop_figures(graph, seconds, counted):
    """Rate of `counted` in the health of the hand, and its latency."""
    graph.spin(1.0)
    first, began = int(graph.health[counted]), time.monotonic()
    graph.spin(seconds)
    rate = (int(graph.health[counted]) - first) / (time.monotonic() - began)
    told = {k: round(float(v), 2) for k, v in graph.health.items() if k.startswith('command ')}
    return {'rate Hz': round(rate, 1), **told, 'trips': graph.health['watchdog trips']}


def until(graph, act, condition):
    """[ms] from `act()` to `condition()`, as this process hears of it."""
    began = time.monotonic()
    act()
    graph.wait(condition, 'reaction', 30.0)
    return 1e3 * (time.monotonic() - began)


def reactions(graph, repeats):
    """[ms] of watchdog, stop and activation."""
    found = {'watchdog': [], 'stop': [], 'activation': []}
    pid, state = graph.processes.pid('velocity_controller'), lambda: graph.health.get('state')
    commands, client = graph.listen(COMMANDS), graph.client
    for _ in range(repeats):
        graph.wait(lambda: state() == 'driven', 'the loop', 30.0)
        found['watchdog'].append(
            until(graph, lambda: os.kill(pid, signal.SIGSTOP), lambda: state() == 'hold')
        )
        os.kill(pid, signal.SIGCONT)
        graph.wait(lambda: state() == 'driven', 'the loop', 30.0)
        found['stop'].append(
            until(
                graph,
                lambda: client.call(channels.HARDWARE_STOP, 30.0),
                lambda: state() == 'stopped',
            )
        )
        client.call(channels.RESET, 30.0)
        change(client, Transition.TRANSITION_DEACTIVATE)
        graph.spin(0.2)
        commands.clear()
        found['activation'].append(
            until(graph, lambda: change(client, Transition.TRANSITION_ACTIVATE), lambda: commands)
        )
        graph.spin(0.2)
        feel(graph) if state() != 'driven' else None
    return {
        name: f'p50 {np.median(times):.1f} ms, worst {max(times):.1f} ms, n = {len(times)}'
        for name, times in found.items()
    }


def change(client, transition):
    client.call(CHANGE, 30.0, ChangeState.Request(transition=Transition(id=transition)))


def whole_run(rate, scenario):
    """The command on a fresh robot: its exit code and first line."""
    with tempfile.TemporaryDirectory() as scratch, robot(rate, Path(scratch), scenario):
        params = Path(scratch) / 'params.yaml'
        told = {'/**/' + BRIDGE: {'ros__parameters': ros2_control_rig.OURS}}
        params.write_text(json.dumps(told))
        done = subprocess.run(
            [sys.executable, '-m', 'wholearm_ros', 'run', scenario, '--hardware', 'ros2_control']
            + ['--rate', str(rate), '--params', params],
            capture_output=True,
            text=True,
        )
    lines = [s for s in done.stdout.splitlines() if s.startswith(('success', 'not ', 'failed'))]
    return done.returncode == 0, (lines or done.stderr.splitlines() or [''])[-1]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--rate', type=float, default=500.0)
    parser.add_argument('--seconds', type=float, default=10.0)
    parser.add_argument('--repeats', type=int, default=20)
    parser.add_argument('--runs', type=int, default=10)
    options = parser.parse_args()
    print(f'load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores, {options.rate:.0f} Hz')
    with tempfile.TemporaryDirectory() as scratch:
        graph = Graph(Path(scratch))
        try:
            graph.processes.start('hand_hardware', {**PLANAR, 'motor_rate': options.rate})
            hold(graph, options.rate, '/wholearm/hand_hardware')
            print('stand-in alone:', loop_figures(graph, options.seconds, 'steps'), flush=True)
        finally:
            graph.close()
        with robot(options.rate, Path(scratch), 'asymmetric_hexagon') as graph:
            own = {'priority': LOOP_PRIORITY, 'hold_time': 60.0}
            graph.processes.start(BRIDGE, {**ros2_control_rig.OURS, **own})
            hold(graph, options.rate, f'/wholearm/{BRIDGE}')
            print('by the bridge:', loop_figures(graph, options.seconds, 'states'), flush=True)
            if options.repeats:
                print('reactions:', reactions(graph, options.repeats), flush=True)
    for scenario in ('asymmetric_hexagon', 'regular_hexagon'):
        results = [whole_run(options.rate, scenario) for _ in range(options.runs)]
        good = sum(success for success, _ in results)
        print(f'{scenario}: {good} of {len(results)};', *{line for _, line in results}, flush=True)


if __name__ == '__main__':
    main()
