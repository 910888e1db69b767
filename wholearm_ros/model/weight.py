"""What bears the weight of a finger, as plain formulas that `kernels/` compiles as they are."""

import numpy as np

from wholearm_ros.model.frame import Value


def bearing(along: Value, across: Value, cos: Value, sin: Value) -> Value:
    """Torque [N m] that holds a finger against gravity along -y; along, across [N m]: its weight
    times how far its centre of mass is from the axis along and across it; cosine and sine of its
    angle.
    """
    return along * cos - across * sin


def bearing_torques(weights: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """(…, 2) [N m] that hold both fingers at angles (…, 2) [rad]; weights: (2, 2) [N m], a row a
    finger: along and across it.
    """
    torques: np.ndarray = bearing(weights[:, 0], weights[:, 1], np.cos(angles), np.sin(angles))
    return torques
