"""The velocity controller: PD feedback on the planned motion, equilibrium torque fed forward."""

from wholearm_ros.control.setpoints import PdGains, VelocitySetpoint
from wholearm_ros.kernels.control_law import pd_effort
from wholearm_ros.model.hand import Finger


def velocity_effort(
    gains: PdGains, finger: Finger, setpoint: VelocitySetpoint, angle: float, velocity: float
) -> float:
    """Motor torque [N m] for a measured `angle` [rad] and `velocity` [rad/s], within the finger's
    limit.

    Zero when a measurement is not finite: without a reading, feedback can only do harm.
    """
    effort: float = pd_effort(gains, finger.torque_limit, setpoint, angle, velocity)
    return effort
