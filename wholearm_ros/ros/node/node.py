"""What every node of the graph shares: channels, refusals that do not kill, diagnostics, and a way to leave."""

import gc
import os
import signal
import sys
import threading

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.clock import Clock, ClockType
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from sensor_msgs.msg import JointState

from wholearm_ros.errors import WholeArmError
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.joint_state_serialization import read_joints
from wholearm_ros.ros.interface.messages import status_message
from wholearm_ros.ros.interface.parameters import Declared, Parameters, survives_unknown_types

LEAVE_WITHIN = (
    0.8  # [s] after SIGINT or SIGTERM; then the process ends whatever a callback is doing
)
SIGNAL_PERIOD = 0.05  # [s] between two looks at whether a signal came
OK, WARN, ERROR, STALE = (
    DiagnosticStatus.OK,
    DiagnosticStatus.WARN,
    DiagnosticStatus.ERROR,
    DiagnosticStatus.STALE,
)
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
        self.refused = 0  # messages
        self.parameters = Parameters(
            self, (DIAGNOSTICS_RATE, PRIORITY, *declared), self.parameters_changed
        )
        self._diagnostics = self.publisher(channels.DIAGNOSTICS)
        self.every(1.0 / self.parameters.diagnostics_rate, self.report)

    def publisher(self, topic: channels.Topic):
        return self.create_publisher(topic.type, topic.name, topic.qos)

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
        values['refused messages'] = self.refused
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


def run_node(make_node, args=None, make_executor=EventsExecutor) -> int:
    """Spin the node until SIGINT or SIGTERM; the exit code: 0, or 2 when it cannot start as told.

    The handlers of rclpy would shut the middleware down at once; ours only set a flag, so that `leave` can still
    publish. A thread sees to it that the process ends even when a callback does not return.
    """
    signalled, finished = _watch_signals(), threading.Event()
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = make_node()
    except WholeArmError as error:
        print(f'error: {error}', file=sys.stderr, flush=True)
        rclpy.try_shutdown()
        return 2
    threading.Thread(
        target=_end_in_time, args=(signalled, finished, node.leave_within), daemon=True
    ).start()
    executor = make_executor()
    executor.add_node(node)
    _raise_priority(node)
    gc.collect()
    gc.freeze()  # what is there stays: no collection of it holds up the loop
    never = Future(executor=executor)
    while (
        not signalled.is_set() and not node.finished()
    ):  # spin() would not look up, spin_once() returns every message
        executor.spin_until_future_complete(never, timeout_sec=SIGNAL_PERIOD)
    node.leave()
    rclpy.try_shutdown()
    finished.set()
    return 0


def _raise_priority(node):
    """Where the machine allows it; else the node runs as it is and says so."""
    if node.parameters.priority:
        try:
            for thread in os.listdir('/proc/self/task'):
                os.sched_setscheduler(
                    int(thread), os.SCHED_FIFO, os.sched_param(node.parameters.priority)
                )
        except OSError as error:
            node.get_logger().info(
                f'priority: not allowed here ({error.strerror}); running without'
            )


def _watch_signals() -> threading.Event:
    """Set on SIGINT or SIGTERM."""
    signalled = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: signalled.set())
    return signalled


def _end_in_time(signalled, finished, leave_within):
    signalled.wait()
    if not finished.wait(leave_within):
        os._exit(0)
