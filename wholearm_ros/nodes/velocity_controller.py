"""PD feedback on the velocity-controlled finger, its equilibrium torque fed forward."""

from wholearm_ros.control.pd_velocity import velocity_effort
from wholearm_ros.control.setpoints import Joints, VelocitySetpoint
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.common_parameters import KD, KP, SCENARIO, gains_of, scenario_of
from wholearm_ros.ros.interface.messages import to_velocity_setpoint
from wholearm_ros.ros.node.controller_node import ControllerNode
from wholearm_ros.ros.node.run import run_node


class VelocityController(ControllerNode):
    """velocity_setpoint, joint_states → joint_commands."""

    def __init__(self) -> None:
        super().__init__(
            'velocity_controller',
            (SCENARIO, KP, KD),
            channels.VELOCITY_SETPOINT,
            to_velocity_setpoint,
        )
        self.hand = scenario_of(self.parameters).hand
        self.gains = gains_of(self.parameters)

    def parameters_changed(self) -> None:
        """New gains count from the next command on."""
        self.gains = gains_of(self.parameters)

    def effort(self, setpoint: VelocitySetpoint, joints: Joints) -> float:
        """[N m] of the joint `setpoint.joint`."""
        j = setpoint.joint
        return velocity_effort(
            self.gains, self.hand[j], setpoint, joints.angles[j], joints.velocities[j]
        )


def main() -> None:
    """The executable."""
    run_node(VelocityController)


if __name__ == '__main__':
    main()
