"""The torque controller: the planned torque, open loop, its rate of change limited."""

from wholearm_ros.control.setpoints import TorqueSetpoint
from wholearm_ros.kernels.control_law import slewed_effort
from wholearm_ros.model.hand import Finger


def torque_effort(
    finger: Finger, setpoint: TorqueSetpoint, previous_effort: float, slew_limit: float, dt: float
) -> float:
    """Motor torque [N m]: the setpoint within the finger's limit, at most `slew_limit` [N m/s] ·
    `dt` [s] away from `previous_effort` [N m]. A setpoint that is not finite leaves the effort
    where it was.
    """
    step = slew_limit * dt
    effort: float = slewed_effort(finger.torque_limit, step, setpoint.effort, previous_effort)
    return effort
