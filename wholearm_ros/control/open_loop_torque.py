"""The torque controller: the planned torque, open loop, its rate of change limited."""

import math

from wholearm_ros.control.setpoints import TorqueSetpoint
from wholearm_ros.model.hand import Finger


def torque_effort(
    finger: Finger, setpoint: TorqueSetpoint, previous_effort: float, slew_limit: float, dt: float
) -> float:
    """Motor torque [N m]: the setpoint within the finger's limit, at most `slew_limit` [N m/s] · `dt` [s] away from
    `previous_effort` [N m]. A setpoint that is not finite leaves the effort where it was."""
    wanted = setpoint.effort if math.isfinite(setpoint.effort) else previous_effort
    step = slew_limit * dt
    effort = max(previous_effort - step, min(previous_effort + step, wanted))
    return max(-finger.torque_limit, min(finger.torque_limit, effort))
