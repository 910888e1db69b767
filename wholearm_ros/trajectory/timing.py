"""Duration of a segment by a fifth-order polynomial (MAIN_TRAJECTORY step 5)."""

import numpy as np

PEAK_SPEED = 15.0 / 8.0  # of s(u) = 10 u³ − 15 u⁴ + 6 u⁵, per unit of distance and time
PEAK_ACCELERATION = 10.0 / 3.0**0.5
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
