"""A setpoint meets the joint state it was made for: what both controller nodes share."""
from typing import Optional, Tuple

from ..control.setpoints import Joints
from .messages import NANOSECONDS, fill_effort, joint_message, to_joints, to_nanoseconds
from .node import OK, STALE, WholeArmNode
from . import channels
from .parameters import Declared

SETPOINT_TIMEOUT = Declared('setpoint_timeout', 0.05, 'older than the newest joint state by more, a setpoint is not '
                            'acted on [s]', 0.001, 10.0)


class ControllerNode(WholeArmNode):
    """setpoint + joint state of the same stamp, or a newer one → one joint command with the setpoint's stamp.

    Nothing is remembered from one command to the next, so the same messages give the same commands. Without setpoints
    there are no commands, and the drives' watchdog holds the fingers.
    """

    def __init__(self, name: str, declared, topic: channels.Topic, read):
        super().__init__(name, (*declared, SETPOINT_TIMEOUT))
        self._read = read                     # message → setpoint
        self._waiting: Optional[Tuple] = None  # (stamp, setpoint) without a joint state yet
        self._newest: Optional[Tuple[int, Joints]] = None
        self.commanded, self.stale, self.last_joint = 0, 0, None
        self._command = joint_message(('',))
        self._commands = self.publisher(channels.JOINT_COMMANDS)
        self.subscription(topic, self._on_setpoint)
        self.subscription(channels.JOINT_STATES, self._on_joints)

    def effort(self, setpoint, joints: Joints) -> float:
        """[N m] of the joint `setpoint.joint`."""
        raise NotImplementedError

    def _on_setpoint(self, message):
        self._waiting = to_nanoseconds(message.header.stamp), self._read(message)
        self._act()

    def _on_joints(self, message):
        self._newest = to_joints(message)
        self._act()

    def _act(self):
        if not self._waiting or not self._newest or self._newest[0] < self._waiting[0]:
            return
        (stamp, setpoint), self._waiting = self._waiting, None
        if self._newest[0] - stamp > self.parameters.setpoint_timeout * NANOSECONDS:
            self.stale += 1
            return
        fill_effort(self._command, stamp, setpoint.joint, self.effort(setpoint, self._newest[1]))
        self._commands.publish(self._command)
        self.commanded, self.last_joint = self.commanded + 1, setpoint.joint

    def leave(self):
        """Zero torque on the way out."""
        if self._newest and self.last_joint is not None:
            fill_effort(self._command, self._newest[0], self.last_joint, 0.0)
            self._commands.publish(self._command)

    def health(self):
        values = {'commands': self.commanded, 'stale setpoints': self.stale}
        if self._newest is None:
            return STALE, 'no joint_states yet', values
        return OK, 'running', values
