"""The closed loop under each of rclpy's executors: what led to the choice in docs/ros.md.

python benchmarks/executors.py [--rates 500 1000] [--seconds 5] [--executors events single multi]
"""

import argparse
import importlib
import os
import sys
import tempfile
from pathlib import Path

from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from ros_loop import LOOP, Bench, loop_figures, show_loop

from wholearm_ros.launcher.client import GraphError
from wholearm_ros.launcher.processes import Processes
from wholearm_ros.ros.node.run import run_node

EXECUTORS = {
    'events': EventsExecutor,
    'single': SingleThreadedExecutor,
    'multi': MultiThreadedExecutor,
}


class Under(Processes):
    """The nodes of the loop under one executor, the others as always."""

    executor = ''

    def program(self, node: str) -> list:
        return (
            [sys.executable, __file__, 'run', node, self.executor]
            if node in LOOP
            else super().program(node)
        )


def run(node: str, executor: str):
    """One node of the loop, in this process."""
    module = importlib.import_module(f'wholearm_ros.nodes.{node}')
    kind = getattr(module, node.title().replace('_', ''))
    sys.exit(run_node(kind, make_executor=EXECUTORS[executor]))


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--rates', type=float, nargs='*', default=[500.0, 1000.0])
    parser.add_argument('--seconds', type=float, default=5.0)
    parser.add_argument('--executors', nargs='*', default=list(EXECUTORS), choices=list(EXECUTORS))
    options = parser.parse_args()
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    for Under.executor in options.executors:
        for rate in options.rates:
            print(f'{Under.executor}, {rate:.0f} Hz', flush=True)
            with tempfile.TemporaryDirectory() as scratch:
                try:
                    bench = Bench(Path(scratch), rate, Under)
                except GraphError as error:
                    print(f'  the graph does not come up: {error}', flush=True)
                    continue
                try:
                    show_loop(loop_figures(bench, options.seconds))
                finally:
                    bench.close()


if __name__ == '__main__':
    if sys.argv[1:2] == ['run']:
        run(*sys.argv[2:4])
    main()
