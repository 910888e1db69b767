"""A suite on a Dask cluster of this machine: a scheduler and workers as processes, one of them killed half-way.

    python benchmarks/cluster.py [--suite FILE] [--workers 2] [--time-budget 3]

Prints when each result came, when the worker was killed, and whether every task has exactly one result.
"""

import argparse
import collections
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.suite.statistics import summarize
from wholearm_ros.suite.suite import run_suite
from wholearm_ros.suite.suite_file import load_suite
from wholearm_ros.suite.suite_options import SuiteOptions

HERE = Path(__file__).parent


class Cluster:
    """A context: processes of a scheduler and its workers, of one thread each, without nannies that would start them again."""

    def __init__(self, workers: int):
        with socket.socket() as free:
            free.bind(('127.0.0.1', 0))
            self.address = f'tcp://127.0.0.1:{free.getsockname()[1]}'
        self._count, self._processes = workers, []

    def __enter__(self):
        self._start('scheduler', '--host', self.address, '--no-dashboard', '--no-jupyter')
        self.workers = [
            self._start(
                'worker',
                self.address,
                '--host',
                '127.0.0.1',
                '--nthreads',
                '1',
                '--no-nanny',
                '--no-dashboard',
            )
            for _ in range(self._count)
        ]
        return self

    def __exit__(self, *_):
        for process in self._processes:
            process.kill()
            process.wait()

    def _start(self, *arguments):
        self._processes.append(
            subprocess.Popen(
                [sys.executable, '-m', 'dask', *arguments],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
        )
        return self._processes[-1]


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--suite', type=Path, default=HERE / 'suite.json')
    parser.add_argument('--workers', type=int, default=2)
    parser.add_argument('--time-budget', type=float, default=3.0)
    options = parser.parse_args()
    signal.signal(
        signal.SIGTERM, lambda *_: sys.exit(1)
    )  # so that no process of the cluster is left behind
    tasks, heard, began = load_suite(options.suite), [], time.monotonic()

    def tell(text):
        print(f'{time.monotonic() - began:6.1f} s  {text}', flush=True)

    def on_result(result):
        heard.append(result['name'])
        tell(
            f'{len(heard):3d} of {len(tasks)}  {result["name"]}: {"executed" if result["executed"] else result["reason"][:60]}'
        )
        if len(heard) == len(tasks) // 2:
            os.kill(cluster.workers[0].pid, signal.SIGKILL)
            tell(
                f'worker {cluster.workers[0].pid} killed; alive: {[w.pid for w in cluster.workers[1:]]}'
            )

    with Cluster(options.workers) as cluster:
        results = run_suite(
            tasks,
            SuiteOptions(PlanRequest(time_budget=options.time_budget)),
            on_result=on_result,
            scheduler=cluster.address,
        )
    often = collections.Counter(heard)
    tell(
        f'{len(results)} results for {len(tasks)} tasks; heard of more than once: {[n for n, k in often.items() if k > 1] or "none"}, '
        f'never: {[t.name for t in tasks if t.name not in often] or "none"}; {summarize(results)["errors"]} errors'
    )


if __name__ == '__main__':
    main()
