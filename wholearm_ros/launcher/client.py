"""A client of the graph: plans, sends the goal, follows it, and judges the object's final pose by the truth."""

import time
import uuid
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from wholearm_ros.errors import WholeArmError
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.messages import (
    FEEL_GOAL,
    NANOSECONDS,
    NO_GOAL,
    goal_message,
    to_goal_id,
    to_nanoseconds,
    to_planar,
    values_of,
)
from wholearm_ros.ros.interface.transport import choose_transport

AFTER_THE_END = 2.0  # [s] in which a pose after the end of a run is waited for


class GraphError(WholeArmError):
    """The graph did not answer."""


@dataclass
class LatestMessages:
    """The newest of each kind of message."""

    plan: ContactPlan = None
    planner: dict = field(default_factory=dict)
    trajectory: ManipulationTrajectory = None
    mode: str = ''
    progress: dict = field(default_factory=dict)  # of the mode switcher
    feedback: dict = field(default_factory=dict)
    result: dict = field(default_factory=dict)
    result_message: str = ''
    reorientation: dict = field(default_factory=dict)  # feedback of the supervisor
    reached: dict = field(default_factory=dict)  # its result
    reached_message: str = ''
    poses: dict = field(default_factory=dict)  # stamp [ns] → (3,)


class Client:
    """Spins only while it waits; `watch` is called meanwhile and may raise."""

    def __init__(
        self, watch=lambda: None, name: str = 'wholearm_client', namespace: str = channels.NAMESPACE
    ):
        self.latest, self.watch, self._request_stamp = LatestMessages(), watch, ''
        self._reorient_id = ''
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
        self._goal = self.node.create_publisher(
            channels.GOAL.type, channels.GOAL.name, channels.GOAL.qos
        )
        self._cancel = self.node.create_publisher(
            channels.CANCEL.type, channels.CANCEL.name, channels.CANCEL.qos
        )
        self._reorient = self.node.create_publisher(
            channels.REORIENTATION_GOAL.type,
            channels.REORIENTATION_GOAL.name,
            channels.REORIENTATION_GOAL.qos,
        )
        self._cancel_reorientation = self.node.create_publisher(
            channels.REORIENTATION_CANCEL.type,
            channels.REORIENTATION_CANCEL.name,
            channels.REORIENTATION_CANCEL.qos,
        )
        for topic, hear in (
            (channels.CONTACT_PLAN, self._on_plan),
            (channels.PLANNER_STATUS, self._on_planner),
            (channels.MANIPULATION_TRAJECTORY, self._on_trajectory),
            (channels.MODE, self._on_mode),
            (channels.PROGRESS, self._on_progress),
            (channels.FEEDBACK, self._on_feedback),
            (channels.RESULT, self._on_result),
            (channels.REORIENTATION_FEEDBACK, self._on_reorientation),
            (channels.REORIENTATION_RESULT, self._on_reached),
        ):
            self.node.create_subscription(topic.type, topic.name, _guarded(hear), topic.qos)
        deep = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
        self.node.create_subscription(
            channels.OBJECT_POSE.type, channels.OBJECT_POSE.name, _guarded(self._on_pose), deep
        )

    def close(self):
        """With its participant, which would live on beside that of this process's next client."""
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self.context)
        self.context.destroy()

    def wait(self, condition, seconds: float, what: str):
        """Spins until `condition()`; raises GraphError after `seconds`."""
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline:
                raise GraphError(f'{what}: nothing for {seconds:.0f} s')
            self.executor.spin_once(timeout_sec=0.05)
            self.watch()

    def wait_for_graph(self, seconds: float):
        """Until every channel of the closed loop has both its ends."""
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
                (channels.JOINT_COMMANDS, 1),
                (channels.JOINT_STATES, 3),
                (channels.VELOCITY_SETPOINT, 1),
                (channels.TORQUE_SETPOINT, 1),
                (channels.MANIPULATION_TRAJECTORY, 2),
                (channels.GOAL, 1),
                (channels.GOAL_STATUS, 1),
                (channels.CONTACT_PLAN, 2),
            ),
        )

    def wait_for_publishers(self, seconds: float, least: Iterable[tuple[channels.Topic, int]]):
        """Until every topic has at least so many; raises GraphError after `seconds` each."""
        self._wait_for(self.node.count_publishers, seconds, least)

    def wait_for_subscribers(self, seconds: float, least: Iterable[tuple[channels.Topic, int]]):
        """Until every topic has at least so many; raises GraphError after `seconds` each."""
        self._wait_for(self.node.count_subscribers, seconds, least)

    def _wait_for(self, count, seconds, least):
        for topic, number in least:
            self.wait(lambda: count(topic.name) >= number, seconds, f'topic {topic.name}')

    def call(self, service: channels.Service, seconds: float, request=None):
        """The response of `service`."""
        client = self.node.create_client(service.type, service.name)
        self.wait(client.service_is_ready, seconds, f'service {service.name}')
        future = client.call_async(request or service.type.Request())
        self.wait(future.done, seconds, f'service {service.name}')
        self.node.destroy_client(client)
        return future.result()

    def send_goal(self, plan_id: str):
        self.latest.result, stamp = {}, self.node.get_clock().now().to_msg()
        self._request_stamp = str(to_nanoseconds(stamp))
        self._goal.publish(goal_message(to_goal_id(plan_id), stamp))

    def feel(self) -> None:
        """Asks the generator what lies in the hand; its result says so."""
        self.latest.result, stamp = {}, self.node.get_clock().now().to_msg()
        self._request_stamp = str(to_nanoseconds(stamp))
        self._goal.publish(goal_message(FEEL_GOAL, stamp))

    def reorient(self) -> str:
        """Asks the supervisor for the goal of its scenario, attempt after attempt; the goal's id."""
        goal, stamp = uuid.uuid4(), self.node.get_clock().now().to_msg()
        self.latest.reorientation, self.latest.reached = {}, {}
        self._reorient_id, self._request_stamp = str(goal), str(to_nanoseconds(stamp))
        self._reorient.publish(goal_message(goal.bytes, stamp))
        return self._reorient_id

    def cancel_reorientation(self):
        """Whatever the supervisor is doing."""
        self._cancel_reorientation.publish(
            goal_message(NO_GOAL, self.node.get_clock().now().to_msg())
        )

    def cancel(self):
        self._cancel.publish(goal_message(NO_GOAL, self.node.get_clock().now().to_msg()))

    def final_poses(self, stamp: int, seconds: float):
        """(m,) [s] and (m, 3): the object's poses up to the first one after `stamp` [ns], or at it.

        The one after it is waited for a little: in lockstep, where time stands still after a run, it
        is always the same one, while one at `stamp` comes only if the hardware had to wait there.
        """
        poses, until = self.latest.poses, time.monotonic() + AFTER_THE_END
        self.wait(lambda: poses and max(poses) >= stamp, seconds, 'object_pose')
        while max(poses) <= stamp and time.monotonic() < until:
            self.executor.spin_once(timeout_sec=0.05)
        stamps = sorted(poses)
        last = next((s for s in stamps if s > stamp), stamps[-1])
        stamps = [s for s in stamps if s <= last]
        return np.array(stamps) / NANOSECONDS, np.array([poses[s] for s in stamps])

    def _on_plan(self, message):
        self.latest.plan = ContactPlan.from_json(message.data)

    def _on_planner(self, message):
        self.latest.planner = {'message': message.message, **values_of(message)}

    def _on_trajectory(self, message):
        self.latest.trajectory = ManipulationTrajectory.from_json(message.data)

    def _on_mode(self, message):
        self.latest.mode = message.data

    def _on_progress(self, message):
        self.latest.progress = values_of(message)

    def _on_feedback(self, message):
        self.latest.feedback = values_of(message)

    def _on_result(self, message):
        values = values_of(message)
        if (
            values.get('request_stamp', self._request_stamp) == self._request_stamp
        ):  # not another client's rejection
            self.latest.result, self.latest.result_message = values, message.message

    def _on_reorientation(self, message):
        values = values_of(message)
        if values.get('goal_id') == self._reorient_id:
            self.latest.reorientation = values

    def _on_reached(self, message):
        values = values_of(message)
        if values.get('goal_id') == self._reorient_id:
            self.latest.reached, self.latest.reached_message = values, message.message

    def _on_pose(self, message):
        self.latest.poses[to_nanoseconds(message.header.stamp)] = to_planar(message, 'object_pose')


def _guarded(hear):
    """What others publish does not end a client; a damaged document is as good as none."""

    def callback(message):
        try:
            hear(message)
        except WholeArmError:
            pass

    return callback
