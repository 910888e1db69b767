"""Makes the trajectory of a contact plan, and takes goals: which one runs, how far it is, how it ended."""

import sys
import time

from diagnostic_msgs.msg import DiagnosticStatus
from std_msgs.msg import String

from wholearm_ros.control.mode_switch import DONE, IDLE, STOPPED
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.goals import (
    ABORTED,
    ACCEPTED,
    CANCELED,
    CANCELING,
    EXECUTING,
    NAMES,
    SUCCEEDED,
    Goals,
)
from wholearm_ros.ros.interface.messages import (
    NO_GOAL,
    goal_id_of,
    goal_message,
    goal_name,
    goal_statuses,
    set_stamp,
    status_message,
    to_goal_id,
    to_joint_trajectory,
    to_nanoseconds,
    values_of,
)
from wholearm_ros.ros.interface.parameters import Declared
from wholearm_ros.ros.node.node import OK, WARN, WholeArmNode
from wholearm_ros.ros.node.run import run_node
from wholearm_ros.ros.visualization.markers import plan_markers
from wholearm_ros.trajectory.main_trajectory import generate

DECLARED = (
    Declared(
        'switcher_timeout',
        5.0,
        'without a word of the mode switcher beyond which a goal is aborted [s]',
        0.1,
        600.0,
    ),
)
WATCH_PERIOD = 0.1  # [s]
AFTERWORD = (
    0.1  # [s] after done or stopped, in which the switcher's reason and last stamp may still come
)


