"""A trajectory that only holds the fingers where they are: it goes before a probe alone."""

import uuid
from dataclasses import replace

import numpy as np

from wholearm_ros.estimation.feel import Feeler, Felt
from wholearm_ros.estimation.probe_plan import probe_after, probe_of_the_unknown
from wholearm_ros.model.hand import CLOSING, LEFT
from wholearm_ros.model.modes import DYNAMIC
from wholearm_ros.model.trajectory import ManipulationTrajectory, Segment
from wholearm_ros.model.weight import bearing_torques

DURATION, PERIOD = 0.1, 0.01  # [s]
# [rad] of either finger since the last squeeze: what it lay on may be gone, or the hand was reset.
MOVED = 0.05


def hold_trajectory(
    angles: np.ndarray, weights: np.ndarray, pose: np.ndarray, held: int, squeeze: float = 0.0
) -> ManipulationTrajectory:
    """Both fingers at `angles` (2,) [rad], bearing their own weight; weights: (2, 2)
    [N m], see `bearing_torques`; pose: (3,) of the object, a guess; held: LEFT or RIGHT, the
    velocity-controlled finger; squeeze [N m]: with which the other one closes besides.
    """
    rows = int(round(DURATION / PERIOD)) + 1
    angles = np.asarray(angles, float)
    name = uuid.uuid5(uuid.NAMESPACE_OID, f'hold {angles.tolist()} {np.asarray(pose).tolist()}')
    efforts = bearing_torques(weights, angles)
    efforts[1 - held] += CLOSING[1 - held] * squeeze
    return ManipulationTrajectory(
        plan_id=str(name),
        period=PERIOD,
        angles=np.tile(angles, (rows, 1)),
        velocities=np.zeros((rows, 2)),
        efforts=np.tile(efforts, (rows, 1)),
        torque_ranges=np.full((rows, 2), np.nan),
        poses=np.tile(pose, (rows, 1)),
        segments=(Segment(0.0, PERIOD * (rows - 1), DYNAMIC, held),),
    )


def hold_to_feel(
    feeler: Feeler,
    angles: np.ndarray,
    last: ManipulationTrajectory | None = None,
    felt: Felt | None = None,
) -> ManipulationTrajectory:
    """The fingers held at `angles` (2,) [rad], and the probe of what lies between them: from the
    other side than the probe of `last`, the trajectory that was executed before, which felt `felt`;
    from the same one if that did not come to its end, or the fingers have moved since; without
    these, of whatever it may be.

    An object that was squeezed is squeezed on, with the torque of that probe: a finger that bears
    its own weight only drifts off.
    """
    weights = feeler.model.world.finger_weights
    if last is None or last.probe is None or felt is None:
        hold = hold_trajectory(angles, weights, feeler.hypotheses[0].pose, LEFT)
        return replace(hold, probe=probe_of_the_unknown(feeler, LEFT, angles))
    squeezed = felt.squeezes is not None and np.abs(angles - felt.pairs[-1]).max() < MOVED
    squeeze = last.probe.torque if squeezed else 0.0
    hold = hold_trajectory(angles, weights, last.poses[-1], last.probe.held, squeeze)
    return replace(hold, probe=probe_after(feeler, hold, again=squeezed))
