"""The closed loop on ROS, every node a process: rate, latency, losses, processor time, and how fast faults are noticed.

python benchmarks/ros_loop.py [--rates 1000 500] [--seconds 10] [--repeats 20] [--observer]
"""

import argparse
import os
import signal
import statistics
import tempfile
import time
from pathlib import Path

from wholearm_ros.launcher.client import Client, GraphError
from wholearm_ros.launcher.launcher import LOOP_PRIORITY
from wholearm_ros.launcher.processes import NodeDied, Processes
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.joint_state_serialization import NANOSECONDS, read_joints
from wholearm_ros.ros.interface.messages import to_nanoseconds, values_of

LOOP = ('hand_hardware', 'mode_switcher', 'velocity_controller', 'torque_controller')
NODES = [*LOOP, 'trajectory_generator', 'contact_state_planner']
OBSERVER_PRIORITY = LOOP_PRIORITY + 10  # so that the measurer's own waiting is not measured
MOVING = 1e-3  # [rad/s] of a setpoint
WAIT = 120.0  # [s]


class Bench:
    """A graph in real time, held at the end of a run: the loop goes on for ever."""

    def __init__(self, scratch: Path, rate: float, make_processes=Processes):
        self.processes, self.period = make_processes(scratch), round(NANOSECONDS / rate)
        for node in NODES:
            own = {'priority': LOOP_PRIORITY} if node in LOOP else {}
            own.update(
                {'motor_rate': rate} if node in ('hand_hardware', 'torque_controller') else {}
            )
            own.update(
                {'hold_time': 60.0} if node == 'hand_hardware' else {}
            )  # stopped again and again, never at zero torque
            self.processes.start(node, own)
        self.client, self.said, self.modes = Client(watch=self.processes.check), {}, []
        node = self.client.node
        node.create_subscription(
            channels.DIAGNOSTICS.type,
            channels.DIAGNOSTICS.name,
            self._hear,
            channels.DIAGNOSTICS.qos,
        )
        node.create_subscription(
            channels.MODE.type,
            channels.MODE.name,
            lambda m: self.modes.append((time.monotonic(), m.data)),
            channels.MODE.qos,
        )
        _observe_first()
        try:
            self.client.wait_for_graph(WAIT)
            assert self.client.call(channels.PLAN_SCENARIO, WAIT).success
            self.client.wait(lambda: self.client.latest.plan, WAIT, 'plan')
        except GraphError:
            self.close()
            raise

    def _hear(self, message):
        for status in message.status:
            values = values_of(status)
            self.said[status.name.split('/')[-1]] = {
                **values,
                'heard': time.monotonic(),
                'told': to_nanoseconds(message.header.stamp) / NANOSECONDS,
            }

    def begin(self):
        self.modes.clear()
        self.client.send_goal(self.client.latest.plan.id)
        self.client.wait(
            lambda: any(mode not in ('idle', 'stopped') for _, mode in self.modes), WAIT, 'run'
        )

    def reports(self) -> dict:
        """The newest of each node of the loop, made after this call."""
        self.said.clear()
        self.client.wait(lambda: set(LOOP) <= set(self.said), WAIT, 'diagnostics')
        return {node: dict(self.said[node]) for node in LOOP}

    def state(self) -> str:
        return self.said.get('hand_hardware', {}).get('state', '')

    def close(self):
        self.client.close()
        self.processes.stop()


