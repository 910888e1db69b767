"""The band of a trajectory: what its surviving rollouts say of where the fingers usually are."""

from collections.abc import Sequence

import numpy as np

from wholearm_ros.model.band import Band
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.rollout.perturbed_samples import RECORD_EVERY
from wholearm_ros.rollout.verification import SETTLE, Rollout

FEWEST = 20  # survivors of which a band is made
WIDENING = 3.0  # of the half width at each time: errors are larger than those of the samples
NOISE = 0.003  # [rad] beyond it: of readings, which rollouts do not record
PATIENCE = 0.2  # [s] outside
DIGITS = 5  # of an angle [rad]: a document shall be short


def build_band(trajectory: ManipulationTrajectory, rollouts: Sequence[Rollout]) -> Band | None:
    """From the rollouts that ended at the goal; None when there are too few of them."""
    count = int((trajectory.duration + SETTLE) / RECORD_EVERY)
    survived = [
        r.configurations[:count, 3:]
        for r in rollouts
        if r.success and len(r.configurations) >= count
    ]
    if len(survived) < FEWEST or count < 2:
        return None
    angles = np.array(survived)  # (survivors, count, 2)
    low, high = angles.min(axis=0), angles.max(axis=0)
    middle, half = (low + high) / 2, WIDENING * (high - low) / 2 + NOISE
    return Band(
        RECORD_EVERY, (middle - half).round(DIGITS), (middle + half).round(DIGITS), PATIENCE
    )
