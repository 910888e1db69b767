"""The closed loop on ROS, every node a process: rates, latency, CPU, and how fast faults are noticed.

    python benchmarks/ros_loop.py [--seconds 10] [--repeats 20]
"""
import argparse
import os
import signal
import statistics
import tempfile
import time
from pathlib import Path

from wholearm_ros.ros import channels
from wholearm_ros.ros.client import Client
from wholearm_ros.ros.launcher import LOOP_PRIORITY
from wholearm_ros.ros.messages import values_of
from wholearm_ros.ros.processes import NodeDied, Processes

LOOP = ('hand_hardware', 'mode_switcher', 'velocity_controller', 'torque_controller')
NODES = (*LOOP, 'trajectory_generator', 'contact_state_planner')
WAIT = 120.0  # [s]


class Bench:
    """A graph in real time, held at the end of a run: the loop goes on for ever."""

    def __init__(self, scratch: Path, rate: float):
        self.processes = Processes(scratch)
        for node in NODES:
            own = {'priority': LOOP_PRIORITY} if node in LOOP else {}
            own.update({'motor_rate': rate} if node in ('hand_hardware', 'torque_controller') else {})
            own.update({'hold_time': 60.0} if node == 'hand_hardware' else {})  # stopped again and again, never limp
            self.processes.start(node, own)
        self.client, self.said, self.modes = Client(watch=self.processes.check), {}, []
        node = self.client.node
        node.create_subscription(channels.DIAGNOSTICS.type, channels.DIAGNOSTICS.name, self._hear, channels.DIAGNOSTICS.qos)
        node.create_subscription(channels.MODE.type, channels.MODE.name,
                                 lambda m: self.modes.append((time.monotonic(), m.data)), channels.MODE.qos)
        self.client.wait_for_graph(WAIT)
        assert self.client.call(channels.PLAN_SCENARIO, WAIT).success
        self.client.wait(lambda: self.client.heard.plan, WAIT, 'plan')

    def _hear(self, message):
        for status in message.status:
            self.said[status.name.split('/')[-1]] = values_of(status)

    def begin(self):
        self.modes.clear()
        self.client.send_goal(self.client.heard.plan.id)
        self.client.wait(lambda: any(mode not in ('idle', 'stopped') for _, mode in self.modes), WAIT, 'run')

    def hardware(self) -> dict:
        """Its newest report, made after this call."""
        self.said.pop('hand_hardware', None)
        self.client.wait(lambda: 'hand_hardware' in self.said, WAIT, 'diagnostics')
        return self.said['hand_hardware']

    def state(self) -> str:
        return self.said.get('hand_hardware', {}).get('state', '')

    def close(self):
        self.client.close()
        self.processes.stop()


def loop_figures(bench: Bench, seconds: float):
    """While the end of the run is held."""
    bench.begin()
    bench.client.wait(lambda: bench.client.heard.result, WAIT, 'result')
    cpu, before, began = {n: _cpu(bench.processes.pid(n)) for n in NODES}, bench.hardware(), time.monotonic()
    bench.client.wait(lambda: time.monotonic() - began > seconds, seconds + 5, 'time')
    after, passed = bench.hardware(), time.monotonic() - began
    steps = int(after['steps']) - int(before['steps'])
    print(f'  achieved {steps / passed:.0f} Hz, overruns {int(after["overruns"]) - int(before["overruns"])}, '
          f'behind the wall clock {float(after["behind the wall clock ms"]) - float(before["behind the wall clock ms"]):.1f} ms, '
          f'watchdog trips {int(after["watchdog trips"]) - int(before["watchdog trips"])}')
    print(f'  joint_states → command: p50 {float(after.get("command latency p50 ms", "nan")):.2f} ms, '
          f'p99 {float(after.get("command latency p99 ms", "nan")):.2f} ms (of those within their own period)')
    print('  CPU: ' + ', '.join(f'{n} {100 * (_cpu(bench.processes.pid(n)) - cpu[n]) / passed:.0f} %' for n in NODES))


def watchdog(bench: Bench, repeats: int) -> list:
    """ms from SIGSTOP of a controller to the drives' hold."""
    times, pid = [], bench.processes.pid('velocity_controller')
    for _ in range(repeats):
        bench.client.wait(lambda: bench.state() == 'driven', WAIT, 'driven')
        began = time.monotonic()
        os.kill(pid, signal.SIGSTOP)
        bench.client.wait(lambda: bench.state() == 'hold', WAIT, 'hold')
        times.append(1e3 * (time.monotonic() - began))
        os.kill(pid, signal.SIGCONT)
    return times


def emergency_stop(bench: Bench, repeats: int) -> list:
    """ms from the call of mode_switcher/stop to the mode `stopped`."""
    times = []
    for _ in range(repeats):
        assert bench.client.call(channels.RESET, WAIT).success
        bench.begin()
        bench.modes.clear()
        service = bench.client.node.create_client(channels.STOP.type, channels.STOP.name)
        bench.client.wait(service.service_is_ready, WAIT, 'stop')
        began = time.monotonic()
        service.call_async(channels.STOP.type.Request())
        bench.client.wait(lambda: any(mode == 'stopped' for _, mode in bench.modes), WAIT, 'stopped')
        times.append(1e3 * (bench.modes[0][0] - began))
        bench.client.wait(lambda: bench.client.heard.result, WAIT, 'result')
    return times


def dead_node(scratch: Path, repeats: int) -> list:
    """ms from SIGKILL of a node to the launcher's word."""
    times = []
    for _ in range(repeats):
        with Processes(scratch) as processes:
            processes.start('velocity_controller', {})
            client = Client(watch=processes.check)
            client.wait(lambda: client.node.count_publishers(channels.JOINT_COMMANDS.name), WAIT, 'controller')
            began = time.monotonic()
            os.kill(processes.pid('velocity_controller'), signal.SIGKILL)
            try:
                client.wait(lambda: False, WAIT, 'death')
            except NodeDied:
                times.append(1e3 * (time.monotonic() - began))
            client.close()
    return times


def _cpu(pid: int) -> float:
    """[s] of processor time so far."""
    fields = Path(f'/proc/{pid}/stat').read_text().rsplit(')', 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def _told(name: str, times: list, allowed: float):
    print(f'  {name}: median {statistics.median(times):.1f} ms, worst {max(times):.1f} ms of {len(times)} (wanted: {allowed} ms)')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--seconds', type=float, default=10.0)
    parser.add_argument('--repeats', type=int, default=20)
    options = parser.parse_args()
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    with tempfile.TemporaryDirectory() as scratch:
        for rate in (1000.0, 500.0):
            print(f'{rate:.0f} Hz', flush=True)
            bench = Bench(Path(scratch), rate)
            try:
                loop_figures(bench, options.seconds)
                _told('controller stopped → drives hold', watchdog(bench, options.repeats), 20)
                _told('mode_switcher/stop → stopped', emergency_stop(bench, options.repeats), 5)
            finally:
                bench.close()
        print('launcher')
        _told('node killed → noticed', dead_node(Path(scratch), options.repeats), 500)


if __name__ == '__main__':
    main()
