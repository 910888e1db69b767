"""How plans hold up: every task of a suite planned once, then executed in PyBullet at several levels of perturbation.

    python benchmarks/robustness.py [SUITE.json] [--levels 0 0.5 1 2] [--draws 5] [--jobs 2] [--json OUT]

Prints, for each level, the runs, how many ended with the object at rest on its goal edge, and the share; and for the whole
suite planned, executed and the times of planning.
"""

import argparse
import json
import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from wholearm_ros.model.perturbation import draw_perturbation
from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.simulation.closed_loop import run
from wholearm_ros.simulation.outcome import outcome
from wholearm_ros.suite.suite_file import SuiteEntry, load_suite


def judge(task: SuiteEntry, levels: tuple, draws: int, seed: int) -> dict:
    """One task: its plan, and for every level the outcomes of its runs."""
    scenario = parse_scenario(task.scenario, task.name)
    began = time.perf_counter()
    answer = plan_and_verify(scenario, PlanRequest(seed=seed))
    result = {
        'name': task.name,
        'planned': answer.trajectory is not None,
        'reason': answer.plan.reason,
        'seconds': time.perf_counter() - began,
        'timings': answer.timings,
        'levels': {},
    }
    if answer.trajectory is None:
        return result
    result['modes'] = sorted({leg.mode for leg in answer.plan.legs})
    result['survived'] = answer.trajectory.verification
    for level in levels:
        rng = np.random.default_rng([seed, int(1000 * level)])
        ends = [
            outcome(
                scenario,
                run(
                    scenario,
                    answer.trajectory,
                    perturbation=draw_perturbation(rng, level, scenario),
                ),
            )
            for _ in range(draws if level else 1)
        ]
        result['levels'][str(level)] = [(end.executed, end.reason) for end in ends]
    return result


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        'suite', type=Path, nargs='?', default=Path(__file__).with_name('suite.json')
    )
    parser.add_argument('--levels', type=float, nargs='+', default=[0.0, 0.5, 1.0, 2.0])
    parser.add_argument('--draws', type=int, default=5)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--jobs', type=int, default=2)
    parser.add_argument('--json')
    options = parser.parse_args()
    tasks = load_suite(options.suite)
    work = partial(judge, levels=tuple(options.levels), draws=options.draws, seed=options.seed)
    results = []
    with ProcessPoolExecutor(options.jobs, mp_context=get_context('spawn')) as pool:
        for result in pool.map(work, tasks):
            results.append(result)
            counts = {
                level: f'{sum(ok for ok, _ in ends)}/{len(ends)}'
                for level, ends in result['levels'].items()
            }
            print(
                result['name'],
                counts or f'not planned: {result["reason"][:100]}',
                f'{result["seconds"]:.1f} s',
                flush=True,
            )
    report(results, options.levels)
    if options.json:
        with open(options.json, 'w') as file:
            json.dump(results, file, indent=1)


def report(results: list, levels: list):
    """The table."""
    planned = [r for r in results if r['planned']]
    print(
        f'\nplanned {len(planned)} of {len(results)}; seconds to a plan: median '
        f'{np.median([r["seconds"] for r in results]):.2f}, p95 {np.quantile([r["seconds"] for r in results], 0.95):.1f}'
    )
    print('level   runs  executed  sound')
    for level in levels:
        ends = [ok for r in planned for ok, _ in r['levels'][str(level)]]
        print(f'{level:5.1f} {len(ends):6d} {sum(ends):9d}  {np.mean(ends):.3f}')


if __name__ == '__main__':
    main()
