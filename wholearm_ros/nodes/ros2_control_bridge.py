"""Drives under ros2_control as the hand: joint_state_broadcaster in, forward_command_controller
out. A managed node: the motors are off until it is activated.
"""

import time

import numpy as np
from rclpy.lifecycle import LifecycleNodeMixin, LifecycleState, TransitionCallbackReturn
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from std_srvs.srv import Trigger

from wholearm_ros.control.command_watchdog import BRAKE, STOPPED, CommandWatchdog
from wholearm_ros.control.joint_map import JointMap
from wholearm_ros.control.setpoints import Joints
from wholearm_ros.control.torque_drives import TorqueDrives
from wholearm_ros.model.hand import JOINT_NAMES
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.common_parameters import (
    COMMAND_TIMEOUT,
    HOLD_TIME,
    KD,
    KP,
    SCENARIO,
    gains_of,
    scenario_of,
)
from wholearm_ros.ros.interface.joint_state_serialization import NANOSECONDS, JointReading
from wholearm_ros.ros.interface.messages import joint_states_bytes, to_commands, to_joints
from wholearm_ros.ros.interface.parameters import Declared, ParameterError
from wholearm_ros.ros.node.drives_health import drives_health
from wholearm_ros.ros.node.loop_meter import LoopMeter
from wholearm_ros.ros.node.node import ERROR, OK, WARN, Health, WholeArmNode
from wholearm_ros.ros.node.run import run_node
from wholearm_ros.ros.visualization.robot_description import urdf

DECLARED = (
    SCENARIO,
    KP,
    KD,
    COMMAND_TIMEOUT,
    HOLD_TIME,
    Declared('joints', list(JOINT_NAMES), "names of the drives' joints, left and right"),
    Declared('signs', [1.0, 1.0], 'our angle = sign * theirs + offset; 1 or -1', -1.0, 1.0),
    Declared('offsets', [0.0, 0.0], 'our angle where theirs is zero [rad]', -7.0, 7.0),
    Declared('broadcaster', '/joint_states', 'topic of joint_state_broadcaster'),
    Declared(
        'controller',
        '/effort_controller/commands',
        'topic of forward_command_controller, effort of the left and the right joint in this order',
    ),
    Declared(
        'states_timeout',
        0.05,
        'without joint states beyond which the torque is zero [s]',
        0.002,
        1.0,
    ),
)
DRIVE_PERIOD = 0.005  # [s] between two torques at most: without commands the watchdog still acts
ZEROS = 3  # sent on the way out: the controller may listen best effort
Done = TransitionCallbackReturn


