"""Every installed engine on the same plans and perturbations: who reaches the goal, who agrees with whom, how fast each is.

    python benchmarks/jury.py [SUITE.json] [--tasks 12] [--levels 0 1 2] [--draws 2] [--seed 0] [--json OUT]

A level of 0 is run once a plan. Speed: simulated seconds for each second of this process's CPU time, control included. Where engines disagree, each
of them runs it five times more, with other encoder noise only: where an engine then disagrees with itself, the run stands on a knife's edge.
"""

import argparse
import json
import time
from collections import defaultdict
from itertools import combinations
from pathlib import Path

import numpy as np

from wholearm_ros.model.backends import installed_backends
from wholearm_ros.model.perturbation import Perturbation
from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.simulation.closed_loop import run
from wholearm_ros.simulation.jury import Verdict, disagreements, hear, testify
from wholearm_ros.suite.execution import drawn_perturbation
from wholearm_ros.suite.suite_file import load_suite
from wholearm_ros.suite.suite_options import SuiteOptions

REPEATED = 5  # runs of each engine with other encoder noise


def judge(scenario, trajectory, perturbation: Perturbation, spent: dict) -> Verdict:
    """One run in every engine; spent: {engine: [simulated s, CPU s]}, added to."""
    testimonies = []
    for engine in installed_backends():
        begun = time.process_time()
        record = run(scenario, trajectory, backend=engine, perturbation=perturbation)
        spent[engine] += [record.times[-1], time.process_time() - begun]
        testimonies.append(testify(engine, scenario, record))
    return Verdict(tuple(testimonies), disagreements(testimonies))


def repeated(scenario, trajectory, perturbation: Perturbation) -> dict:
    """{engine: runs at the goal of REPEATED with other encoder noise}."""
    verdicts = [hear(scenario, trajectory, perturbation.reseeded(k + 1)) for k in range(REPEATED)]
    return {e: sum(_by_engine(v)[e] for v in verdicts) for e in installed_backends()}


def show(level: float, verdicts: list) -> None:
    """A row a level."""
    executed = {e: 0 for e in installed_backends()}
    for verdict in verdicts:
        for t in verdict.testimonies:
            executed[t.engine] += t.judged.executed
    agree = [
        f'{a} and {b} {sum(x[a] == x[b] for x in map(_by_engine, verdicts))}'
        for a, b in combinations(executed, 2)
    ]
    depth = {
        e: 1e3 * max(t.penetration for v in verdicts for t in v.testimonies if t.engine == e)
        for e in executed
    }
    print(
        f'level {level:g}, {len(verdicts)} runs: at the goal {executed}; in agreement {", ".join(agree)}'
    )
    print('  deepest [mm]: ' + ', '.join(f'{e} {d:.3f}' for e, d in depth.items()))


def _by_engine(verdict: Verdict) -> dict:
    return {t.engine: t.judged.executed for t in verdict.testimonies}


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        'suite', type=Path, nargs='?', default=Path(__file__).with_name('suite.json')
    )
    parser.add_argument('--tasks', type=int, default=12)
    parser.add_argument('--levels', type=float, nargs='+', default=[0.0, 1.0, 2.0])
    parser.add_argument('--draws', type=int, default=2)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--json')
    options = parser.parse_args()
    verdicts, spent, told = defaultdict(list), defaultdict(lambda: np.zeros(2)), []
    for task in load_suite(options.suite)[: options.tasks]:
        scenario = parse_scenario(task.scenario, task.name)
        found = plan_and_verify(scenario, PlanRequest(seed=options.seed))
        if found.trajectory is None:
            print(f'{task.name}: {found.plan.outcome}', flush=True)
            continue
        for level in options.levels:
            for draw in range(options.draws if level else 1):
                asked = SuiteOptions(PlanRequest(seed=options.seed), level)
                perturbation = drawn_perturbation(scenario, asked, draw)
                verdict = judge(scenario, found.trajectory, perturbation, spent)
                verdicts[level].append(verdict)
                told.append({'task': task.name, 'level': level, 'draw': draw, **verdict.to_dict()})
                print(
                    f'{task.name}, level {level:g}, draw {draw}: {_by_engine(verdict)}', flush=True
                )
                for line in verdict.disagreements:
                    print(f'  {line}')
                if verdict.disagreements:
                    again = repeated(scenario, found.trajectory, perturbation)
                    told[-1]['other_noise'] = again
                    print(f'  with other encoder noise, of {REPEATED}: {again}', flush=True)
    for level, heard in sorted(verdicts.items()):
        show(level, heard)
    print('simulated s per CPU s: ' + ', '.join(f'{e} {s / c:.1f}' for e, (s, c) in spent.items()))
    if options.json:
        Path(options.json).write_text(json.dumps(told, indent=1))


if __name__ == '__main__':
    main()
