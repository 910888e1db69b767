"""Control mode: which finger is velocity-controlled (III-B.4)."""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.kernels import geometry
from wholearm_ros.mechanics.contacts import contact_rows
from wholearm_ros.mechanics.world import World


@dataclass(frozen=True)
class ControlMode:
    """What speaks for and against one finger as the velocity-controlled one.

    degree_of_constraint: constraints that palm and velocity finger put on the object, redundant ones counted, too, as it is
    they that jam when positions are not exact (the smaller the better);
    conditioning: ratio of the least to the largest singular value of [G_nᵀ, −J_nT] in scaled coordinates, 0 when condition 1
    of II-C fails: how well the velocity finger's motion and the other one's torque determine everything else.
    """

    velocity_finger: int
    degree_of_constraint: int
    conditioning: float


def control_mode(world: World, pairs: tuple, q: np.ndarray, velocity_finger: int) -> ControlMode:
    """Judge `velocity_finger` (LEFT or RIGHT) at a configuration with four closed pairs."""
    rows = contact_rows(world, pairs, q)[0] * world.scale
    bodies = np.array([geometry.pair_body(c) for c in pairs])
    constraints = int(((bodies == geometry.PALM) | (bodies == 1 + velocity_finger)).sum())
    dependent = np.delete(rows, 3 + velocity_finger, axis=1)  # (4, 4) = [G_nᵀ, −J_nT]
    values = np.linalg.svd(dependent, compute_uv=False)
    return ControlMode(velocity_finger, constraints, float(values[-1] / values[0]))