def loop_figures(bench: Bench, seconds: float) -> dict:
    """While the end of the run is held."""
    bench.begin()
    bench.client.wait(lambda: bench.client.latest.result, WAIT, 'result')
    before, began, cpu = bench.reports(), time.monotonic(), _cpu_of(bench)
    bench.client.wait(lambda: time.monotonic() - began > seconds, seconds + 5, 'time')
    cpu = {
        name: 100 * (used - cpu[name]) / (time.monotonic() - began)
        for name, used in _cpu_of(bench).items()
    }
    cpu['everybody else'] = cpu.pop('machine') - sum(cpu.values())
    after = bench.reports()

    def grown(node, key):
        return float(after[node][key]) - float(before[node][key])

    def lost(node, count, stamp):
        """How many of the stamps that passed `node` did not see: its own count against its own newest stamp."""
        return round(grown(node, stamp) / bench.period - grown(node, count))

    hardware, newest = (
        after['hand_hardware'],
        float(after['hand_hardware'].get('command latency p50 ms', 'nan')),
    )
    return {
        'rate Hz': grown('hand_hardware', 'steps') / grown('hand_hardware', 'told'),
        'periods': round(grown('hand_hardware', 'steps')),
        'answered p50 ms': newest,
        'answered p99 ms': float(hardware.get('command latency p99 ms', 'nan')),
        'applied p50 ms': float(hardware.get('command applied p50 ms', 'nan')),
        'applied p99 ms': float(hardware.get('command applied p99 ms', 'nan')),
        'overruns': round(grown('hand_hardware', 'overruns')),
        'slipped ms': grown('hand_hardware', 'slipped ms'),
        'watchdog trips': round(grown('hand_hardware', 'watchdog trips')),
        'lost': {
            'states at the switcher': lost('mode_switcher', 'states', 'stamp'),
            'states at the velocity controller': lost('velocity_controller', 'states', 'stamp'),
            'states at the torque controller': lost('torque_controller', 'states', 'stamp'),
            'velocity setpoints': lost('velocity_controller', 'commands', 'newest command'),
            'torque setpoints': lost('torque_controller', 'commands', 'newest command'),
            'commands': sum(
                lost('hand_hardware', f'{side} commands', f'{side} newest')
                for side in ('left', 'right')
            ),
        },
        'CPU %': cpu,
    }


def watchdog(bench: Bench, repeats: int) -> list:
    """ms from SIGSTOP of a controller to the drives' hold."""
    times, pid = [], bench.processes.pid('velocity_controller')
    for _ in range(repeats):
        bench.reports()
        bench.client.wait(lambda: bench.state() == 'driven', WAIT, 'driven')
        began = time.monotonic()
        os.kill(pid, signal.SIGSTOP)
        bench.client.wait(lambda: bench.state() == 'hold', WAIT, 'hold')
        times.append(1e3 * (bench.said['hand_hardware']['heard'] - began))
        os.kill(pid, signal.SIGCONT)
    return times


def hardware_stop(bench: Bench, repeats: int) -> list:
    """ms from the call of hand_hardware/stop to the word of the motors that they hold, sent after the step that did."""
    times = []
    service = bench.client.node.create_client(
        channels.HARDWARE_STOP.type, channels.HARDWARE_STOP.name
    )
    for _ in range(repeats):
        assert bench.client.call(channels.RESET, WAIT).success
        bench.begin()
        bench.reports()
        bench.client.wait(
            lambda: bench.state() == 'driven' and service.service_is_ready(), WAIT, 'driven'
        )
        began = time.monotonic()
        service.call_async(channels.HARDWARE_STOP.type.Request())
        bench.client.wait(lambda: bench.state() == 'stopped', WAIT, 'stopped')
        times.append(1e3 * (bench.said['hand_hardware']['heard'] - began))
        bench.client.cancel()
        bench.client.wait(lambda: bench.client.latest.result, WAIT, 'result')
    return times


def switcher_stop(bench: Bench, repeats: int) -> list:
    """ms from the call of mode_switcher/stop, while the velocity finger moves, to the joint state after the first command
    for a setpoint at rest."""
    times, node, heard = [], bench.client.node, _Heard()
    topics = (channels.VELOCITY_SETPOINT, channels.JOINT_COMMANDS, channels.JOINT_STATES)
    ears = [
        node.create_subscription(
            t.type, t.name, lambda data, t=t: heard.take(t, read_joints(data)), t.qos, raw=True
        )
        for t in topics
    ]
    service = node.create_client(channels.STOP.type, channels.STOP.name)
    for _ in range(repeats):
        assert bench.client.call(channels.RESET, WAIT).success
        bench.begin()
        heard.begin()
        bench.client.wait(lambda: heard.moving and service.service_is_ready(), WAIT, 'motion')
        began = time.monotonic()
        service.call_async(channels.STOP.type.Request())
        bench.client.wait(lambda: heard.acted, WAIT, 'stop')
        times.append(1e3 * (heard.acted - began))
        bench.client.wait(lambda: bench.client.latest.result, WAIT, 'result')
    for ear in ears:
        node.destroy_subscription(ear)
    return times


