"""A trajectory that only holds the fingers where they are: it goes before a probe alone."""

import uuid
from dataclasses import replace

import numpy as np

from wholearm_ros.estimation.feel import Feeler
from wholearm_ros.estimation.probe_plan import probe_after, probe_of_the_unknown
from wholearm_ros.model.hand import LEFT
from wholearm_ros.model.modes import DYNAMIC
from wholearm_ros.model.trajectory import ManipulationTrajectory, Segment
from wholearm_ros.model.weight import bearing_torques

DURATION, PERIOD = 0.1, 0.01  # [s]


def hold_trajectory(
    angles: np.ndarray, weights: np.ndarray, pose: np.ndarray, held: int
) -> ManipulationTrajectory:
    """Both fingers at `angles` (2,) [rad], bearing their own weight; weights: (2, 2)
    [N m], see `bearing_torques`; pose: (3,) of the object, a guess; held: LEFT or RIGHT, the finger
    that a probe holds afterwards.
    """
    rows = int(round(DURATION / PERIOD)) + 1
    angles = np.asarray(angles, float)
    name = uuid.uuid5(uuid.NAMESPACE_OID, f'hold {angles.tolist()} {np.asarray(pose).tolist()}')
    return ManipulationTrajectory(
        plan_id=str(name),
        period=PERIOD,
        angles=np.tile(angles, (rows, 1)),
        velocities=np.zeros((rows, 2)),
        efforts=np.tile(bearing_torques(weights, angles), (rows, 1)),
        torque_ranges=np.full((rows, 2), np.nan),
        poses=np.tile(pose, (rows, 1)),
        segments=(Segment(0.0, PERIOD * (rows - 1), DYNAMIC, held),),
    )


def hold_to_feel(
    feeler: Feeler, angles: np.ndarray, before: ManipulationTrajectory | None = None
) -> ManipulationTrajectory:
    """The fingers held at `angles` (2,) [rad], and the probe of what lies between them: from the
    other side than after `before`, whose probe has left it open, or without one of whatever it may
    be.
    """
    weights = feeler.model.world.finger_weights
    if before is None:
        hold = hold_trajectory(angles, weights, feeler.hypotheses[0].pose, LEFT)
        return replace(hold, probe=probe_of_the_unknown(feeler, LEFT, angles))
    held = 1 - before.segments[-1].velocity_finger
    hold = hold_trajectory(angles, weights, before.poses[-1], held)
    return replace(hold, probe=probe_after(feeler, hold, again=True))
