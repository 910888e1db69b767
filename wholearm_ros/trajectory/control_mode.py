"""Control mode: which finger is velocity-controlled (III-B.4)."""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.kernels import geometry
from wholearm_ros.kernels.world import World
from wholearm_ros.mechanics.contacts import contact_rows
from wholearm_ros.model.configuration import joint_index


@dataclass(frozen=True)
class ControlMode:
    """How suitable one finger is as the velocity-controlled one.

    degree_of_constraint: number of constraints that palm and velocity finger put on the object
    (DOC, the smaller the better); redundant ones count, as they are what jams when positions are
    not exact; conditioning: ratio of the least to the largest singular value of [G_nᵀ, −J_nT] in
    scaled coordinates, that is, how well the motion of the velocity finger and the torque of the
    other one determine everything else; 0 when condition 1 of II-C fails.
    """

    velocity_finger: int
    degree_of_constraint: int
    conditioning: float


def control_mode(
    world: World, pairs: tuple[int, ...], q: np.ndarray, velocity_finger: int
) -> ControlMode:
    """Of `velocity_finger` (LEFT or RIGHT) at a configuration q (5,) with four closed pairs."""
    rows = contact_rows(world, pairs, q)[0] * world.scale
    bodies = np.array([geometry.pair_body(c) for c in pairs])
    constraints = int(((bodies == geometry.PALM) | (bodies == 1 + velocity_finger)).sum())
    dependent = np.delete(rows, joint_index(velocity_finger), axis=1)  # (4, 4) = [G_nᵀ, −J_nT]
    values = np.linalg.svd(dependent, compute_uv=False)
    return ControlMode(velocity_finger, constraints, float(values[-1] / values[0]))
