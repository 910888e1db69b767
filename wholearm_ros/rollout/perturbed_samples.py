"""Perturbed samples of a task, and what they do under the closed loop: forward dynamics with PD
and open-loop torque.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Union

import numpy as np

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.kernels.rollout import ClosedLoop, Plant, Record, Start, run_trajectory
from wholearm_ros.kernels.switch_law import Course, Switch
from wholearm_ros.mechanics.world import World, build_world
from wholearm_ros.model.configuration import SIZE
from wholearm_ros.model.goal import GoalRegion, goal_region
from wholearm_ros.model.perturbation import NOMINAL, Perturbation, draw_perturbation
from wholearm_ros.model.scenario import Scenario, StartOnEdge
from wholearm_ros.rollout.initial_state import perturbed_start

STEP = 0.001  # [s]
RECORD_EVERY = 0.02  # [s]


@dataclass(frozen=True, eq=False)
class PerturbedSample:
    """The hand and object as they might truly be: its arrays, start (5,), goal and actuation."""

    world: World
    start: np.ndarray
    goal: GoalRegion
    perturbation: Perturbation


@dataclass(frozen=True, eq=False)
class Run:
    """times (r,) [s], configurations (r, 5); q, v (5,) at the end; the largest residual of the
    LCPs [m/s]; stops_met: (2, 2) bool, whether the left and the right finger came to bear on
    its low and high end stop; switch: the mode switch at the end; commands: (c, 2) [N m] of the
    first periods.
    """

    times: np.ndarray
    configurations: np.ndarray
    q: np.ndarray
    v: np.ndarray
    residual: float
    stops_met: np.ndarray
    switch: Switch
    commands: np.ndarray

    @property
    def stopped(self) -> bool:
        """Whether the mode switch stopped the run."""
        return bool(self.switch.stops)


def build_perturbed_samples(
    scenario: Scenario,
    count: int,
    level: float,
    seed: Union[int, Sequence[int]],
    hand_errors: float = 0.0,
    start_x_error: float = 0.0,
) -> tuple[PerturbedSample, ...]:
    """The nominal sample, and `count` perturbed ones at `level` (see Perturbation), always the
    same for a seed.

    hand_errors: level of the HandErrors; start_x_error: [m] by which the perturbed ones, on their
    edge, lie elsewhere than told besides.
    """
    rng = np.random.default_rng(seed)
    drawn = [draw_perturbation(rng, level, scenario, hand_errors) for _ in range(count)]
    shifts = start_x_error * rng.uniform(-1.0, 1.0, size=count)
    perturbed = (_sample(scenario, p, x) for p, x in zip(drawn, shifts))
    return (_sample(scenario, NOMINAL), *perturbed)


def _sample(scenario: Scenario, perturbation: Perturbation, shift: float = 0.0) -> PerturbedSample:
    truth = perturbation.applied(scenario)
    if shift and isinstance(truth.start, StartOnEdge):
        truth = replace(truth, start=replace(truth.start, x=truth.start.x + shift))
    world = build_world(truth)
    return PerturbedSample(
        world, perturbed_start(scenario, truth, world), goal_region(truth), perturbation
    )


def moved_sample(scenario: Scenario, sample: PerturbedSample, x: float) -> PerturbedSample:
    """The same hand and object at the start of `scenario`, but at x [m], where they truly are."""
    start, p = scenario.start, sample.perturbation
    assert isinstance(start, StartOnEdge)
    return _sample(scenario, p, x - start.x - p.hand.start_x)


def start_at_rest(sample: PerturbedSample) -> Start:
    """At the sample's start, the drives holding the fingers and asked for their weight."""
    q = sample.start
    return Start(q, np.zeros(SIZE), sample.world.bearing(q), True, -1)


def follow_course(
    sample: PerturbedSample,
    course: Course,
    start: Start,
    controls: ControlOptions,
    settle: float = 0.0,
    commands: int = 0,
) -> Run:
    """What a sample does under the closed loop of `control/` along a course, and for `settle` [s]
    of holding its end.

    commands: how many periods' commands to keep.
    """
    rows = int((course.period * (len(course.angles) - 1) + settle) / RECORD_EVERY) + 4
    record = Record(
        np.empty((rows, SIZE)),
        np.empty((rows, SIZE)),
        int(round(RECORD_EVERY / STEP)),
        np.empty(SIZE),
        np.empty(SIZE),
        np.empty((commands, 2)),
        np.zeros((2, 2), np.bool_),
    )
    lead = controls.ramp if start.at_rest else 0.0
    length = lead + course.period * (len(course.angles) - 1) + settle
    plant = _plant(sample.perturbation, int(np.ceil(length / STEP)) + 1)
    q, v, efforts = (np.array(values) for values in (start.q, start.v, start.efforts))
    start = start._replace(q=q, v=v, efforts=efforts)
    loop = ClosedLoop(plant, controls.law(STEP), controls.switch_law())
    count, residual, switch = run_trajectory(sample.world, loop, course, start, settle, record)
    times = RECORD_EVERY * np.arange(count)
    return Run(
        times,
        record.q[:count],
        record.last_q,
        record.last_v,
        residual,
        record.stops_met,
        switch,
        record.commands,
    )


def _plant(p: Perturbation, readings: int) -> Plant:
    """With the noise that `simulation.actuation.Encoders` draws, reading after reading."""
    noise = np.empty((0, 2, 2))
    if p.encoder_noise or p.velocity_noise:
        noise = np.random.default_rng(p.noise_seed).standard_normal((readings, 2, 2))
        noise *= np.array([p.encoder_noise, p.velocity_noise])[:, None]
    delay = int(round(p.actuation_delay / STEP))
    return Plant(p.friction, p.torque_factors, delay, p.hand.encoder_zeros, noise)
