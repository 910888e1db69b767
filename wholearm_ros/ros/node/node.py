"""What every node of the graph shares: channels, refusals that do not kill, diagnostics."""

from collections.abc import Callable, Iterable
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState

from wholearm_ros.errors import WholeArmError
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.joint_state_serialization import read_joints
from wholearm_ros.ros.interface.messages import status_message
from wholearm_ros.ros.interface.parameters import Declared, Parameters, survives_unknown_types
from wholearm_ros.ros.node.measured_publisher import LongestPublish, MeasuredPublisher
from wholearm_ros.ros.node.steady_subscription import LOOK_PERIOD, SteadySubscription

# [s] after SIGINT or SIGTERM; then the process ends whatever a callback is doing.
LEAVE_WITHIN = 0.8
OK, WARN, ERROR, STALE = (
    DiagnosticStatus.OK,
    DiagnosticStatus.WARN,
    DiagnosticStatus.ERROR,
    DiagnosticStatus.STALE,
)
DOUBLE = 'another node of this name is there, or was killed within the last 20 s'
DOUBLE_PERIOD = 1.0  # [s] between two looks for one
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

    def __init__(self, name: str, declared: Iterable[Declared]) -> None:
        super().__init__(name, namespace=channels.NAMESPACE)
        self.refused, self.longest_publish = 0, LongestPublish()  # messages, publish
        self.parameters = Parameters(
            self, (DIAGNOSTICS_RATE, PRIORITY, *declared), self.parameters_changed
        )
        self._diagnostics = self.publisher(channels.DIAGNOSTICS)
        self._steady: list[SteadySubscription] = []
        self.double = False  # whether another node has this one's name
        self.every(1.0 / self.parameters.diagnostics_rate, self.report)
        self.every(DOUBLE_PERIOD, self.look_for_a_double)
        self.every(LOOK_PERIOD, self.look_for_silence)

    def publisher(self, topic: channels.Topic) -> MeasuredPublisher:
        """On `topic`, measured."""
        publisher = self.create_publisher(topic.type, topic.name, topic.qos)
        return MeasuredPublisher(publisher, topic, self.longest_publish)

    def subscription(self, topic: channels.Topic, callback: Callable[[Any], None]) -> None:
        """`callback(message)`; a WholeArmError in it refuses the message: logged and counted.

        A JointState comes as a JointReading, read from the wire, and is received best effort: sent
        again, it would be old.
        """
        raw = topic.type is JointState

        def guarded(message: Any) -> None:
            try:
                callback(read_joints(message) if raw else message)
            except WholeArmError as error:
                self.refuse(f'{topic.name}: refused: {error}')

        qos = channels.NO_RESENDING if raw else topic.qos
        self.listen(topic, guarded, qos, raw)

    def listen(
        self, topic: channels.Topic, callback: Callable[[Any], None], qos: QoSProfile, raw: bool
    ) -> None:
        """As `create_subscription`; where the topic is steady, deafness is told and mended."""

        def subscribe(hear: Callable[[Any], None]) -> Subscription:
            return self.create_subscription(topic.type, topic.name, hear, qos, raw=raw)

        if not topic.steady:
            subscribe(callback)
            return
        self._steady.append(
            SteadySubscription(topic.name, callback, subscribe, self.destroy_subscription)
        )

    def frame(self, name: str) -> str:
        """The name on /tf of one of the frames of this node's hand."""
        return channels.frame_in(self.get_namespace(), name)

    def service(self, service: channels.Service, callback: Callable[[Any, Any], Any]) -> None:
        """`callback(request, response)` answers `service`."""
        self.create_service(service.type, service.name, callback)

    def create_service(
        self, srv_type: Any, srv_name: str, callback: Callable[[Any, Any], Any], **more: Any
    ) -> Any:
        """Those for parameters too, which rclpy makes."""
        return super().create_service(
            srv_type, srv_name, survives_unknown_types(srv_type, callback), **more
        )

    def every(self, seconds: float, callback: Callable[[], None]) -> None:
        """A timer on the machine's own clock: simulated time may stand still."""
        self.create_timer(seconds, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def get_logger(self) -> Any:
        """The node's own, which rclpy leaves without types."""
        return super().get_logger()  # type: ignore[no-untyped-call]

    def refuse(self, reason: str) -> None:
        """Logged, at most once a second, and counted."""
        self.refused += 1
        self.get_logger().warning(reason, throttle_duration_sec=1.0)

    def look_for_a_double(self) -> None:
        """Both would answer every message. A node that was killed counts until its lease ends."""
        own = (self.get_name(), self.get_namespace())
        double = self.get_node_names_and_namespaces().count(own) > 1
        if double and not self.double:
            self.get_logger().error(f'{DOUBLE}: {self.get_fully_qualified_name()}')
        self.double = double

    def look_for_silence(self) -> None:
        """Of the topics that never pause."""
        for subscription in self._steady:
            if told := subscription.look():
                self.get_logger().warning(told)

    def report(self) -> None:
        """One DiagnosticStatus on /diagnostics."""
        level, message, values = self.health()
        problems = [DOUBLE] if self.double else []
        problems += [s.problem for s in self._steady if s.problem]
        if problems and level != ERROR:
            level, message = WARN, '; '.join(problems)
        values.update({'refused messages': self.refused, **self.longest_publish.figures()})
        if self._steady:
            values['renewed subscriptions'] = sum(s.renewals for s in self._steady)
        array = DiagnosticArray(
            status=[status_message(self.get_fully_qualified_name(), level, message, values)]
        )
        array.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(array)

    def health(self) -> Health:
        """(level, message, values) for /diagnostics."""
        return OK, 'running', {}

    def parameters_changed(self) -> None:
        """After a set of parameters was accepted."""

    def finished(self) -> bool:
        """Whether the node has done what it was started for."""
        return False

    def leave(self) -> None:
        """On the way out, while the middleware still works: make the hand safe, close files."""
