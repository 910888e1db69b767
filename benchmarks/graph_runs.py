"""Runs of the whole graph under errors of the hand: what was claimed against what is true, and the loop's rate and latency.

    python benchmarks/graph_runs.py [--runs 10] [--levels 0 2 4] [--pacings realtime lockstep] [--json OUT]

Every run is a process of its own, as `wholearm run SCENARIO --perturb LEVEL --seed K` with the observer and up to four attempts;
lines already in OUT are not run again. A table at the end: a row a scenario, pacing and level.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

from wholearm_ros.errors import WholeArmError
from wholearm_ros.launcher.launcher import RunOptions, run_graph
from wholearm_ros.model.outcomes import SUCCEEDED
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.package_share import scenario_path
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.messages import values_of

RUN_WITHIN = 600.0  # [s]
SCENARIOS = ('asymmetric_hexagon', 'regular_hexagon')
LOOP = ('rate Hz', 'command latency p50 ms', 'command latency p99 ms')


def one(scenario: str, pacing: str, level: float, seed: int) -> dict:
    """A run in this process: claimed (succeeded, felt at the goal), executed (the truth), reason, and the hardware's figures."""
    said: dict = {}

    def hear(message):
        for status in message.status:
            if status.name.endswith('hand_hardware'):
                said.update(values_of(status))

    def on_client_ready(client):
        topic = channels.DIAGNOSTICS
        client.node.create_subscription(topic.type, topic.name, hear, topic.qos)

    path = scenario_path(scenario)
    options = RunOptions(str(path), pacing, seed=seed, perturb=level)
    try:
        report = run_graph(
            load_scenario(path), options, lambda *_: None, on_client_ready=on_client_ready
        )
    except WholeArmError as error:
        return {'claimed': False, 'executed': False, 'attempts': 0, 'reason': str(error)}
    return {
        'claimed': report.result.get('outcome') == SUCCEEDED,
        'executed': report.judged is not None and report.judged.executed,
        'attempts': sum(bool(a.get('planned')) for a in report.attempts),
        'reason': report.result.get('reason', report.message),
        **{key: said.get(key) for key in LOOP},
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
        median = [_median(r.get(name) for r in of) for name in LOOP]
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
            for scenario in SCENARIOS:
                for level in options.levels:
                    key = (scenario, pacing, level, seed)
                    if key in done:
                        continue
                    command = [sys.executable, __file__, '--one', *map(str, key)]
                    ran = subprocess.run(
                        command, capture_output=True, text=True, timeout=RUN_WITHIN
                    )
                    told = (
                        {'claimed': False, 'executed': False, 'reason': ran.stderr[-300:]}
                        if ran.returncode
                        else json.loads(ran.stdout.splitlines()[-1])
                    )
                    rows.append({'key': key, **told})
                    with options.json.open('a') as out:
                        print(json.dumps(rows[-1]), file=out)
                    print(json.dumps(rows[-1]), flush=True)
    print(table(rows))


if __name__ == '__main__':
    main()
