"""Duration of a segment by a fifth-order polynomial (MAIN_TRAJECTORY step 5)."""

import numpy as np

from wholearm_ros.model.interpolation import PEAK_ACCELERATION, PEAK_SPEED

SHORTEST = 0.08  # [s] of one segment


def segment_duration(distance: float, fastest: float, speed: float, acceleration: float) -> float:
    """Least duration [s] in which the velocity finger turns by `distance` [rad] and every
    coordinate keeps to its limits.

    fastest: ratio of the speed of the fastest coordinate to that of the velocity finger, in scaled
    coordinates; speed, acceleration: limits of all of them [rad/s, rad/s²].
    """
    d = abs(distance) * max(1.0, fastest)
    by_acceleration = float(np.sqrt(PEAK_ACCELERATION * d / acceleration))
    return max(SHORTEST, PEAK_SPEED * d / speed, by_acceleration)
