"""Perturbed samples of a task, and what they do under the closed loop: forward dynamics with PD and open-loop torque."""

from dataclasses import dataclass
from typing import Sequence, Union

import numpy as np

from wholearm_ros.control.setpoints import PdGains
from wholearm_ros.kernels import time_stepping
from wholearm_ros.mechanics.world import World, build_world
from wholearm_ros.model.goal import GoalRegion, goal_region
from wholearm_ros.model.perturbation import NOMINAL, Perturbation, draw_perturbation
from wholearm_ros.model.scenario import Scenario
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
    """times (r,) [s], configurations (r, 5); q, v (5,) at the end; the largest residual of the LCPs [m/s]."""

    times: np.ndarray
    configurations: np.ndarray
    q: np.ndarray
    v: np.ndarray
    residual: float


def build_perturbed_samples(
    scenario: Scenario, count: int, level: float, seed: Union[int, Sequence[int]]
) -> tuple[PerturbedSample, ...]:
    """The nominal sample, and `count` perturbed ones at `level` (see Perturbation), always the same for a seed."""
    rng = np.random.default_rng(seed)
    drawn = (NOMINAL, *(draw_perturbation(rng, level, scenario) for _ in range(count)))
    return tuple(_sample(scenario, p) for p in drawn)


def _sample(scenario, perturbation):
    truth = perturbation.applied(scenario)
    world = build_world(truth)
    return PerturbedSample(
        world, perturbed_start(scenario, truth, world), goal_region(truth), perturbation
    )


def follow_setpoints(
    sample: PerturbedSample,
    q: np.ndarray,
    v: np.ndarray,
    period: float,
    angles: np.ndarray,
    velocities: np.ndarray,
    efforts: np.ndarray,
    velocity_fingers: np.ndarray,
    gains: PdGains,
    settle: float = 0.0,
) -> Run:
    """What a sample does from q, v (5,) when its fingers track angles, velocities, efforts (m, 2), given every `period` [s].

    velocity_fingers: (m,) the velocity-controlled finger from each sample on; settle [s]: of holding the last one.
    """
    w, p = sample.world, sample.perturbation
    size = int((period * (len(angles) - 1) + settle) / RECORD_EVERY) + 4
    q, v = np.array(q, dtype=float), np.array(v, dtype=float)
    qs, vs = np.empty((size, 5)), np.empty((size, 5))
    count, residual = time_stepping.run_trajectory(
        *w.geometry,
        w.corners,
        w.inertias,
        w.load,
        w.finger_moment,
        w.torque_limits,
        p.friction,
        p.torque_factors,
        int(round(p.actuation_delay / STEP)),
        gains.kp,
        gains.kd,
        STEP,
        period,
        angles,
        velocities,
        efforts,
        velocity_fingers,
        int(round(settle / STEP)),
        q,
        v,
        int(round(RECORD_EVERY / STEP)),
        qs,
        vs,
    )
    return Run(RECORD_EVERY * np.arange(count), qs[:count], q, v, residual)
