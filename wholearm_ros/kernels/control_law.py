"""The control law: what either finger's motor is asked for. Plain formulas that numba can compile.

The nodes and the closed loop without ROS call these functions as they are; `kernels/rollout.py`
compiles them. What is verified is what is run.
"""

import math
from typing import NamedTuple


class PdGains(NamedTuple):
    """kp [N m/rad], kd [N m s/rad]."""

    kp: float
    kd: float


class VelocitySetpoint(NamedTuple):
    """Motion of the velocity-controlled finger. joint: LEFT or RIGHT; angle [rad], velocity
    [rad/s], feedforward: equilibrium torque [N m], gravity included.
    """

    joint: int
    angle: float
    velocity: float
    feedforward: float


class TorqueSetpoint(NamedTuple):
    """Torque of the torque-controlled finger. joint: LEFT or RIGHT; effort [N m], gravity
    included.
    """

    joint: int
    effort: float


class ControlLaw(NamedTuple):
    """gains of the velocity-controlled finger; slew_limit [N m/s] of the torque-controlled one;
    period [s] of control and of the physics.
    """

    gains: PdGains
    slew_limit: float
    period: float


HOLD_GAINS = PdGains(60.0, 1.5)  # of the drives' own position hold before the first command


def pd_effort(gains, limit, setpoint, angle, velocity):
    """PD feedback [N m] on a VelocitySetpoint for a measured angle [rad] and velocity [rad/s],
    within ± limit.

    Zero when a measurement is not finite: without a reading, feedback can only do harm.
    """
    effort = (
        setpoint.feedforward
        + gains.kp * (setpoint.angle - angle)
        + gains.kd * (setpoint.velocity - velocity)
    )
    if not math.isfinite(effort):
        return 0.0
    return max(-limit, min(limit, effort))


def slewed_effort(limit, step, wanted, previous):
    """`wanted` [N m] within ± limit, at most `step` [N m] away from `previous`; not finite, it
    leaves the effort there.
    """
    if not math.isfinite(wanted):
        wanted = previous
    effort = max(previous - step, min(previous + step, wanted))
    return max(-limit, min(limit, effort))


def holding_effort(gains, weight, held, angle, velocity):
    """What the drives do without a command [N m]: hold the joint at `held` [rad], its weight
    compensated: the torque [N m] that bears it at `angle`.
    """
    return weight + gains.kp * (held - angle) - gains.kd * velocity


def holding_angle(gains, weight, torque, angle):
    """Where [rad] a joint at rest at `angle` has to be held for its holding to begin with `torque`
    [N m], so that what it bears does not sink.
    """
    return angle + (torque - weight) / gains.kp
