"""Runs of the whole graph under errors of the hand: what was claimed against what is true, and the loop's rate and latency.

    python benchmarks/graph_runs.py [--runs 10] [--levels 0 2 4] [--pacings realtime lockstep] [--json OUT]

Every run is a process of its own, as `wholearm run SCENARIO --perturb LEVEL --seed K` with the observer and up to four attempts;
lines already in OUT are not run again. A table at the end: a row a scenario, pacing and level.
"""

import argparse
import json
from pathlib import Path

from graph_run import heard_run, in_a_process

from wholearm_ros.launcher.launcher import RunOptions
from wholearm_ros.model.outcomes import SUCCEEDED
from wholearm_ros.package_share import scenario_path

SCENARIOS = ('asymmetric_hexagon', 'regular_hexagon')
RATE, LATENCY = 'rate Hz', ('command latency p50 ms', 'command latency p99 ms')


def one(scenario: str, pacing: str, level: float, seed: int) -> dict:
    """A run in this process: claimed (succeeded, felt at the goal), executed (the truth), reason, and the hardware's figures."""
    path = scenario_path(scenario)
    report, said = heard_run(RunOptions(str(path), pacing, seed=seed, perturb=level))
    if isinstance(report, str):
        return {'claimed': False, 'executed': False, 'attempts': 0, 'reason': report}
    (began, first), *_, (ended, last) = said['hand_hardware']
    return {
        'claimed': report.result.get('outcome') == SUCCEEDED,
        'executed': report.judged is not None and report.judged.executed,
        'attempts': sum(bool(a.get('planned')) for a in report.attempts),
        'reason': report.result.get('reason', report.message),
        RATE: (int(last['steps']) - int(first['steps'])) / (ended - began),
        **{key: last.get(key) for key in LATENCY},
    }


def table(rows: list) -> str:
    """Markdown."""
    lines = [
        '| scenario | pacing | level | runs | at the goal | said to be | false success | false failure '
        '| rate [Hz] | latency p50 / p99 [ms] |',
        '|---|---|---|---|---|---|---|---|---|---|',
    ]
    for key in dict.fromkeys(tuple(r['key'][:3]) for r in rows):
        of = [r for r in rows if tuple(r['key'][:3]) == key]
        median = [_median(r.get(name) for r in of) for name in (RATE, *LATENCY)]
        counts = (
            len(of),
            sum(r['executed'] for r in of),
            sum(r['claimed'] for r in of),
            sum(r['claimed'] and not r['executed'] for r in of),
            sum(r['executed'] and not r['claimed'] for r in of),
        )
        cells = (*key[:2], f'{key[2]:g}', *counts, median[0], f'{median[1]} / {median[2]}')
        lines.append('| ' + ' | '.join(map(str, cells)) + ' |')
    return '\n'.join(lines)


def _median(values) -> str:
    """Of what was told."""
    told = sorted(float(v) for v in values if v not in (None, ''))
    return f'{told[len(told) // 2]:.2f}' if told else ''


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--runs', type=int, default=10)
    parser.add_argument('--levels', type=float, nargs='*', default=[0.0, 2.0, 4.0])
    parser.add_argument('--pacings', nargs='*', default=['realtime', 'lockstep'])
    parser.add_argument('--scenarios', nargs='*', default=SCENARIOS, choices=SCENARIOS)
    parser.add_argument('--json', type=Path, default=Path('graph_runs.jsonl'))
    parser.add_argument('--one', nargs=4, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        scenario, pacing, level, seed = options.one
        print(json.dumps(one(scenario, pacing, float(level), int(seed))))
        return
    rows = []
    if options.json.exists():
        rows = [json.loads(line) for line in options.json.read_text().splitlines()]
    done = {tuple(row['key']) for row in rows}
    for seed in range(options.runs):
        for pacing in options.pacings:
            for scenario in options.scenarios:
                for level in options.levels:
                    key = (scenario, pacing, level, seed)
                    if key in done:
                        continue
                    told = in_a_process(__file__, '--one', *map(str, key))
                    if isinstance(told, str):
                        told = {'claimed': False, 'executed': False, 'reason': told}
                    rows.append({'key': key, **told})
                    with options.json.open('a') as out:
                        print(json.dumps(rows[-1]), file=out)
                    print(json.dumps(rows[-1]), flush=True)
    print(table(rows))


if __name__ == '__main__':
    main()
