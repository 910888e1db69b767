"""What a page shows beside the client's own messages: the newest of each, read when it is drawn."""

import time
from collections import deque
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from rcl_interfaces.msg import Log
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from wholearm_ros.control.setpoints import Joints
from wholearm_ros.errors import WholeArmError
from wholearm_ros.launcher.client import Client
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.joint_state_serialization import read_joints
from wholearm_ros.ros.interface.messages import to_joints, to_planar, values_of

STALE = 0.3  # [s] after which a pose is not shown as one of now
LOG_LINES = 200
LEVELS = {10: 'debug', 20: 'info', 30: 'warning', 40: 'error', 50: 'fatal'}
NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
ROSOUT = QoSProfile(depth=100)


class Signals:
    """Of the graph of `client`: what is many is taken from its queue of one when it is drawn, by a
    node that is never spun; what is rare is heard.

    joints_at: the machine's time [s] of the newest joints that were taken; health: node → its last
    report; log: new lines, oldest first.
    """

    def __init__(self, client: Client) -> None:
        self.joints_at: float | None = None
        self.health: dict[str, dict[str, Any]] = {}
        self.log: deque[dict[str, Any]] = deque(maxlen=LOG_LINES)
        self._node = Node(
            'wholearm_console_view',
            namespace=client.node.get_namespace(),
            context=client.context,
            start_parameter_services=False,
        )
        self._palm = channels.frame_in(self._node.get_namespace(), channels.PALM_FRAME)
        self._joints, self._estimate, self._truth = (
            self._node.create_subscription(topic.type, topic.name, _never, NEWEST)
            for topic in (channels.JOINT_STATES, channels.OBJECT_ESTIMATE, channels.OBJECT_POSE)
        )
        self._estimated: tuple[float, np.ndarray, np.ndarray] | None = None
        self._true: tuple[float, np.ndarray] | None = None
        diagnostics = channels.DIAGNOSTICS
        client.node.create_subscription(
            diagnostics.type, diagnostics.name, self._on_diagnostics, diagnostics.qos
        )
        client.node.create_subscription(Log, '/rosout', self._on_log, ROSOUT)

    def close(self) -> None:
        """Before the client is closed."""
        self._node.destroy_node()

    def joints(self) -> tuple[int, Joints] | None:
        """Stamp [ns] and both joints, None when there are no new ones, or damaged ones."""
        data = _taken(self._joints, raw=True)
        if data is None:
            return None
        self.joints_at = time.monotonic()
        try:
            return to_joints(read_joints(data))
        except WholeArmError:
            return None

    def estimate(self) -> tuple[np.ndarray, np.ndarray] | None:
        """(3,) pose [m, m, rad] and its standard deviations; None when the fingers do not tell."""
        message, now = _taken(self._estimate), time.monotonic()
        if message is not None:
            pose = self._planar(PoseStamped(header=message.header, pose=message.pose.pose))
            variances = np.asarray(message.pose.covariance)[[0, 7, 35]]
            deviations = np.sqrt(np.maximum(variances, 0.0))
            self._estimated = None if pose is None else (now, pose, deviations)
        if self._estimated is None or now - self._estimated[0] > STALE:
            return None
        return self._estimated[1:]

    def truth(self) -> np.ndarray | None:
        """(3,) the object's true pose [m, m, rad], where a simulated hand tells."""
        message, now = _taken(self._truth), time.monotonic()
        if message is not None:
            pose = self._planar(message)
            self._true = None if pose is None else (now, pose)
        return None if self._true is None or now - self._true[0] > STALE else self._true[1]

    def _planar(self, message: PoseStamped) -> np.ndarray | None:
        """None of a pose that cannot be used."""
        try:
            return to_planar(message, 'pose', self._palm)
        except WholeArmError:
            return None

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            space, _, name = status.name.rpartition('/')
            if space != self._node.get_namespace():
                continue  # another hand's, in the same domain
            self.health[name] = {
                'level': int.from_bytes(status.level, 'little'),
                'message': status.message,
                'values': values_of(status),
                'at': time.monotonic(),
            }

    def _on_log(self, message: Log) -> None:
        self.log.append(
            {
                'time': message.stamp.sec + message.stamp.nanosec * 1e-9,
                'level': LEVELS.get(message.level, 'info'),
                'node': message.name.rpartition('.')[2],
                'text': message.msg[:2000],
            }
        )


def _taken(subscription: Any, raw: bool = False) -> Any:
    """The newest message of a queue of one, None when none has come since the last time."""
    taken = subscription.handle.take_message(subscription.msg_type, raw)
    return None if taken is None else taken[0]


def _never(_: Any) -> None:
    """Messages of a node that is not spun."""
