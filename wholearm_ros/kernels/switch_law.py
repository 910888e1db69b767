"""The switch law: what both fingers are asked for in one period of a trajectory, and what stops it. Plain formulas that numba
can compile.

`control/mode_switch.py` calls `switch_period` as it is; `kernels/rollout.py` compiles it. What is verified is what is run.
"""

import math
from typing import NamedTuple

import numpy as np

from wholearm_ros.kernels.control_law import TorqueSetpoint, VelocitySetpoint
from wholearm_ros.model.interpolation import fade, hermite

NO_FINGER = -1  # before the first period


class SwitchLaw(NamedTuple):
    """ramp, handover [s]; max_tracking_error [rad] of the velocity-controlled finger, beyond which the run stops."""

    ramp: float
    handover: float
    max_tracking_error: float


class Course(NamedTuple):
    """A trajectory as arrays. angles, velocities, efforts: (m, 2) every `period` [s]; ends: (s,) of its segments [s];
    fingers: (s,) the velocity-controlled one in each."""

    period: float
    angles: np.ndarray
    velocities: np.ndarray
    efforts: np.ndarray
    ends: np.ndarray
    fingers: np.ndarray


class Switch(NamedTuple):
    """began [s]: when the ramp began; elapsed [s]: along the trajectory, negative while ramping in; segment: its number;
    finger: the velocity-controlled one; handed_over [s]: when it took over, offset [rad]: how far it was from the plan then;
    error [rad]: the tracking error on which the run stops, 0 while it goes on."""

    began: float
    elapsed: float
    segment: int
    finger: int
    handed_over: float
    offset: float
    error: float


def switch_at(began, finger):
    """The switch before its first period. began [s]; finger: the velocity-controlled one so far, NO_FINGER for none."""
    return Switch(began, 0.0, 0, finger, -math.inf, 0.0, 0.0)


def switch_period(law, course, first_efforts, switch, t, angles):
    """(next switch, VelocitySetpoint, TorqueSetpoint) at time t [s] for measured angles (2,) [rad].

    The plan's sample, ramped in from the efforts found at the start, first_efforts (2,) [N m]; a finger that becomes
    velocity-controlled is led from where it is to where it should be. With an `error` in it the setpoints do not count.
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
    after = Switch(switch.began, elapsed, segment, finger, handed_over, offset, error)
    return after, motion, torque


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
