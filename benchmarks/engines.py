"""Our planar time stepping against PyBullet: the same trajectories, the same perturbations, both behind the same controllers.

    python benchmarks/engines.py [SUITE.json] [--tasks 10] [--draws 10] [--seed 0] [--json OUT]

For each task: the largest difference of the object's pose before its first impact (the first instant at which its velocity
jumps in either engine), how often both engines agree on whether the object ends at its goal, and the largest residual of
the complementarity problems.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from wholearm_ros.model.perturbation import draw_perturbation
from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.simulation.closed_loop import run
from wholearm_ros.simulation.outcome import outcome
from wholearm_ros.suite.suite_file import SuiteEntry, load_suite

JUMP = np.array(
    [0.02, 0.02, 0.3]
)  # [m/s, m/s, rad/s] change of the object's velocity in 1 ms that only an impact makes


def compare(task: SuiteEntry, draws: int, seed: int) -> dict:
    """One task; None when there is no plan for it."""
    scenario = parse_scenario(task.scenario, task.name)
    answer = plan_and_verify(scenario, PlanRequest(seed=seed))
    if answer.trajectory is None:
        return None
    records = {
        engine: run(scenario, answer.trajectory, backend=engine)
        for engine in ('planar', 'pybullet')
    }
    poses = [record.poses for record in records.values()]
    count = min(first_impact(record) for record in records.values())
    apart = np.abs(poses[0][:count] - poses[1][:count]).max(axis=0)
    pairs = []
    for k in range(draws):
        truth = draw_perturbation(np.random.default_rng([seed, k]), float(k > 0), scenario)
        pairs.append(
            [
                outcome(
                    scenario, run(scenario, answer.trajectory, backend=engine, perturbation=truth)
                ).executed
                for engine in records
            ]
        )
    return {
        'name': task.name,
        'until': float(records['planar'].times[count - 1]),
        'apart_mm': 1e3 * float(apart[:2].max()),
        'apart_mrad': 1e3 * float(apart[2]),
        'agree': sum(a == b for a, b in pairs),
        'of': draws,
        'executed': [sum(a for a, _ in pairs), sum(b for _, b in pairs)],
        'residual': answer.trajectory.verification['lcp_residual'],
    }


def first_impact(record) -> int:
    """Samples before the object's velocity first jumps."""
    jumps = (np.abs(np.diff(record.object_velocities, axis=0)) > JUMP).any(axis=1)
    return int(np.argmax(jumps)) + 1 if jumps.any() else len(record.times)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        'suite', type=Path, nargs='?', default=Path(__file__).with_name('suite.json')
    )
    parser.add_argument('--tasks', type=int, default=10)
    parser.add_argument('--draws', type=int, default=10)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--json')
    options = parser.parse_args()
    results = []
    print(
        'task       until    apart before the first impact   outcomes agree   executed planar/PyBullet   LCP residual'
    )
    for task in load_suite(options.suite):
        if len(results) == options.tasks:
            break
        r = compare(task, options.draws, options.seed)
        if r is None:
            continue
        results.append(r)
        print(
            f'{r["name"]:9s} {r["until"]:5.2f} s  {r["apart_mm"]:8.3f} mm {r["apart_mrad"]:8.2f} mrad {r["agree"]:14d}/{r["of"]} '
            f'{r["executed"][0]:15d}/{r["executed"][1]} {r["residual"]:21.1e}',
            flush=True,
        )
    print(f'agree in {sum(r["agree"] for r in results)} of {sum(r["of"] for r in results)} runs')
    if options.json:
        with open(options.json, 'w') as file:
            json.dump(results, file, indent=1)


if __name__ == '__main__':
    main()
