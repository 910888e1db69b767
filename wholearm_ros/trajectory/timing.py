"""Fifth-order polynomials from rest to rest, and how long they must take (MAIN_TRAJECTORY step 5)."""

import numpy as np

PEAK_SPEED = 15.0 / 8.0  # of s(u) = 10 u³ − 15 u⁴ + 6 u⁵, per unit of distance and time
PEAK_ACCELERATION = 10.0 / 3.0**0.5
SHORTEST = 0.08  # [s] of one stroke


def stroke_duration(distance: float, fastest: float, speed: float, acceleration: float) -> float:
    """Least duration [s] of a stroke of the velocity finger over `distance` [rad].

    fastest: how many times as fast as it the fastest other coordinate moves (all in scaled coordinates);
    speed, acceleration: limits [rad/s, rad/s²] for all of them.
    """
    d = abs(distance) * max(1.0, fastest)
    return max(SHORTEST, PEAK_SPEED * d / speed, np.sqrt(PEAK_ACCELERATION * d / acceleration))