class TrajectoryGenerator(WholeArmNode):
    """contact_plan → trajectories; goal, cancel, mode → status, feedback, result."""

    def __init__(self):
        super().__init__('trajectory_generator', DECLARED)
        self.goals, self.trajectory, self.plan_id, self.mode, self.ran = (
            Goals(),
            None,
            None,
            '',
            False,
        )
        self.heard, self.said, self.last_word, self.last_stamp = 0.0, {}, None, 0

        self.joint_trajectory = self.publisher(channels.JOINT_TRAJECTORY)
        self.manipulation_trajectory = self.publisher(channels.MANIPULATION_TRAJECTORY)
        self.markers = self.publisher(channels.MARKERS)
        self.status = self.publisher(channels.GOAL_STATUS)
        self.feedback = self.publisher(channels.FEEDBACK)
        self.result = self.publisher(channels.RESULT)
        self.subscription(channels.CONTACT_PLAN, self.on_plan)
        self.subscription(channels.GOAL, self.on_goal)
        self.subscription(channels.CANCEL, self.on_cancel)
        self.subscription(channels.MODE, self.on_mode)
        self.subscription(channels.DIAGNOSTICS, self.on_diagnostics)
        self.every(WATCH_PERIOD, self.watch)
        self.switcher = self.get_namespace().rstrip('/') + '/mode_switcher'
        self.publish_status()

    def on_plan(self, message):
        plan = ContactPlan.from_json(message.data)
        self.trajectory = generate(plan.scenario, plan)
        self.plan_id = to_goal_id(plan.id)
        now = self.get_clock().now().to_msg()
        self.joint_trajectory.publish(to_joint_trajectory(self.trajectory, now))
        self.manipulation_trajectory.publish(String(data=self.trajectory.to_json()))
        self.markers.publish(plan_markers(plan.scenario, self.trajectory))
        self.get_logger().info(
            f'plan {plan.id[:8]}: trajectory of {self.trajectory.duration:.2f} s'
        )

    def on_goal(self, message):
        goal = goal_id_of(message)
        if goal != self.plan_id:
            known = goal_name(self.plan_id) if self.plan_id else 'none yet'
            self.reject(
                message, f'unknown plan {goal_name(goal)}; allowed: the newest plan ({known})'
            )
        elif self.goals.active:
            self.reject(
                message,
                f'busy with goal {goal_name(goal_id_of(self.goals.active.info))}; allowed: one at a time',
            )
        else:
            self.last_stamp = max(self.get_clock().now().nanoseconds, self.last_stamp + 1)
            info = goal_message(goal, self.get_clock().now().to_msg())
            set_stamp(info.stamp, self.last_stamp)
            self.goals.accept(info)
            self.publish_status()
            self.heard, self.last_word, self.said, self.ran = time.monotonic(), None, {}, False
            self.watch()

    def reject(self, request, reason: str):
        """The stamp of the request tells its client that it is meant: others may have sent the same goal."""
        self.get_logger().warning(f'goal rejected: {reason}')
        self.publish_result(
            WARN,
            f'rejected: {reason}',
            goal_id_of(request),
            'rejected',
            {'reason': reason, 'request_stamp': to_nanoseconds(request.stamp)},
        )

    def on_cancel(self, message):
        goal, active = goal_id_of(message), self.goals.active
        if active and active.status != CANCELING and goal in (NO_GOAL, goal_id_of(active.info)):
            self.goals.move(CANCELING)
            self.heard = time.monotonic()
            self.publish_status()

    def on_mode(self, message):
        self.heard, self.mode = time.monotonic(), message.data
        if not self.goals.active:
            return
        if message.data not in (DONE, STOPPED, IDLE):
            self.ran = True
        elif not self.last_word and (self.ran or message.data == STOPPED):
            self.last_word = message.data, time.monotonic()

    def on_diagnostics(self, message):
        for status in message.status:
            if status.name == self.switcher:
                self.heard, self.said = time.monotonic(), values_of(status)
                if self.goals.active:
                    self.publish_feedback()

    def publish_feedback(self):
        values = {
            'goal_id': goal_name(goal_id_of(self.goals.active.info)),
            'mode': self.said.get('mode', ''),
            'progress': self.said.get('progress', ''),
            'time_left': self.said.get('time left s', ''),
        }
        self.feedback.publish(
            status_message(
                'trajectory_generator', DiagnosticStatus.OK, NAMES[self.goals.active.status], values
            )
        )

    def watch(self):
        if not self.goals.active:
            return
        now = time.monotonic()
        if self.goals.active.status == ACCEPTED and self.mode:  # a mode switcher is there
            self.goals.move(EXECUTING)
            self.publish_status()
            self.get_logger().info(
                f'executing plan {goal_name(goal_id_of(self.goals.active.info))[:8]}'
            )
        if self.last_word and now - self.last_word[1] > AFTERWORD:
            self.conclude(self.last_word[0], self.goals.active.status == CANCELING)
        elif now - self.heard > self.parameters.switcher_timeout:
            self.end(
                ABORTED, f'nothing from the mode switcher for {self.parameters.switcher_timeout} s'
            )

    def conclude(self, mode: str, canceling: bool):
        if mode == DONE:
            self.end(SUCCEEDED, 'the trajectory was led to its end')
        else:
            self.end(
                CANCELED if canceling else ABORTED,
                self.said.get('reason') or f'the mode switcher is {mode}',
            )

    def end(self, status: int, reason: str):
        goal = self.goals.move(status, reason)
        self.publish_status()
        values = {
            'reason': reason,
            'stamp': self.said.get('stamp', ''),
            'progress': self.said.get('progress', ''),
            'duration': self.trajectory.duration,
        }
        name = NAMES[status]
        self.publish_result(
            OK if status == SUCCEEDED else WARN,
            f'{name}: {reason}',
            goal_id_of(goal.info),
            name,
            values,
        )
        self.get_logger().info(f'goal {goal_name(goal_id_of(goal.info))[:8]} {name}: {reason}')

    def publish_result(self, level, message: str, goal: bytes, outcome: str, values: dict):
        self.result.publish(
            status_message(
                'trajectory_generator',
                level,
                message,
                {'goal_id': goal_name(goal), 'outcome': outcome, **values},
            )
        )

    def publish_status(self):
        self.status.publish(goal_statuses(self.goals.entries()))

    def health(self):
        active = self.goals.active
        values = {
            'plan': goal_name(self.plan_id) if self.plan_id else '',
            'goals ended': len(self.goals.ended),
        }
        return OK, NAMES[active.status] if active else 'ready', values


def main():
    sys.exit(run_node(TrajectoryGenerator))


if __name__ == '__main__':
    main()
