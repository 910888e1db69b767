"""Leads both fingers along the trajectory of the goal that executes: two setpoints for every joint
state.
"""

import json
import time
from dataclasses import replace
from typing import Any

from action_msgs.msg import GoalStatus, GoalStatusArray
from std_msgs.msg import String
from std_srvs.srv import Trigger

from wholearm_ros.control.execution import Execution
from wholearm_ros.control.setpoints import Joints
from wholearm_ros.model.choices import Pacing
from wholearm_ros.model.modes import DONE, IDLE, STOPPED
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.common_parameters import (
    HANDOVER,
    MAX_TRACKING_ERROR,
    PACING,
    RAMP,
    STOP_OUTSIDE,
    switch_options_of,
)
from wholearm_ros.ros.interface.joint_state_serialization import JointReading
from wholearm_ros.ros.interface.messages import (
    effort_bytes,
    goal_id_of,
    goal_name,
    status_message,
    to_joints,
    to_nanoseconds,
    velocity_setpoint_bytes,
)
from wholearm_ros.ros.interface.parameters import Declared
from wholearm_ros.ros.node.execution import StampedExecution, jumped
from wholearm_ros.ros.node.node import DIAGNOSTICS_RATE, ERROR, OK, Health, WholeArmNode
from wholearm_ros.ros.node.run import run_node
from wholearm_ros.ros.node.stamp_age import StampAge

DECLARED = (
    PACING,
    RAMP,
    HANDOVER,
    MAX_TRACKING_ERROR,
    STOP_OUTSIDE,
    replace(DIAGNOSTICS_RATE, default=10.0),
    Declared('settle', 0.5, 'how long the end is held before the mode says done [s]', 0.0, 60.0),
    Declared(
        'start_tolerance', 0.08, 'of both angles from the start of a trajectory [rad]', 1e-4, 1.0
    ),
    Declared(
        'joint_states_timeout',
        0.1,
        'without joint states beyond which a run stops; in lockstep at least 10 [s]',
        0.002,
        600.0,
    ),
    Declared('probe', True, 'whether the end of a trajectory is felt, where it comes with a probe'),
)
WATCH_PERIOD = 0.01  # [s]
PROGRESS_PERIOD = 0.1  # [s]; the generator misses the switcher after a few of them
CONTROLLERS_WITHIN = 5.0  # [s] after a goal, both must listen to their setpoints

Goal = tuple[str, int]  # id of its plan, stamp [ns] of its acceptance


