"""What a page shows beside the client's own messages: the newest of each, read when it is drawn."""

import time
from collections import deque
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from rcl_interfaces.msg import Log
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message

from wholearm_ros.control.setpoints import Joints
from wholearm_ros.errors import WholeArmError
from wholearm_ros.launcher.client import Client
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.joint_state_serialization import read_joints
from wholearm_ros.ros.interface.messages import to_joints, to_planar, values_of

STALE = 0.3  # [s] after which an estimate is not shown as one of now
LOG_LINES = 200
LEVELS = {10: 'debug', 20: 'info', 30: 'warning', 40: 'error', 50: 'fatal'}
NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
ROSOUT = QoSProfile(depth=100)


@dataclass
class Signals:
    """joints, estimate: serialized, with the machine's time [s] at which they came; health: node →
    its last report; log: new lines, oldest first.
    """

    joints: bytes | None = None
    joints_at: float = 0.0
    estimate: bytes | None = None
    estimate_at: float = 0.0
    health: dict[str, dict[str, Any]] = field(default_factory=dict)
    log: deque[dict[str, Any]] = field(default_factory=lambda: deque(maxlen=LOG_LINES))

    def listen(self, client: Client) -> None:
        """To the graph of `client`; raw where messages are many and few of them are read."""
        for topic, hear in (
            (channels.JOINT_STATES, self._on_joints),
            (channels.OBJECT_ESTIMATE, self._on_estimate),
        ):
            client.node.create_subscription(topic.type, topic.name, hear, NEWEST, raw=True)
        diagnostics = channels.DIAGNOSTICS
        client.node.create_subscription(
            diagnostics.type, diagnostics.name, self._on_diagnostics, diagnostics.qos
        )
        client.node.create_subscription(Log, '/rosout', self._on_log, ROSOUT)

    def joints_now(self) -> tuple[int, Joints] | None:
        """Stamp [ns] and both joints; None before the first message, or of one that is damaged."""
        if self.joints is None:
            return None
        try:
            return to_joints(read_joints(self.joints))
        except WholeArmError:
            return None

    def estimate_now(self) -> tuple[np.ndarray, np.ndarray] | None:
        """(3,) pose [m, m, rad] and its standard deviations; None when the fingers do not tell."""
        if self.estimate is None or time.monotonic() - self.estimate_at > STALE:
            return None
        message = deserialize_message(self.estimate, channels.OBJECT_ESTIMATE.type)
        stamped = PoseStamped(header=message.header, pose=message.pose.pose)
        try:
            pose = to_planar(stamped, channels.OBJECT_ESTIMATE.name)
        except WholeArmError:
            return None
        variances = np.asarray(message.pose.covariance)[[0, 7, 35]]
        return pose, np.sqrt(np.maximum(variances, 0.0))

    def _on_joints(self, data: bytes) -> None:
        self.joints, self.joints_at = data, time.monotonic()

    def _on_estimate(self, data: bytes) -> None:
        self.estimate, self.estimate_at = data, time.monotonic()

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            name = status.name.rpartition('/')[2]
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
