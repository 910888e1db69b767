"""What a user waits for: a fresh process' first plan, the planner node's start, its answer to a client, `make run`."""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from timing import row, value

ROOT = Path(__file__).parents[1]
FIRST_PLAN = """
import json, resource, sys, time
began = time.perf_counter()
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
scenario, marks = load_scenario(sys.argv[1]), [time.perf_counter()]
for _ in range(2):
    plan_and_verify(scenario, PlanRequest())
    marks.append(time.perf_counter())
print(json.dumps([b - a for a, b in zip([began, *marks], marks)] + [resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024]))
"""
WAIT = 300.0  # [s] for a node that compiles


def bench_fresh_process(scenario: Path, cache: str = None) -> dict:
    """A process' imports, first planning call and second. cache: a directory for compiled kernels, or None for the usual one."""
    environment = {**os.environ, **({'NUMBA_CACHE_DIR': cache} if cache else {})}
    done = subprocess.run(
        [sys.executable, '-c', FIRST_PLAN, str(scenario)],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
    )
    imports, first, second, memory = json.loads(done.stdout.splitlines()[-1])
    return {
        'imports': value(imports, 's'),
        'first_offer': value(first, 's'),
        'second_offer': value(second, 's'),
        'memory': value(memory, 'MB'),
    }


def bench_planner_node(scenarios, calls: int, cache: str = None) -> dict:
    """Process start to service ready and to the first answer, and `plan_scenario` as a client sees it; needs ROS 2."""
    from wholearm_ros.launcher.client import Client
    from wholearm_ros.launcher.processes import Processes
    from wholearm_ros.ros.interface import channels

    rows, times = {}, []
    with tempfile.TemporaryDirectory() as scratch, _environment(NUMBA_CACHE_DIR=cache):
        for k, scenario in enumerate(scenarios):
            with Processes(Path(scratch)) as processes:
                client = Client(watch=processes.check, name=f'bench_{k}')
                service = client.node.create_client(
                    channels.PLAN_SCENARIO.type, channels.PLAN_SCENARIO.name
                )
                began = time.perf_counter()
                processes.start('contact_state_planner', {'scenario': str(scenario)})
                client.wait(service.service_is_ready, WAIT, 'plan_scenario')
                ready = time.perf_counter() - began
                _call(client, service)
                rows.setdefault('node.start_to_ready', value(ready, 's'))
                rows.setdefault(
                    'node.start_to_first_answer', value(time.perf_counter() - began, 's')
                )
                times += [_call(client, service) for _ in range(calls)]
                rows['node.memory'] = value(_peak(processes.pid('contact_state_planner')), 'MB')
                client.close()
    return {**rows, **({'node.plan_scenario': row(times)} if times else {})}


def bench_make_run() -> dict:
    """`make run` as a user types it, environment and kernels there already."""
    began = time.perf_counter()
    subprocess.run(['make', 'run'], cwd=ROOT, check=True, capture_output=True)
    return {'make_run': value(time.perf_counter() - began, 's')}


def _call(client, service) -> float:
    """[s] from the request to the answer; the client waits without polling in between."""
    began = time.perf_counter()
    future = service.call_async(service.srv_type.Request())
    while not future.done():
        client.executor.spin_once(timeout_sec=WAIT)
        client.watch()
    assert future.result().success, future.result().message
    return time.perf_counter() - began


def _peak(pid: int) -> float:
    """[MB] the most memory a process has held."""
    text = Path(f'/proc/{pid}/status').read_text()
    return int(text.split('VmHWM:')[1].split()[0]) / 1024


class _environment:
    """Variables set for processes that are started inside; None leaves one alone."""

    def __init__(self, **values):
        self.values = {name: text for name, text in values.items() if text is not None}

    def __enter__(self):
        self.before = {name: os.environ.get(name) for name in self.values}
        os.environ.update(self.values)

    def __exit__(self, *_):
        for name, text in self.before.items():
            os.environ.pop(name, None) if text is None else os.environ.__setitem__(name, text)
