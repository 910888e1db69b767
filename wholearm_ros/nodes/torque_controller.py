"""The planned torque of the torque-controlled finger, open loop, its rate of change limited."""

import math

from wholearm_ros.control.open_loop_torque import torque_effort
from wholearm_ros.control.setpoints import Joints, TorqueSetpoint
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.common_parameters import SCENARIO, SLEW_LIMIT, scenario_of
from wholearm_ros.ros.interface.messages import to_torque_setpoint
from wholearm_ros.ros.interface.parameters import Declared
from wholearm_ros.ros.node.controller_node import ControllerNode
from wholearm_ros.ros.node.run import run_node

MOTOR_RATE = Declared(
    'motor_rate', 1000.0, 'of the hardware, for the limit on the rate of change [Hz]', 50.0, 2000.0
)


class TorqueController(ControllerNode):
    """torque_setpoint, joint_states → joint_commands.

    The effort from which the rate of change is limited is the one that the drives report, or the
    last one commanded where they report none.
    """

    def __init__(self) -> None:
        super().__init__(
            'torque_controller',
            (SCENARIO, SLEW_LIMIT, MOTOR_RATE),
            channels.TORQUE_SETPOINT,
            to_torque_setpoint,
        )
        self.hand = scenario_of(self.parameters).hand

    def effort(self, setpoint: TorqueSetpoint, joints: Joints) -> float:
        """[N m] of the joint `setpoint.joint`."""
        j = setpoint.joint
        before = joints.efforts[j]
        if not math.isfinite(before):
            before = self.last_efforts[j]
        return torque_effort(
            self.hand[j],
            setpoint,
            before,
            self.parameters.slew_limit,
            1.0 / self.parameters.motor_rate,
        )


def main() -> None:
    """The executable."""
    run_node(TorqueController)


if __name__ == '__main__':
    main()
