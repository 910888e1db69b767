"""A client of the graph: sends goals, follows them, and listens to the object's true pose."""

import time
import uuid
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
import rclpy
from action_msgs.msg import GoalInfo
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.srv import SetParameters
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

from wholearm_ros.errors import WholeArmError
from wholearm_ros.model.outcomes import REJECTED
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.joint_state_serialization import NANOSECONDS
from wholearm_ros.ros.interface.messages import (
    FEEL_GOAL,
    NO_GOAL,
    goal_message,
    parameter_request,
    to_goal_id,
    to_nanoseconds,
    to_planar,
    values_of,
)
from wholearm_ros.ros.interface.transport import choose_transport

BETWEEN_TRIES = 0.5  # [s] of an activation
LEASE = 21.0  # [s] and a little less: for as long a killed node is still listed
AFTER_THE_END = 2.0  # [s] in which a pose after the end of a run is waited for
SUPERVISOR_PARAMETERS = channels.Service('reorientation/set_parameters', SetParameters)
Values = dict[str, str]  # of a DiagnosticStatus


class GraphError(WholeArmError):
    """The graph did not answer."""


@dataclass
class LatestMessages:
    """The newest of each kind of message; empty, or None, before the first one.

    progress: of the mode switcher; feedback, result: of the generator; reorientation, reached:
    feedback and result of the supervisor; goal_listeners: to whom its goals for the generator go;
    told_by: node → the message of its diagnostics; poses: stamp [ns] → (3,) [m, m, rad], all of
    them.
    """

    plan: ContactPlan | None = None
    planner: Values = field(default_factory=dict)
    trajectory: ManipulationTrajectory | None = None
    mode: str = ''
    progress: Values = field(default_factory=dict)
    feedback: Values = field(default_factory=dict)
    result: Values = field(default_factory=dict)
    reorientation: Values = field(default_factory=dict)
    reached: Values = field(default_factory=dict)
    reached_message: str = ''
    goal_listeners: int = 0
    told_by: Values = field(default_factory=dict)
    poses: dict[int, np.ndarray] = field(default_factory=dict)


