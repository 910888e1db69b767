"""What guarded strokes could gain at most: strokes that end where the fifth contact truly closes.

    python benchmarks/guards.py [SUITE ...] [--levels 1 2 3] [--samples 20] [--seed 0]

A guard would let a quasi-static stroke go on until the contact that ends it is felt, instead of stopping at the planned
angle. Here an oracle does that, better than any guard: on every perturbed sample both fingers are led through the
configuration in which the sample's own five contacts are closed. Printed: runs at the goal without and with the oracle.
"""

import argparse
from pathlib import Path
from typing import NamedTuple

import numpy as np

from wholearm_ros.control.mode_switch import course_of
from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.kernels.switch_law import Course
from wholearm_ros.mechanics.contacts import closed_pairs, contact_rows
from wholearm_ros.mechanics.world import World, build_world
from wholearm_ros.model.configuration import JOINTS, POSE
from wholearm_ros.model.interpolation import quintic
from wholearm_ros.model.modes import DWELL, QUASI_STATIC
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.rollout.perturbed_samples import (
    PerturbedSample,
    build_perturbed_samples,
    follow_course,
    start_at_rest,
)
from wholearm_ros.rollout.verification import MARGIN, SETTLE
from wholearm_ros.suite.suite_file import load_suite

HERE = Path(__file__).parent
CLOSED = 2e-6  # [m]
FURTHEST = 0.15  # [m, rad] that a true configuration may be from the planned one
FADE = 200  # samples in which the oracle's correction ends where no stroke follows
SAMPLE_SEED = 991  # unlike those of planning and certificates


class StrokeEnd(NamedTuple):
    """A stroke from row `begin` to row `end` of a trajectory, held until row `left`: q (5,) and the
    pairs that are closed there.
    """

    begin: int
    end: int
    left: int
    q: np.ndarray
    pairs: tuple[int, ...]


def stroke_ends(scenario: Scenario, trajectory: ManipulationTrajectory) -> list[StrokeEnd]:
    """Of all quasi-static strokes that end with five contacts or more."""
    world, segments, last = build_world(scenario), trajectory.segments, len(trajectory.angles) - 1
    found = []
    for one, following in zip(segments, (*segments[1:], None)):
        if one.mode != QUASI_STATIC:
            continue
        held = following is not None and following.mode == DWELL
        begin, end, left = (
            min(int(round(t / trajectory.period)), last)
            for t in (one.start, one.end, following.end if held else one.end)
        )
        q = np.concatenate([trajectory.poses[end], trajectory.angles[end]])
        pairs = closed_pairs(world, q, CLOSED)
        if len(pairs) >= 5:
            found.append(StrokeEnd(begin, end, left, q, pairs))
    return found


def true_configuration(world: World, q: np.ndarray, pairs: tuple[int, ...]) -> np.ndarray | None:
    """(5,) near q with the pairs closed in a sample's world, None when there is none."""
    near = q.copy()
    for _ in range(20):
        rows, gaps = contact_rows(world, pairs, near)
        if np.abs(gaps).max() < 1e-9:
            return near
        near = near - np.linalg.lstsq(rows, gaps, rcond=None)[0]
        if np.abs(near - q).max() > FURTHEST:
            return None
    return None


def with_oracle(
    trajectory: ManipulationTrajectory,
    course: Course,
    ends: list[StrokeEnd],
    sample: PerturbedSample,
) -> Course:
    """The course led through the sample's own configurations at the ends of strokes."""
    shift, before = np.zeros((len(trajectory.angles), 2)), np.zeros(2)
    for stroke in ends:
        there = true_configuration(sample.world, stroke.q, stroke.pairs)
        after = np.zeros(2) if there is None else (there - stroke.q)[JOINTS]
        share = quintic(np.linspace(0.0, 1.0, stroke.end - stroke.begin + 1))[0]
        shift[stroke.begin : stroke.end + 1] = before + share[:, None] * (after - before)
        shift[stroke.end : stroke.left + 1] = after
        fading = np.linspace(1.0, 0.0, FADE)[: len(shift) - stroke.left]
        shift[stroke.left : stroke.left + len(fading)] = fading[:, None] * after
        before = after
    rates = np.gradient(shift, trajectory.period, axis=0)
    return course._replace(angles=course.angles + shift, velocities=course.velocities + rates)


def arrives(sample: PerturbedSample, course: Course) -> bool:
    """Whether the sample ends at its goal."""
    run = follow_course(sample, course, start_at_rest(sample), ControlOptions(), SETTLE)
    return not run.stopped and not sample.goal.missing(run.q[POSE], MARGIN)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('suites', nargs='*', type=Path, default=[HERE / 'suite.json'])
    parser.add_argument('--levels', nargs='+', type=float, default=[1.0, 2.0, 3.0])
    parser.add_argument('--samples', type=int, default=20)
    parser.add_argument('--seed', type=int, default=0)
    options = parser.parse_args()
    plain, guarded = (np.zeros(len(options.levels), int) for _ in range(2))
    strokes = runs = 0
    for task in (task for suite in options.suites for task in load_suite(suite)):
        scenario = parse_scenario(task.scenario, task.name)
        trajectory = plan_and_verify(scenario, PlanRequest(seed=options.seed)).trajectory
        ends = stroke_ends(scenario, trajectory) if trajectory else []
        if not ends:
            continue
        course, strokes, runs = course_of(trajectory), strokes + len(ends), runs + options.samples
        for k, level in enumerate(options.levels):
            seed = (SAMPLE_SEED, k)
            for sample in build_perturbed_samples(scenario, options.samples, level, seed)[1:]:
                plain[k] += arrives(sample, course)
                guarded[k] += arrives(sample, with_oracle(trajectory, course, ends, sample))
        print(f'{task.name}: {plain} without, {guarded} with the oracle so far', flush=True)
    print(f'\n{strokes} strokes of {runs // options.samples} plans end with a fifth contact')
    print('| level | runs | at the goal | with the oracle |\n|---|---|---|---|')
    for level, *counts in zip(options.levels, plain, guarded):
        print(f'| {level:g} | {runs} | {counts[0]} | {counts[1]} |')


if __name__ == '__main__':
    main()
