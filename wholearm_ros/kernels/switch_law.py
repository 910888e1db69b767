"""The switch law: what both fingers are asked for in one period of a trajectory, and what stops
it. Plain formulas that numba can compile.

`control/mode_switch.py` calls `switch_period` as it is; `kernels/rollout.py` compiles it. What is
verified is what is run.
"""

import math
from typing import NamedTuple

import numpy as np

from wholearm_ros.kernels.control_law import TorqueSetpoint, VelocitySetpoint
from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.interpolation import fade, hermite

NO_FINGER = -1  # before the first period
NO_BAND = readonly(np.empty((0, 2)))


class SwitchLaw(NamedTuple):
    """ramp, handover [s]; max_tracking_error [rad] of the velocity-controlled finger, beyond which
    the run stops; stop_outside: whether a run that has deviated from its band stops, too.
    """

    ramp: float
    handover: float
    max_tracking_error: float
    stop_outside: bool


class Course(NamedTuple):
    """A trajectory as arrays. angles, velocities, efforts: (m, 2) every `period` [s]; ends: (s,)
    of its segments [s]; fingers: (s,) the velocity-controlled one in each; low, high: (k, 2)
    [rad] of its band every band_period [s], k = 0 for none; patience [s]: how long a finger may
    be outside of it.
    """

    period: float
    angles: np.ndarray
    velocities: np.ndarray
    efforts: np.ndarray
    ends: np.ndarray
    fingers: np.ndarray
    band_period: float = 1.0
    low: np.ndarray = NO_BAND
    high: np.ndarray = NO_BAND
    patience: float = 0.0


class Outside(NamedTuple):
    """since [s]: when a finger left the band, infinite while both are inside; deviated [s]: along
    the trajectory, when it had been outside for longer than the patience for the first time,
    infinite before; left, right [rad]: how far outside then.
    """

    since: float
    deviated: float
    left: float
    right: float


class Switch(NamedTuple):
    """began [s]: when the ramp began; elapsed [s]: along the trajectory, negative while ramping
    in; segment: its number; finger: the velocity-controlled one; handed_over [s]: when it took
    over, offset [rad]: how far it was from the plan then; error [rad]: the tracking error on
    which the run stops, 0 while it goes on; outside: of the band; stops: whether the run ends
    here.
    """

    began: float
    elapsed: float
    segment: int
    finger: int
    handed_over: float
    offset: float
    error: float
    outside: Outside
    stops: bool


def switch_at(began, finger):
    """The switch before its first period. began [s]; finger: the velocity-controlled one so far,
    NO_FINGER for none.
    """
    outside = Outside(math.inf, math.inf, 0.0, 0.0)
    return Switch(began, 0.0, 0, finger, -math.inf, 0.0, 0.0, outside, False)


def switch_period(law, course, first_efforts, switch, t, angles):
    """(next switch, VelocitySetpoint, TorqueSetpoint) at time t [s] for measured angles (2,)
    [rad].

    The plan's sample, ramped in from the efforts found at the start, first_efforts (2,) [N m]; a
    finger that becomes velocity-controlled is led from where it is to where it should be. When it
    stops the setpoints do not count.
    """
    elapsed = t - switch.began - law.ramp
    segment = switch.segment
    while segment < course.ends.shape[0] - 1 and elapsed >= course.ends[segment]:
        segment += 1
    finger, handed_over, offset = switch.finger, switch.handed_over, switch.offset
    if course.fingers[segment] != finger:
        finger, handed_over = course.fingers[segment], t
        offset = angles[finger] - planned_angle(course, elapsed, finger)
    span = law.ramp if handed_over == switch.began else law.handover
    fading, rate = fade(t - handed_over, span)
    motion = VelocitySetpoint(
        finger,
        planned_angle(course, elapsed, finger) + offset * fading,
        planned_speed(course, elapsed, finger) + offset * rate,
        _effort(law, course, first_efforts, switch.began, t, finger),
    )
    torque = TorqueSetpoint(
        1 - finger, _effort(law, course, first_efforts, switch.began, t, 1 - finger)
    )
    error = angles[finger] - motion.angle
    if abs(error) <= law.max_tracking_error:
        error = 0.0
    outside = watch_band(course, switch.outside, elapsed, t, angles)
    stops = error != 0.0 or (law.stop_outside and outside.deviated < math.inf)
    after = Switch(
        switch.began, elapsed, segment, finger, handed_over, offset, error, outside, stops
    )
    return after, motion, torque


def watch_band(course, before, elapsed, t, angles):
    """The monitor: `Outside` after the one before, at time t [s], `elapsed` [s] along the course,
    for measured angles (2,).
    """
    left, right = _excess(course, elapsed, angles, 0), _excess(course, elapsed, angles, 1)
    if left == 0.0 and right == 0.0:
        return Outside(math.inf, before.deviated, before.left, before.right)
    since = min(before.since, t)
    if before.deviated < math.inf or t - since <= course.patience:
        return Outside(since, before.deviated, before.left, before.right)
    return Outside(since, elapsed, left, right)


def _excess(course, elapsed, angles, finger):
    """How far [rad] a finger is above (positive) or below (negative) the band; 0 inside, and where
    there is none.
    """
    last = course.low.shape[0] - 1
    s = elapsed / course.band_period
    if not 0.0 <= s <= last:
        return 0.0
    i = min(int(s), last - 1)
    u = s - i
    low = (1 - u) * course.low[i, finger] + u * course.low[i + 1, finger]
    high = (1 - u) * course.high[i, finger] + u * course.high[i + 1, finger]
    return min(angles[finger] - low, 0.0) + max(angles[finger] - high, 0.0)


def planned_angle(course, elapsed, finger):
    """[rad] at a time [s] along the course, held at both ends."""
    i, u = _place(course, elapsed)
    angles, velocities = course.angles, course.velocities
    return hermite(
        angles[i, finger],
        angles[i + 1, finger],
        velocities[i, finger],
        velocities[i + 1, finger],
        course.period,
        u,
    )


def planned_speed(course, elapsed, finger):
    """[rad/s] at a time [s] along the course, zero beyond both ends."""
    if elapsed < 0.0 or elapsed > course.period * (course.angles.shape[0] - 1):
        return 0.0
    i, u = _place(course, elapsed)
    return (1 - u) * course.velocities[i, finger] + u * course.velocities[i + 1, finger]


def _effort(law, course, first_efforts, began, t, finger):
    """The planned effort of a finger [N m], ramped in from the one found at the start."""
    i, u = _place(course, t - began - law.ramp)
    planned = (1 - u) * course.efforts[i, finger] + u * course.efforts[i + 1, finger]
    part = 1.0 - fade(t - began, law.ramp)[0]
    return first_efforts[finger] + part * (planned - first_efforts[finger])


def _place(course, elapsed):
    """(sample, share of the period after it) at a time, held at both ends."""
    last = course.angles.shape[0] - 1
    s = min(max(elapsed / course.period, 0.0), float(last))
    i = min(int(s), last - 1)
    return i, s - i