class Client:
    """Spins only while it waits; `watch` is called meanwhile and may raise."""

    def __init__(
        self,
        watch: Callable[[], None] = lambda: None,
        name: str = 'wholearm_client',
        namespace: str = channels.NAMESPACE,
    ) -> None:
        self.latest, self.watch, self._request_stamp = LatestMessages(), watch, ''
        self._reorient_id = ''
        self._services: dict[str, Any] = {}
        choose_transport()
        self.context = rclpy.Context()
        rclpy.init(
            context=self.context, signal_handler_options=rclpy.signals.SignalHandlerOptions.NO
        )
        self.node = Node(
            name, namespace=namespace, context=self.context, start_parameter_services=False
        )
        self.executor = EventsExecutor(context=self.context)
        self.executor.add_node(self.node)
        self._palm = channels.frame_in(self.node.get_namespace(), channels.PALM_FRAME)
        self._goal = self._publisher(channels.GOAL)
        self._cancel = self._publisher(channels.CANCEL)
        self._reorient = self._publisher(channels.REORIENTATION_GOAL)
        self._cancel_reorientation = self._publisher(channels.REORIENTATION_CANCEL)
        heard: tuple[tuple[channels.Topic, Callable[[Any], None]], ...] = (
            (channels.CONTACT_PLAN, self._on_plan),
            (channels.PLANNER_STATUS, self._on_planner),
            (channels.MANIPULATION_TRAJECTORY, self._on_trajectory),
            (channels.MODE, self._on_mode),
            (channels.PROGRESS, self._on_progress),
            (channels.FEEDBACK, self._on_feedback),
            (channels.RESULT, self._on_result),
            (channels.REORIENTATION_FEEDBACK, self._on_reorientation),
            (channels.REORIENTATION_RESULT, self._on_reached),
            (channels.DIAGNOSTICS, self._on_diagnostics),
        )
        for topic, hear in heard:
            self.node.create_subscription(topic.type, topic.name, _guarded(hear), topic.qos)
        deep = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
        self._truth = self.node.create_subscription(
            channels.OBJECT_POSE.type, channels.OBJECT_POSE.name, _guarded(self._on_pose), deep
        )

    def _publisher(self, topic: channels.Topic) -> Publisher:
        return self.node.create_publisher(topic.type, topic.name, topic.qos)

    def _now(self) -> Time:
        return self.node.get_clock().now().to_msg()

    def close(self) -> None:
        """With its participant, which would live on beside that of this process's next client."""
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self.context)
        self.context.destroy()

    def leave_truth_alone(self) -> None:
        """From now on no pose is kept: nobody will judge, and they are many."""
        self.node.destroy_subscription(self._truth)

    def wait(self, condition: Callable[[], object], seconds: float, what: str) -> None:
        """Spins until `condition()` is true; raises GraphError, naming `what`, after `seconds`."""
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline:
                raise GraphError(f'{what}: nothing for {seconds:.0f} s')
            self.executor.spin_once(timeout_sec=0.05)
            self.watch()

    def spin(self, seconds: float) -> None:
        """Waits at most `seconds` for something to come, then takes everything that has come.

        The executor takes one event at a time, in their order: who does a round of other work after
        each of them falls behind on a busy machine, and the answer to a stop with it.
        """
        self.executor.spin_once(timeout_sec=seconds)
        last = self.executor.create_task(lambda: None)
        while not last.done():
            self.executor.spin_once(timeout_sec=0.05)

    def wait_for_graph(self, seconds: float, recorded: bool = False) -> None:
        """Until every channel of the closed loop has both its ends; raises GraphError after
        `seconds` each.

        recorded: whether a recorder listens, too: it must not be taken for the node that is waited
        for.
        """
        services = {
            s.name: self.node.create_client(s.type, s.name)
            for s in (channels.PLAN_SCENARIO, channels.STOP, channels.RESET)
        }
        for name, client in services.items():
            self.wait(client.service_is_ready, seconds, f'service {name}')
        self.wait_for_publishers(
            seconds, ((channels.JOINT_COMMANDS, 2), (channels.JOINT_STATES, 1))
        )
        self.wait_for_subscribers(
            seconds,
            (
                (topic, number + recorded)
                for topic, number in (
                    (channels.JOINT_COMMANDS, 1),
                    (channels.JOINT_STATES, 3),
                    (channels.VELOCITY_SETPOINT, 1),
                    (channels.TORQUE_SETPOINT, 1),
                    (channels.MANIPULATION_TRAJECTORY, 2),
                    (channels.GOAL, 1),
                    (channels.GOAL_STATUS, 1),
                    (channels.CONTACT_PLAN, 2),
                )
            ),
        )

    def wait_until_alone(self, nodes: Iterable[str], seconds: float = LEASE) -> None:
        """Raises GraphError when one of `nodes` is there more than once for so long: another graph
        runs in this domain, however it was started. One that was killed is listed for a while.
        """
        own = self.node.get_namespace()

        def doubled() -> list[str]:
            there = [n for n, space in self.node.get_node_names_and_namespaces() if space == own]
            return [name for name in nodes if there.count(name) > 1]

        try:
            self.wait(lambda: not doubled(), seconds, 'another graph')
        except GraphError as error:
            raise GraphError(
                f'{", ".join(doubled())}: there already in this ROS domain; '
                'allowed: one graph, or another ROS_DOMAIN_ID'
            ) from error

    def wait_for_publishers(
        self, seconds: float, least: Iterable[tuple[channels.Topic, int]]
    ) -> None:
        """Until every topic has at least so many; raises GraphError after `seconds` each."""
        self._wait_for(self.node.count_publishers, seconds, least)

    def wait_for_subscribers(
        self, seconds: float, least: Iterable[tuple[channels.Topic, int]]
    ) -> None:
        """Until every topic has at least so many; raises GraphError after `seconds` each."""
        self._wait_for(self.node.count_subscribers, seconds, least)

    def _wait_for(
        self,
        count: Callable[[str], int],
        seconds: float,
        least: Iterable[tuple[channels.Topic, int]],
    ) -> None:
        for topic, number in least:
            self.wait(partial(_at_least, count, topic.name, number), seconds, f'topic {topic.name}')

    def activate(self, node: str, seconds: float) -> None:
        """Configures and activates a managed node, which may refuse for a while. Raises GraphError,
        with the node's reason, after `seconds`.
        """
        change = channels.Service(f'{node}/change_state', ChangeState)
        configure, activate = (
            ChangeState.Request(transition=Transition(id=number))
            for number in (Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE)
        )
        deadline = time.monotonic() + seconds
        self.call(change, seconds, configure)
        while not self.call(change, seconds, activate).success:
            if time.monotonic() > deadline:
                reason = self.latest.told_by.get(f'{self.node.get_namespace()}/{node}', '')
                raise GraphError(f'{node} is not active after {seconds:.0f} s: {reason}')
            self.wait_a_little()

    def wait_a_little(self) -> None:
        """Between two tries."""
        until = time.monotonic() + BETWEEN_TRIES
        self.wait(lambda: time.monotonic() > until, 2 * BETWEEN_TRIES + 1.0, 'time')

    def wait_for_supervisor(self, seconds: float, recorded: bool = False) -> None:
        """Until it has found who shall receive its goals, the recorder included: what is published
        before that is lost to them. Raises GraphError after `seconds`.
        """
        number = 1 + recorded
        self.wait_for_subscribers(seconds, ((channels.REORIENTATION_GOAL, number),))
        self.wait(
            lambda: self.latest.goal_listeners >= number, seconds, 'listeners of reorientation'
        )

    def call(self, service: channels.Service, seconds: float, request: Any = None) -> Any:
        """The response of `service` to `request`, an empty one by default; raises GraphError after
        `seconds`.
        """
        client = self.node.create_client(service.type, service.name)
        self.wait(client.service_is_ready, seconds, f'service {service.name}')
        future = client.call_async(request or service.type.Request())
        self.wait(future.done, seconds, f'service {service.name}')
        self.node.destroy_client(client)
        return future.result()

    def offered(self, service: channels.Service) -> bool:
        """Whether somebody answers `service` now."""
        return bool(self._kept(service).service_is_ready())

    def ask(self, service: channels.Service, request: Any = None) -> Any:
        """The future response of `service`, for those who cannot wait."""
        return self._kept(service).call_async(request or service.type.Request())

    def _kept(self, service: channels.Service) -> Any:
        if service.name not in self._services:
            self._services[service.name] = self.node.create_client(service.type, service.name)
        return self._services[service.name]

    def send_goal(self, plan_id: str) -> None:
        """Asks the generator to execute a plan; raises MessageError when it is not a UUID."""
        self._send(to_goal_id(plan_id))

    def feel(self) -> None:
        """Asks the generator what lies in the hand; its result says so."""
        self._send(FEEL_GOAL)

    def _send(self, goal: bytes) -> None:
        self.latest.result, stamp = {}, self._now()
        self._request_stamp = str(to_nanoseconds(stamp))
        self._goal.publish(goal_message(goal, stamp))

    def reorient(self) -> str:
        """Asks the supervisor for its scenario's goal, attempt after attempt; the goal's id."""
        goal, stamp = uuid.uuid4(), self._now()
        self.latest.reorientation, self.latest.reached = {}, {}
        self._reorient_id, self._request_stamp = str(goal), str(to_nanoseconds(stamp))
        self._reorient.publish(goal_message(goal.bytes, stamp))
        return self._reorient_id

    def tell_supervisor(self, scenario: str) -> Any:
        """The future answer of the supervisor to a scenario, a document or a path; its next goal
        is that scenario's.
        """
        return self.ask(SUPERVISOR_PARAMETERS, parameter_request('scenario', scenario))

    def cancel_reorientation(self) -> None:
        """Whatever the supervisor is doing."""
        self._cancel_reorientation.publish(self._whatever_runs())

    def cancel(self) -> None:
        """Whatever the generator is doing."""
        self._cancel.publish(self._whatever_runs())

    def _whatever_runs(self) -> GoalInfo:
        return goal_message(NO_GOAL, self._now())

    def final_poses(self, stamp: int, seconds: float) -> tuple[np.ndarray, np.ndarray]:
        """(m,) [s] and (m, 3) [m, m, rad]: the object's poses up to the first one after `stamp`
        [ns], or at it.

        The one after it is waited for a little: in lockstep, where time stands still after a run,
        it is always the same one, while one at `stamp` comes only if the hardware had to wait
        there. Raises GraphError when there is none for `seconds`.
        """
        poses, until = self.latest.poses, time.monotonic() + AFTER_THE_END
        self.wait(lambda: poses and max(poses) >= stamp, seconds, 'object_pose')
        while max(poses) <= stamp and time.monotonic() < until:
            self.executor.spin_once(timeout_sec=0.05)
        stamps = sorted(poses)
        last = next((s for s in stamps if s > stamp), stamps[-1])
        stamps = [s for s in stamps if s <= last]
        return np.array(stamps) / NANOSECONDS, np.array([poses[s] for s in stamps])

    def _on_plan(self, message: String) -> None:
        self.latest.plan = ContactPlan.from_json(message.data)

    def _on_planner(self, message: DiagnosticStatus) -> None:
        self.latest.planner = {'message': message.message, **values_of(message)}

    def _on_trajectory(self, message: String) -> None:
        self.latest.trajectory = ManipulationTrajectory.from_json(message.data)

    def _on_mode(self, message: String) -> None:
        self.latest.mode = message.data

    def _on_progress(self, message: DiagnosticStatus) -> None:
        self.latest.progress = values_of(message)

    def _on_feedback(self, message: DiagnosticStatus) -> None:
        self.latest.feedback = values_of(message)

    def _on_result(self, message: DiagnosticStatus) -> None:
        values = values_of(message)
        own = values.get('request_stamp') == self._request_stamp
        if own or values.get('outcome') != REJECTED:  # else another client's request
            self.latest.result = values

    def _on_reorientation(self, message: DiagnosticStatus) -> None:
        values = values_of(message)
        if values.get('goal_id') == self._reorient_id:
            self.latest.reorientation = values

    def _on_reached(self, message: DiagnosticStatus) -> None:
        values = values_of(message)
        if values.get('goal_id') == self._reorient_id:
            self.latest.reached, self.latest.reached_message = values, message.message

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name.rpartition('/')[0] != self.node.get_namespace():
                continue  # another hand's, in the same domain
            self.latest.told_by[status.name] = status.message
            listeners = values_of(status).get(channels.GOAL_LISTENERS, '')
            if listeners.isdecimal():
                self.latest.goal_listeners = int(listeners)

    def _on_pose(self, message: PoseStamped) -> None:
        planar = to_planar(message, 'object_pose', self._palm)
        self.latest.poses[to_nanoseconds(message.header.stamp)] = planar


def _at_least(count: Callable[[str], int], topic: str, number: int) -> bool:
    return count(topic) >= number


def _guarded(hear: Callable[[Any], None]) -> Callable[[Any], None]:
    """What others publish does not end a client; a damaged document is as good as none."""

    def callback(message: Any) -> None:
        try:
            hear(message)
        except WholeArmError:
            pass

    return callback