class ModeSwitcher(WholeArmNode):
    """trajectory + status of its goal + joint states → velocity_setpoint, torque_setpoint, mode."""

    def __init__(self) -> None:
        super().__init__('mode_switcher', DECLARED)
        self.lockstep = self.parameters.pacing == Pacing.lockstep.value
        self.timeout = self.parameters.joint_states_timeout
        if self.lockstep:
            self.timeout = max(self.timeout, 10.0)

        self.execution: StampedExecution | None = None
        self.wanted: Goal | None = None
        self.wanted_since = 0.0  # [s]
        self.last_goal: Goal | None = None
        self.text: str | None = None  # a trajectory that has not been read yet
        self.trajectory: ManipulationTrajectory | None = None
        self.joints: Joints | None = None
        self.stamp, self.states, self.answered, self.heard = -1, 0, False, time.monotonic()
        self.mode, self.reason, self.by_motion, self.age = '', '', False, StampAge()

        self.mode_topic = self.publisher(channels.MODE)
        self.progress = self.publisher(channels.PROGRESS)
        self.velocity_setpoint = self.publisher(channels.VELOCITY_SETPOINT)
        self.torque_setpoint = self.publisher(channels.TORQUE_SETPOINT)
        self.setpoints = b'', b''  # the last ones, as published
        self.subscription(channels.MANIPULATION_TRAJECTORY, self.on_trajectory)
        self.subscription(channels.GOAL_STATUS, self.on_status)
        self.subscription(channels.JOINT_STATES, self.on_joints)
        self.service(channels.STOP, self.on_stop)
        self.every(WATCH_PERIOD, self.watch)
        self.every(PROGRESS_PERIOD, self.publish_progress)
        self.publish_mode(IDLE, '')

    def on_trajectory(self, message: String) -> None:
        """Read at once, but never while running: a long document would hold up the loop."""
        self.text, self.trajectory = message.data, None
        if not self.running():
            self.read_trajectory()

    def read_trajectory(self) -> None:
        """The newest document, once; raises DocumentError when it is damaged."""
        if self.trajectory is None and self.text is not None:
            text, self.text = self.text, None
            self.trajectory = ManipulationTrajectory.from_json(text)

    def on_status(self, message: GoalStatusArray) -> None:
        """A goal that executes is wanted; one that is being canceled is stopped."""
        for status in message.status_list:
            goal = (goal_name(goal_id_of(status.goal_info)), to_nanoseconds(status.goal_info.stamp))
            if (
                status.status == GoalStatus.STATUS_EXECUTING
                and goal not in (self.last_goal, self.wanted)
                and not self.running()
            ):
                self.wanted, self.wanted_since = goal, time.monotonic()
            if status.status == GoalStatus.STATUS_CANCELING and goal in (
                self.last_goal,
                self.wanted,
            ):
                self.stop('canceled')

    def begin(self, wanted: Goal, joints: Joints) -> None:
        """The wanted goal, as soon as its trajectory is here."""
        self.read_trajectory()
        if self.trajectory is None or self.trajectory.plan_id != wanted[0]:
            return
        if not (
            self.velocity_setpoint.get_subscription_count()
            and self.torque_setpoint.get_subscription_count()
        ):
            if time.monotonic() - self.wanted_since > CONTROLLERS_WITHIN:
                self.last_goal, self.wanted = wanted, None
                self.give_up('no controller listens to the setpoints')
            return
        self.last_goal, self.wanted = wanted, None
        self.execution = StampedExecution(
            self.trajectory,
            switch_options_of(self.parameters),
            self.parameters.settle,
            self.trajectory.probe if self.parameters.probe else None,
        )
        off = float(abs(joints.angles - self.trajectory.angles[0]).max())
        if not off <= self.parameters.start_tolerance:
            self.give_up(
                f'fingers are {off:.3f} rad from the start of the trajectory; '
                f'allowed: {self.parameters.start_tolerance}'
            )

    def on_joints(self, message: JointReading) -> None:
        """The setpoints for this joint state, and the end of a run when it cannot follow."""
        stamp, joints = to_joints(message)
        repeated = stamp == self.stamp
        if self.lockstep or not repeated:  # in real time the same state again is as good as silence
            self.heard = time.monotonic()
        if repeated:
            self.repeat()
            return
        before, backwards = self.joints, stamp < self.stamp
        self.joints, self.stamp, self.states, self.answered = joints, stamp, self.states + 1, False
        if self.execution and before and (backwards or jumped(before, joints)):
            self.give_up('time went backwards' if backwards else 'the hand was reset', after=IDLE)
        if backwards:
            self.age = StampAge()
        self.act(0.0 if self.lockstep else self.age(stamp, time.monotonic_ns()))

    def act(self, age: float = 0.0) -> None:
        """On joint states that are `age` [s] old; in lockstep time stands still, so they never
        are.
        """
        joints = self.joints
        if joints is None:
            return
        if self.wanted:
            self.begin(self.wanted, joints)
        if not self.execution or (self.lockstep and self.execution.over):
            return  # in lockstep time stands still while nothing runs
        motion, torque = self.execution.step_at(self.stamp, joints, age)
        self.setpoints = (
            velocity_setpoint_bytes(self.stamp, motion),
            effort_bytes(self.stamp, torque.joint, torque.effort),
        )
        self.publish_setpoints()
        if self.execution.mode != self.mode:
            self.publish_mode(self.execution.mode, self.execution.reason, by_motion=True)

    def publish_setpoints(self) -> None:
        """The last ones, again if need be."""
        for topic, setpoint in zip((self.velocity_setpoint, self.torque_setpoint), self.setpoints):
            topic.publish(setpoint)
        self.answered = True

    def repeat(self) -> None:
        """The hardware still waits: an answer was lost, or there was nothing to answer yet."""
        if self.answered:
            self.publish_setpoints()
        else:
            self.act()

    def running(self) -> bool:
        """Whether a trajectory is executed or its end is felt."""
        return self.execution is not None and self.execution.mode not in (DONE, STOPPED)

    def stop(self, reason: str) -> None:
        """Of what runs or is wanted: the fingers hold the object where that is possible."""
        if self.wanted:  # it has not begun, and does not any more
            self.last_goal, self.wanted = self.wanted, None
            self.publish_mode(STOPPED, reason)
        elif self.execution and self.joints and self.execution.mode != STOPPED:
            self.execution.stop(self.joints, reason)
            self.publish_mode(STOPPED, reason)

    def give_up(self, reason: str, after: str = STOPPED) -> None:
        """Without further setpoints: the drives hold the fingers."""
        was_running, self.execution = self.running(), None
        if was_running or after == STOPPED:
            self.publish_mode(STOPPED, reason)
        if after == IDLE:
            self.publish_mode(IDLE, reason)

    def on_stop(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Always succeeds; the message says whether anything ran."""
        running = self.execution is not None
        self.stop('mode_switcher/stop was called')
        response.success = True
        response.message = (
            'stopped: the fingers hold' if running else 'nothing was running; the drives hold'
        )
        return response

    def watch(self) -> None:
        """Without joint states a run ends."""
        silence = time.monotonic() - self.heard
        if self.running() and silence > self.timeout:
            self.give_up(f'no joint_states for {silence:.3f} s; allowed: {self.timeout} s')

    def publish_mode(self, mode: str, reason: str, by_motion: bool = False) -> None:
        """After the progress, which says why; by_motion: the execution came to it by itself."""
        self.mode, self.reason, self.by_motion = mode, reason, by_motion
        self.publish_progress()
        self.report()
        self.mode_topic.publish(String(data=mode))
        self.get_logger().info(f'{mode}: {reason}' if reason else mode)

    def publish_progress(self) -> None:
        """For the trajectory generator."""
        level, message, _ = self.health()
        name = self.get_fully_qualified_name()
        self.progress.publish(status_message(name, level, message, self.progress_values()))

    def progress_values(self) -> dict[str, Any]:
        """Of the goal that runs, or ran last; trajectory start: the stamp [ns] of its time 0."""
        run = self.execution
        started = run.trajectory_start if run else None
        return {
            'mode': self.mode,
            'reason': self.reason,
            'stopped by motion': self.mode == STOPPED and self.by_motion,
            'goal': self.last_goal[0] if self.last_goal else '',
            'goal stamp': self.last_goal[1] if self.last_goal else 0,
            'pacing': self.parameters.pacing,
            'stamp': self.stamp,
            'trajectory start': '' if started is None else started,
            'progress': run.progress if run else 0.0,
            'time left s': run.time_left if run else 0.0,
            'angles': '' if self.joints is None else json.dumps(self.joints.angles.tolist()),
            'pairs': felt_pairs(run),
            'interrupted': run.interrupted if run else '',
            'in band': run.in_band if run else '',
            'deviated': run.deviated if run else '',
            'course': told_course(run),
        }

    def health(self) -> Health:
        """The progress without the course, and figures of the loop; an error when stopped."""
        values = {
            **{k: v for k, v in self.progress_values().items() if k != 'course'},
            'states': self.states,
            'silence ms': 1e3 * (time.monotonic() - self.heard),
        }
        return ERROR if self.mode == STOPPED else OK, self.reason or self.mode, values


def felt_pairs(run: Execution | None) -> str:
    """What the probe has measured, JSON: a list of pairs [rad]; '' before one is begun."""
    if run is None or run.felt is None:
        return ''
    return json.dumps([pair.tolist() for pair in run.pairs])


def told_course(run: Execution | None) -> str:
    """Where both fingers were every COURSE_PERIOD, JSON: a list of pairs [rad]; '' before the end
    of a run.
    """
    return json.dumps(run.course.round(4).tolist()) if run and run.mode == DONE else ''


def main() -> None:
    """The executable."""
    run_node(ModeSwitcher)


if __name__ == '__main__':
    main()