class Ros2ControlBridge(LifecycleNodeMixin, WholeArmNode):
    """broadcaster → joint_states; joint_commands → watchdog → controller.

    Configured, it passes joint states on; active, it commands. Stamps are those of arrival, on our
    clock. The drives hold the last torque they were given for ever, so torques are sent at least
    every DRIVE_PERIOD, and zero on the way out.
    """

    def __init__(self) -> None:
        WholeArmNode.__init__(self, 'ros2_control_bridge', DECLARED)
        p = self.parameters
        scenario, self.map = scenario_of(p), joint_map_of(p.joints, p.signs, p.offsets)
        hand = scenario.hand
        self.guard = CommandWatchdog(
            [hand.left.torque_limit, hand.right.torque_limit],
            round(p.command_timeout * NANOSECONDS),
            round(p.hold_time * NANOSECONDS) or None,
        )
        self.drives = TorqueDrives(scenario, gains_of(p), self.guard)
        self.drives.torques(0, Joints(0.0, np.zeros(2), np.zeros(2)))  # compiled now, not later
        self.configured = self.active = False
        self.joints: Joints | None = None  # the newest, ours
        self.stamp, self.heard, self.states, self.silences = 0, float('-inf'), 0, 0
        self.told, self.told_state, self.meter = np.zeros(2), BRAKE, LoopMeter()  # [N m], ours

        self.joint_states = self.publisher(channels.JOINT_STATES)
        self.description = self.publisher(channels.ROBOT_DESCRIPTION)
        self.description.publish(String(data=urdf(scenario, namespace=self.get_namespace())))
        self.controller = self.publisher(
            channels.Topic(p.controller, Float64MultiArray, channels.NEWEST)
        )
        self.subscription(
            channels.Topic(p.broadcaster, JointState, channels.RELIABLE, steady=True),
            self.on_states,
        )
        self.subscription(channels.JOINT_COMMANDS, self.on_command)
        self.service(channels.RESET, self.on_reset)
        self.service(channels.HARDWARE_STOP, self.on_stop)
        LifecycleNodeMixin.__init__(self)

        self.every(DRIVE_PERIOD, self.drive)

    def parameters_changed(self) -> None:
        """New gains count from the next torque on."""
        self.drives.gains = gains_of(self.parameters)

    def now(self) -> int:
        """[ns]"""
        return int(self.get_clock().now().nanoseconds)

    def on_states(self, message: JointReading) -> None:
        """Theirs become ours; without a measured effort the last one told is the effort."""
        _, theirs = to_joints(message, self.map.names)
        ours = self.map.to_ours(theirs)
        self.joints, self.heard, self.states = ours, time.monotonic(), self.states + 1
        self.stamp = max(self.now(), self.stamp + 1)
        if not self.configured:
            return
        efforts = np.where(np.isfinite(ours.efforts), ours.efforts, self.told)
        self.meter.sent(self.stamp)
        self.joint_states.publish(
            joint_states_bytes(self.stamp, ours.angles, ours.velocities, efforts)
        )
        if not self.guard.driven:  # else the answer to this state drives
            self.drive()

    def on_command(self, message: JointReading) -> None:
        """The second command of a stamp goes to the drives at once."""
        now = max(self.now(), self.stamp)
        taken = [
            self.guard.command(joint, message.stamp, effort, now)
            for joint, effort in to_commands(message)
        ]
        if any(taken):
            self.meter.answered(message.stamp)
            if self.guard.both_at(message.stamp):
                self.drive()

    def drive(self) -> None:
        """A torque for either drive: none before the activation, zero while their states are not
        known.
        """
        if not self.active:
            return
        if self.joints is not None and self.silent():
            self.joints, self.silences = None, self.silences + 1
            self.get_logger().error(f'no joint states on {self.parameters.broadcaster}')
        self.tell(self.drives.torques(max(self.now(), self.stamp), self.joints))
        if self.guard.driven:
            self.meter.acts(min(self.guard.newest))
        if self.guard.state != self.told_state:
            self.told_state = self.guard.state
            self.report()

    def tell(self, torques: np.ndarray) -> None:
        """torques: (2,) [N m], ours."""
        self.told = torques.copy()
        self.controller.publish(Float64MultiArray(data=self.map.to_theirs(torques).tolist()))

    def silent(self) -> bool:
        """Whether their joint states are missing."""
        return bool(time.monotonic() - self.heard > self.parameters.states_timeout)

    def on_configure(self, _: LifecycleState) -> TransitionCallbackReturn:
        """From now on there are joint states."""
        self.configured = True
        return Done.SUCCESS

    def on_activate(self, _: LifecycleState) -> TransitionCallbackReturn:
        """The drives hold the fingers until the first command; a stop outlasts it."""
        if self.silent():
            self.get_logger().error(
                f'not activated: no joint states on {self.parameters.broadcaster}'
            )
            return Done.FAILURE
        if not self.controller.get_subscription_count():
            self.get_logger().error(
                f'not activated: no controller listens on {self.parameters.controller}'
            )
            return Done.FAILURE
        if self.guard.state != STOPPED:
            self.guard.reset(self.now())
        self.drives.release()
        self.active = True
        self.drive()
        return Done.SUCCESS

    def on_deactivate(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Zero torque, and no command any more."""
        self.leave()
        return Done.SUCCESS

    def on_cleanup(self, _: LifecycleState) -> TransitionCallbackReturn:
        """No joint states any more."""
        self.configured = False
        return Done.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """From any state."""
        self.leave()
        return self.on_cleanup(state)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """As after a shutdown; it can be configured again."""
        return self.on_shutdown(state)

    def on_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Ends a stop or zero torque; nothing moves."""
        self.guard.reset(max(self.now(), self.stamp))
        response.success = True
        response.message = f'the drives hold both fingers{self.off()}'
        return response

    def on_stop(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Bypasses every other node."""
        self.guard.stop()
        self.drive()
        response.success = True
        response.message = (
            f'the drives hold both fingers and take no command until the reset{self.off()}'
        )
        return response

    def off(self) -> str:
        """For the answers of the services."""
        return '' if self.active else ' (not active: the motors are off)'

    def health(self) -> Health:
        """State of the drives, figures of the loop."""
        guard, p = self.guard, self.parameters
        values = {
            **guard.figures(),
            'lifecycle': self._state_machine.current_state[1],
            'stamp': self.stamp,
            'states': self.states,
            'silences': self.silences,
            **self.meter.figures(),
        }
        if self.silent():
            return (ERROR if self.active else WARN), f'no joint states on {p.broadcaster}', values
        if not self.active:
            return OK, 'not active: the motors are off', values
        return drives_health(guard, values)

    def leave(self) -> None:
        """Zero torque, which the drives then keep."""
        if self.active:
            self.active = False
            for _ in range(ZEROS):
                self.tell(np.zeros(2))


def joint_map_of(names: list[str], signs: list[float], offsets: list[float]) -> JointMap:
    """Raises ParameterError."""
    for name, values in (('joints', names), ('signs', signs), ('offsets', offsets)):
        if len(values) != 2:
            raise ParameterError(f'{name}: got {list(values)}; allowed: two, left and right')
    if names[0] == names[1] or not all(names):
        raise ParameterError(f'joints: got {list(names)}; allowed: two different names')
    if not {abs(sign) for sign in signs} <= {1.0}:
        raise ParameterError(f'signs: got {list(signs)}; allowed: 1.0 or -1.0 each')
    return JointMap((names[0], names[1]), np.array(signs), np.array(offsets))


def main() -> None:
    """The executable."""
    run_node(Ros2ControlBridge)


if __name__ == '__main__':
    main()
