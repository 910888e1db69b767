"""The velocity controller: PD feedback on the planned motion, with the equilibrium torque fed forward."""

import math

from wholearm_ros.control.setpoints import PdGains, VelocitySetpoint
from wholearm_ros.model.hand import Finger


def velocity_effort(
    gains: PdGains, finger: Finger, setpoint: VelocitySetpoint, angle: float, velocity: float
) -> float:
    """Motor torque [N m] for a measured `angle` [rad] and `velocity` [rad/s], within the finger's limit.

    Zero when a measurement is not finite: without a reading, feedback can only do harm.
    """
    effort = (
        setpoint.feedforward
        + gains.kp * (setpoint.angle - angle)
        + gains.kd * (setpoint.velocity - velocity)
    )
    if not math.isfinite(effort):
        return 0.0
    return max(-finger.torque_limit, min(finger.torque_limit, effort))
