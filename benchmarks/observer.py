"""How true the observer is: its hypothesis against the object, and its standard deviations against its errors.

    python benchmarks/observer.py [SUITE ...] [--levels 1 2 3] [--draws 2] [--tasks N] [--seed 0] [--backend planar]
                                  [--time-budget 180]

Every task is planned, its trajectory led at every level, and the observer asked 20 times a second, from the measured angles only.
A row is of the runs at the goal, or of the others, at one level: how many runs; the share of instants at which a hypothesis is
believed; of those runs that have one, the share that agrees with the truth (rotation within 0.12 rad) after each quarter of the
trajectory; and the share of believed instants at which the error of x, y and rotation is within 1.96 standard deviations.
"""

import argparse
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np

from wholearm_ros.estimation.feel import Feeler
from wholearm_ros.estimation.observer import Observer
from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.planner.legs import leg_of
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.suite.execution import execute
from wholearm_ros.suite.suite_file import load_suite
from wholearm_ros.suite.suite_options import SuiteOptions

HERE = Path(__file__).parent
PERIOD = 0.05  # [s]
AGREES = 0.12  # [rad]
COVERED = 1.96  # standard deviations that hold 95 % of a normal distribution
QUARTERS = (0.25, 0.5, 0.75, 1.0)


def followed(observer: Observer, trajectory, record, ramp: float) -> tuple:
    """(shares of the trajectory (m,), errors (m, 3), standard deviations (m, 3)), NaN where nothing is believed."""
    elapsed = record.times - record.times[0] - ramp
    rows = np.searchsorted(elapsed, np.arange(0.0, trajectory.duration + PERIOD / 2, PERIOD))
    rows = np.minimum(rows, len(elapsed) - 1)
    errors, deviations = np.full((2, len(rows), 3), np.nan)
    for k, row in enumerate(rows):
        best = observer.following(trajectory, elapsed[row], record.angles[row]).best
        if best is not None:
            errors[k] = best.pose - record.poses[row]
            deviations[k] = observer.deviations(best)
    return elapsed[rows] / trajectory.duration, errors, deviations


def cells(runs: list) -> list:
    """What a row tells of runs as `followed` gives them."""
    errors, deviations = (np.concatenate([run[k] for run in runs]) for k in (1, 2))
    known = np.isfinite(errors[:, 0])
    covered = np.abs(errors[known]) <= COVERED * deviations[known]
    at = []
    for quarter in QUARTERS:
        ends = [run[1][np.argmin(np.abs(run[0] - quarter)), 2] for run in runs]
        told = [abs(end) < AGREES for end in ends if np.isfinite(end)]
        at.append(f'{np.mean(told):.2f}' if told else '')
    shares = ', '.join(f'{share:.2f}' for share in covered.mean(axis=0))
    return [len(runs), f'{known.mean():.2f}', ', '.join(at), shares]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('suites', nargs='*', type=Path, default=[HERE / 'suite.json'])
    parser.add_argument('--levels', nargs='+', type=float, default=[1.0, 2.0, 3.0])
    parser.add_argument('--draws', type=int, default=2)
    parser.add_argument('--tasks', type=int, help='only so many of each suite')
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--backend', default='planar')
    parser.add_argument('--time-budget', type=float, default=PlanRequest.time_budget)
    options = parser.parse_args()
    request = PlanRequest(seed=options.seed, time_budget=options.time_budget)
    asked = SuiteOptions(request, backend=options.backend, probe=False)
    found = defaultdict(list)
    for suite in options.suites:
        for task in load_suite(suite)[: options.tasks]:
            scenario = parse_scenario(task.scenario, task.name)
            leg = leg_of(scenario, plan_and_verify(scenario, request))
            if leg is None:
                continue
            observer = Observer(Feeler(scenario))
            for level in options.levels:
                for draw in range(options.draws):
                    made = execute(scenario, leg, replace(asked, perturb=level), draw, task.name)
                    ramp = asked.loop.controls.ramp
                    one = followed(observer, leg.trajectory, made.record, ramp)
                    found[level, made.judged.executed].append(one)
    print(
        '| level | ended | runs | believed | agrees after each quarter | within 95 %: x, y, rotation |'
    )
    print('|---|---|---|---|---|---|')
    for (level, done), runs in sorted(found.items(), key=lambda item: (item[0][0], not item[0][1])):
        row = [f'{level:g}', 'at the goal' if done else 'elsewhere', *cells(runs)]
        print('| ' + ' | '.join(map(str, row)) + ' |')


if __name__ == '__main__':
    main()