class _Heard:
    """Follows a stop along the loop: setpoint at rest, its command, the joint state after it."""

    def begin(self):
        self.moving, self.setpoint, self.command, self.acted = False, None, None, None

    def __init__(self):
        self.begin()

    def take(self, topic, reading):
        if topic is channels.VELOCITY_SETPOINT:
            still = abs(reading.velocity[0]) < MOVING
            self.moving |= not still
            if self.moving and still and self.setpoint is None:
                self.setpoint = reading.stamp, reading.name[0]
        elif topic is channels.JOINT_COMMANDS:
            if (
                self.setpoint
                and self.command is None
                and reading.stamp >= self.setpoint[0]
                and reading.name[0] == self.setpoint[1]
            ):
                self.command = reading.stamp
        elif self.command and not self.acted and reading.stamp > self.command:
            self.acted = time.monotonic()


def dead_node(scratch: Path, repeats: int) -> list:
    """ms from SIGKILL of a node to the launcher's word."""
    times = []
    for _ in range(repeats):
        with Processes(scratch) as processes:
            processes.start('velocity_controller', {})
            client = Client(watch=processes.check)
            client.wait(
                lambda: client.node.count_publishers(channels.JOINT_COMMANDS.name),
                WAIT,
                'controller',
            )
            began = time.monotonic()
            os.kill(processes.pid('velocity_controller'), signal.SIGKILL)
            try:
                client.wait(lambda: False, WAIT, 'death')
            except NodeDied:
                times.append(1e3 * (time.monotonic() - began))
            client.close()
    return times


def _cpu_of(bench: Bench) -> dict:
    """[s] of processor time so far: of each node, of this process, and of everything on the machine."""
    used = {
        **{node: _cpu(bench.processes.pid(node)) for node in NODES},
        'benchmark': _cpu(os.getpid()),
    }
    user, nice, system = map(int, Path('/proc/stat').read_text().split()[1:4])
    return {**used, 'machine': (user + nice + system) / os.sysconf('SC_CLK_TCK')}


def _cpu(pid: int) -> float:
    """[s] of processor time so far."""
    fields = Path(f'/proc/{pid}/stat').read_text().rsplit(')', 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def _observe_first():
    try:
        for thread in os.listdir('/proc/self/task'):
            os.sched_setscheduler(
                int(thread),
                os.SCHED_FIFO | os.SCHED_RESET_ON_FORK,
                os.sched_param(OBSERVER_PRIORITY),
            )
    except OSError:
        print('  (no real-time priority here: the measurer waits too)')


def show_loop(figures: dict):
    f = figures
    print(
        f'  achieved {f["rate Hz"]:.1f} Hz over {f["periods"]} periods, overruns {f["overruns"]}, '
        f'slipped {f["slipped ms"]:.1f} ms, watchdog trips {f["watchdog trips"]}'
    )
    print(
        f'  joint_states → command taken: p50 {f["answered p50 ms"]:.2f} ms, p99 {f["answered p99 ms"]:.2f} ms; '
        f'→ acting: p50 {f["applied p50 ms"]:.2f} ms, p99 {f["applied p99 ms"]:.2f} ms'
    )
    print('  lost: ' + ', '.join(f'{name} {count}' for name, count in f['lost'].items()))
    print(
        '  CPU: ' + ', '.join(f'{n} {share:.0f} %' for n, share in f['CPU %'].items()), flush=True
    )


def show_times(name: str, times: list, wanted: float):
    print(
        f'  {name}: median {statistics.median(times):.1f} ms, worst {max(times):.1f} ms of {len(times)} (wanted: {wanted} ms)',
        flush=True,
    )


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--rates', type=float, nargs='*', default=[1000.0, 500.0])
    parser.add_argument('--seconds', type=float, default=10.0)
    parser.add_argument('--repeats', type=int, default=20)
    parser.add_argument('--observer', action='store_true', help='with the object observer')
    options = parser.parse_args()
    if options.observer:
        NODES.append('object_observer')
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    with tempfile.TemporaryDirectory() as scratch:
        for rate in options.rates:
            print(f'{rate:.0f} Hz', flush=True)
            bench = Bench(Path(scratch), rate)
            try:
                show_loop(loop_figures(bench, options.seconds))
                if options.repeats:
                    show_times(
                        'controller stopped → drives hold', watchdog(bench, options.repeats), 20
                    )
                    show_times(
                        'hand_hardware/stop → drives hold', hardware_stop(bench, options.repeats), 5
                    )
                    show_times(
                        'mode_switcher/stop → motors act', switcher_stop(bench, options.repeats), 5
                    )
            finally:
                bench.close()
        if options.repeats:
            print('launcher')
            show_times('node killed → noticed', dead_node(Path(scratch), options.repeats), 500)


if __name__ == '__main__':
    main()
