"""A suite on a Dask cluster: real scheduler and workers as processes, one of them killed half-way; nothing lost, nothing twice."""

import os
import signal
import socket
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from wholearm_ros.errors import WholeArmError
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.suite.suite import run_suite
from wholearm_ros.suite.suite_file import load_suite
from wholearm_ros.suite.suite_options import SuiteOptions

pytest.importorskip('distributed', reason='Dask is not installed (the extra `cluster`)')
SUITE = Path(__file__).parents[2] / 'benchmarks' / 'suite.json'
SHIPPED = load_suite(SUITE)[0]
OPTIONS = SuiteOptions(PlanRequest(candidates=3, moves=0), backend='planar')
# quick, and the same on any machine
TIMES = ('plan_ms', 'generate_ms', 'verify_ms')


@pytest.fixture
def cluster(tmp_path):
    """(address of a scheduler, the processes of its two workers)."""
    started = []

    def start(*arguments):
        started.append(
            subprocess.Popen(
                [sys.executable, '-m', 'dask', *arguments],
                cwd=tmp_path,
                start_new_session=True,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
        )
        return started[-1]

    with socket.socket() as free:
        free.bind(('127.0.0.1', 0))
        address = f'tcp://127.0.0.1:{free.getsockname()[1]}'
    start('scheduler', '--host', address, '--no-dashboard', '--no-jupyter')
    workers = [
        start(
            'worker',
            address,
            '--host',
            '127.0.0.1',
            '--nthreads',
            '1',
            '--no-nanny',
            '--no-dashboard',
        )
        for _ in range(2)
    ]
    yield address, workers
    for process in started:
        process.kill()
        process.wait()


def without_times(results):
    return [{name: value for name, value in r.items() if name not in TIMES} for r in results]


def test_a_worker_that_is_killed_costs_time_and_nothing_else(cluster):
    address, workers = cluster
    tasks = [replace(SHIPPED, name=f'shipped-{k}') for k in range(2)] + list(load_suite(SUITE)[2:6])
    heard = []

    def on_result(result):
        heard.append(result['name'])
        if len(heard) == 2:
            os.kill(workers[0].pid, signal.SIGKILL)

    results = run_suite(tasks, OPTIONS, on_result=on_result, scheduler=address)
    assert workers[0].poll() is not None or workers[0].wait(10) == -signal.SIGKILL
    assert workers[1].poll() is None
    assert sorted(heard) == sorted(task.name for task in tasks)
    assert [r['name'] for r in results] == [task.name for task in tasks]
    assert not any('error' in r for r in results) and any(r['executed'] for r in results)
    assert without_times(results) == without_times(run_suite(tasks, OPTIONS))


def test_an_address_where_nobody_answers_is_said(monkeypatch):
    monkeypatch.setattr('wholearm_ros.suite.workers.ANSWER_WITHIN', 0.5)
    with socket.socket() as closed:
        closed.bind(('127.0.0.1', 0))
        address = f'tcp://127.0.0.1:{closed.getsockname()[1]}'
        with pytest.raises(
            WholeArmError, match='allowed: the address that `dask scheduler` prints'
        ):
            run_suite(load_suite(SUITE)[:1], OPTIONS, scheduler=address)


def test_without_dask_a_scheduler_is_refused_and_jobs_are_a_pool(monkeypatch):
    tasks = load_suite(SUITE)[2:5]
    expected = without_times(run_suite(tasks, OPTIONS))
    monkeypatch.setitem(sys.modules, 'distributed', None)
    with pytest.raises(WholeArmError, match=r'with Dask, pip install'):
        run_suite(tasks, OPTIONS, scheduler='tcp://127.0.0.1:1')
    assert without_times(run_suite(tasks, OPTIONS, jobs=2)) == expected
