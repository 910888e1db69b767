"""A setpoint meets the joint state it was made for: what both controller nodes share."""

from collections import OrderedDict
from collections.abc import Callable, Iterable
from typing import Any, Optional

from wholearm_ros.control.setpoints import Joints
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.joint_state_serialization import NANOSECONDS, JointReading
from wholearm_ros.ros.interface.messages import effort_bytes, to_joints
from wholearm_ros.ros.interface.parameters import Declared
from wholearm_ros.ros.node.node import OK, STALE, Health, WholeArmNode

SETPOINT_TIMEOUT = Declared(
    'setpoint_timeout',
    0.05,
    'older than the newest joint state by more, a setpoint is not acted on [s]',
    0.001,
    10.0,
)
KEPT = 16  # joint states, and setpoints that wait for theirs


class ControllerNode(WholeArmNode):
    """setpoint + joint state of the same stamp → one joint command with that stamp.

    A setpoint waits for its joint state; when only newer ones are left, it meets the oldest of
    them. Nothing is remembered from one command to the next (but `last_efforts`, for drives that
    report none), so the same messages give the same commands. Without setpoints there are no
    commands, and the drives' watchdog holds the fingers.
    """

    def __init__(
        self,
        name: str,
        declared: Iterable[Declared],
        topic: channels.Topic,
        read: Callable[[JointReading], Any],
    ) -> None:
        super().__init__(name, (*declared, SETPOINT_TIMEOUT))
        self._read = read  # message → setpoint
        self._waiting: dict[int, Any] = {}  # stamp → setpoint without a joint state yet
        self._states: OrderedDict[int, Joints] = OrderedDict()  # stamp → the last few joint states
        self._newest = -1
        self.states = self.commanded = self.stale = 0
        self.answered = -1  # stamp of the last command
        self.last_joint: Optional[int] = None  # joint of the last command
        self.last_efforts = [0.0, 0.0]  # [N m] of the last commands
        self._commands = self.publisher(channels.JOINT_COMMANDS)
        self.subscription(topic, self._on_setpoint)
        self.subscription(channels.JOINT_STATES, self._on_joints)

    def effort(self, setpoint: Any, joints: Joints) -> float:
        """[N m] of the joint `setpoint.joint`."""
        raise NotImplementedError

    def _on_setpoint(self, message: JointReading) -> None:
        self._waiting[message.stamp] = self._read(message)
        self._act()

    def _on_joints(self, message: JointReading) -> None:
        stamp, joints = to_joints(message)
        if stamp < self._newest:  # another run: nothing of the old one counts
            self._waiting.clear()
            self._states.clear()
            self.last_efforts = [0.0, 0.0]
        self.states += stamp != self._newest
        self._newest = stamp
        self._states[stamp] = joints
        if len(self._states) > KEPT:
            self._states.popitem(last=False)
        self._act()

    def _act(self) -> None:
        for stamp in sorted(s for s in self._waiting if s <= self._newest):
            setpoint = self._waiting.pop(stamp)
            if self._newest - stamp > self.parameters.setpoint_timeout * NANOSECONDS:
                self.stale += 1
                continue
            joints = self._states.get(stamp) or next(
                j for s, j in self._states.items() if s > stamp
            )
            effort = self.effort(setpoint, joints)
            self._commands.publish(effort_bytes(stamp, setpoint.joint, effort))
            self.commanded += 1
            self.answered, self.last_joint = stamp, setpoint.joint
            self.last_efforts[setpoint.joint] = effort
        while len(self._waiting) > KEPT:
            del self._waiting[max(self._waiting)]  # the one farthest ahead of time

    def leave(self) -> None:
        """Zero torque on the way out."""
        if self.last_joint is not None:
            self._commands.publish(effort_bytes(self._newest, self.last_joint, 0.0))

    def health(self) -> Health:
        """Figures of the loop; stale before the first joint state."""
        values = {
            'states': self.states,
            'stamp': self._newest,
            'commands': self.commanded,
            'newest command': self.answered,
            'stale setpoints': self.stale,
        }
        if self._newest < 0:
            return STALE, 'no joint_states yet', values
        return OK, 'running', values
