"""Runs of the whole graph in real time, as `wholearm run` does them: how they ended, and the longest publish of each.

python benchmarks/realtime_runs.py [--runs 50] [--rates 1000 500] [--record] [--scenario asymmetric_hexagon]
"""

import argparse
import json
import tempfile
from pathlib import Path

from graph_run import heard_run, in_a_process

from wholearm_ros.launcher.launcher import LOOP_PRIORITY, RunOptions
from wholearm_ros.package_share import scenario_path

LOOP = ('hand_hardware', 'mode_switcher', 'velocity_controller', 'torque_controller')


def one(scenario: str, rate: float, record: bool) -> dict:
    """A run in this process: success, reason, longest publish [ms] by node."""
    path = scenario_path(scenario)
    with tempfile.TemporaryDirectory() as scratch:
        bag = Path(scratch) / 'bag' if record else None
        report, heard = heard_run(RunOptions(str(path), 'realtime', rate=rate, record=bag))
    success, reason = False, report
    if not isinstance(report, str):
        success, reason = report.success, report.result.get('reason', report.message)
    said = {node: told[-1][1] for node, told in heard.items()}
    longest = {
        node: float(values.get('longest publish ms', 'nan')) for node, values in said.items()
    }
    where = {node: values.get('longest publish topic', '') for node, values in said.items()}
    hardware = said.get('hand_hardware', {})
    return {
        'success': success,
        'reason': reason,
        'longest publish ms': longest,
        'longest publish topic': where,
        'trips': hardware.get('watchdog trips'),
        'latency p99 ms': hardware.get('command latency p99 ms'),
        'overruns': hardware.get('overruns'),
        'recorder': {k: v for k, v in said.get('bag_recorder', {}).items() if k != 'path'},
    }


def many(options: argparse.Namespace, rate: float) -> None:
    """Each in a process of its own; a line of each and a summary."""
    results = []
    for k in range(options.runs):
        words = ['--scenario', options.scenario, '--one', str(rate)]
        result = in_a_process(__file__, *words, *(['--record'] if options.record else []))
        if isinstance(result, str):
            result = {'success': False, 'reason': result, 'longest publish ms': {}}
        results.append(result)
        print(json.dumps({'rate': rate, 'run': k, **result}), flush=True)
    longest = [
        max((v for n, v in r['longest publish ms'].items() if n in LOOP), default=float('nan'))
        for r in results
    ]
    print(
        f'{rate:.0f} Hz: {sum(r["success"] for r in results)} of {len(results)} succeeded; longest '
        f'publish of the loop: median {sorted(longest)[len(longest) // 2]:.1f} ms, '
        f'worst {max(longest):.1f} ms (priority {LOOP_PRIORITY} where allowed)',
        flush=True,
    )


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--runs', type=int, default=50)
    parser.add_argument('--rates', type=float, nargs='*', default=[1000.0, 500.0])
    parser.add_argument('--record', action='store_true')
    parser.add_argument('--scenario', default='asymmetric_hexagon')
    parser.add_argument('--one', type=float, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(one(options.scenario, options.one, options.record)))
        return
    for rate in options.rates:
        many(options, rate)


if __name__ == '__main__':
    main()
