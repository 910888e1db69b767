"""Bands: every survivor is inside of the band that was made of it, all the way; few survivors give none."""

import numpy as np
import pytest
from problems import ASYMMETRIC

from wholearm_ros.planning.routes import plan
from wholearm_ros.rollout.band import FEWEST, NOISE, build_band
from wholearm_ros.rollout.perturbed_samples import RECORD_EVERY
from wholearm_ros.rollout.verification import SETTLE, Rollout
from wholearm_ros.trajectory.execution_options import ExecutionOptions
from wholearm_ros.trajectory.main_trajectory import generate

TRAJECTORY = generate(ASYMMETRIC, plan(ASYMMETRIC), ExecutionOptions())


def rollouts(count: int, success: bool = True, size: float = 0.01) -> list:
    """Fingers that follow the plan, each some random milliradians off."""
    rng = np.random.default_rng(count)
    times = RECORD_EVERY * np.arange(int((TRAJECTORY.duration + SETTLE) / RECORD_EVERY) + 1)
    planned = np.array([TRAJECTORY.sample(t).angles for t in times])
    made = []
    for _ in range(count):
        angles = planned + size * rng.uniform(-1.0, 1.0, 2)
        configurations = np.hstack([np.zeros((len(times), 3)), angles])
        made.append(Rollout(times, configurations, success, '' if success else 'dropped', 0.0))
    return made


def test_survivors_are_inside_and_what_failed_does_not_widen_it():
    survivors = rollouts(FEWEST)
    band = build_band(TRAJECTORY, survivors + rollouts(5, success=False, size=1.0))
    assert band.duration == pytest.approx(TRAJECTORY.duration + SETTLE, abs=2 * RECORD_EVERY)
    for rollout in survivors:
        angles = rollout.configurations[: len(band.low), 3:]
        assert (angles > band.low + NOISE - 1e-5).all() and (
            angles < band.high - NOISE + 1e-5
        ).all()
    assert (band.high - band.low).max() < 0.1


def test_too_few_survivors_give_no_band():
    assert build_band(TRAJECTORY, rollouts(FEWEST - 1) + rollouts(9, success=False)) is None
