"""Whether plans hold up better when they are executed slower: the planned routes of a suite at other limits of speed and
acceleration, each in the same strongly perturbed samples of its task (planar simulation).

    python benchmarks/speeds.py [SUITE.json] [--samples 16] [--level 2] [--time-budget 3]

Routes of motion primitives are left out: their speeds belong to the primitives.
"""

import argparse
from dataclasses import replace
from pathlib import Path

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.rollout.perturbed_samples import build_perturbed_samples
from wholearm_ros.rollout.verification import parallel_rollouts
from wholearm_ros.suite.suite_file import load_suite
from wholearm_ros.trajectory.execution_options import ExecutionOptions
from wholearm_ros.trajectory.main_trajectory import generate

LIMITS = (
    (1.5, 12.0),
    (1.0, 12.0),
    (1.5, 5.0),
    (0.8, 4.0),
    (2.5, 20.0),
)  # [rad/s], [rad/s²]; the first are the defaults
SAMPLES_SEED = 77  # other samples than those the plan was verified with


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        'suite', type=Path, nargs='?', default=Path(__file__).with_name('suite.json')
    )
    parser.add_argument('--samples', type=int, default=16)
    parser.add_argument('--level', type=float, default=2.0)
    parser.add_argument('--time-budget', type=float, default=3.0)
    options = parser.parse_args()
    survived, seconds, runs = [0] * len(LIMITS), [0.0] * len(LIMITS), 0
    for task in load_suite(options.suite):
        scenario = parse_scenario(task.scenario, task.name)
        found = plan_and_verify(scenario, PlanRequest(moves=0, time_budget=options.time_budget))
        if found.trajectory is None:
            continue
        samples = build_perturbed_samples(scenario, options.samples, options.level, SAMPLES_SEED)[
            1:
        ]
        chosen = ExecutionOptions.from_dict(found.plan.execution)
        runs += len(samples)
        for k, (speed, acceleration) in enumerate(LIMITS):
            trajectory = generate(
                scenario, found.plan, replace(chosen, speed=speed, acceleration=acceleration)
            )
            survived[k] += sum(
                trial.success for trial in parallel_rollouts(trajectory, samples, ControlOptions())
            )
            seconds[k] += trajectory.duration
        print(f'{task.name}: {survived} of {runs}', flush=True)
    print('\n| rad/s | rad/s² | duration | at the goal |\n|---|---|---|---|')
    for (speed, acceleration), alive, duration in zip(LIMITS, survived, seconds):
        print(
            f'| {speed} | {acceleration:.0f} | {duration / seconds[0]:.2f} × | {alive} of {runs} |'
        )


if __name__ == '__main__':
    main()
