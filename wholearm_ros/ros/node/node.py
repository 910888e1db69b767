"""What every node of the graph shares: channels, refusals that do not kill, diagnostics, and a way to leave."""

from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from sensor_msgs.msg import JointState

from wholearm_ros.errors import WholeArmError
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.joint_state_serialization import read_joints
from wholearm_ros.ros.interface.messages import status_message
from wholearm_ros.ros.interface.parameters import Declared, Parameters, survives_unknown_types
from wholearm_ros.ros.node.measured_publisher import LongestPublish, MeasuredPublisher

LEAVE_WITHIN = (
    0.8  # [s] after SIGINT or SIGTERM; then the process ends whatever a callback is doing
)
OK, WARN, ERROR, STALE = (
    DiagnosticStatus.OK,
    DiagnosticStatus.WARN,
    DiagnosticStatus.ERROR,
    DiagnosticStatus.STALE,
)
Health = tuple[bytes, str, dict[str, Any]]  # level, message and values for /diagnostics
DIAGNOSTICS_RATE = Declared(
    'diagnostics_rate', 2.0, 'how often this node reports on /diagnostics [Hz]', 0.1, 50.0
)
PRIORITY = Declared(
    'priority', 0, 'real-time priority (SCHED_FIFO) of all threads of the node; 0: none', 0, 90
)


class WholeArmNode(Node):
    """A node in the namespace /wholearm that survives every message."""

    leave_within = LEAVE_WITHIN

    def __init__(self, name: str, declared):
        super().__init__(name, namespace=channels.NAMESPACE)
        self.refused, self.longest_publish = 0, LongestPublish()  # messages, publish
        self.parameters = Parameters(
            self, (DIAGNOSTICS_RATE, PRIORITY, *declared), self.parameters_changed
        )
        self._diagnostics = self.publisher(channels.DIAGNOSTICS)
        self.every(1.0 / self.parameters.diagnostics_rate, self.report)

    def publisher(self, topic: channels.Topic):
        publisher = self.create_publisher(topic.type, topic.name, topic.qos)
        return MeasuredPublisher(publisher, topic, self.longest_publish)

    def subscription(self, topic: channels.Topic, callback):
        """`callback(message)`; a WholeArmError in it refuses the message: logged, counted, and that is all.

        A JointState comes as a JointReading, read from the wire, and is not acknowledged: sent again, it would be old.
        """
        raw = topic.type is JointState

        def guarded(message):
            try:
                callback(read_joints(message) if raw else message)
            except WholeArmError as error:
                self.refuse(f'{topic.name}: refused: {error}')

        qos = channels.NO_RESENDING if raw else topic.qos
        return self.create_subscription(topic.type, topic.name, guarded, qos, raw=raw)

    def service(self, service: channels.Service, callback):
        return self.create_service(service.type, service.name, callback)

    def create_service(self, srv_type, srv_name, callback, **more):
        """Those for parameters too, which rclpy makes."""
        return super().create_service(
            srv_type, srv_name, survives_unknown_types(srv_type, callback), **more
        )

    def every(self, seconds: float, callback):
        """A timer on the machine's own clock: simulated time may stand still."""
        return self.create_timer(seconds, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def refuse(self, reason: str):
        self.refused += 1
        self.get_logger().warning(reason, throttle_duration_sec=1.0)

    def report(self):
        """One DiagnosticStatus on /diagnostics."""
        level, message, values = self.health()
        values.update({'refused messages': self.refused, **self.longest_publish.figures()})
        array = DiagnosticArray(
            status=[status_message(self.get_fully_qualified_name(), level, message, values)]
        )
        array.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(array)

    def health(self):
        """(level, message, values) for /diagnostics."""
        return OK, 'running', {}

    def parameters_changed(self):
        """After a set of parameters was accepted."""

    def finished(self) -> bool:
        """Whether the node has done what it was started for."""
        return False

    def leave(self):
        """On the way out, while the middleware still works: make the hand safe, close files."""
