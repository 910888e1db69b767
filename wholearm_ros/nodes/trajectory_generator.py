"""Makes the trajectory of a contact plan, and takes goals: which one runs, how far it is, how it
ended.
"""

import json
import time
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from action_msgs.msg import GoalInfo
from diagnostic_msgs.msg import DiagnosticStatus
from std_msgs.msg import String

from wholearm_ros.estimation.claim import Claim, reported_as_kept, reported_claim, unfelt_claim
from wholearm_ros.estimation.feel import Feeler, Felt
from wholearm_ros.estimation.hold import hold_to_feel
from wholearm_ros.estimation.probe_plan import probe_after
from wholearm_ros.model.choices import Pacing
from wholearm_ros.model.modes import DONE, IDLE, STOPPED
from wholearm_ros.model.outcomes import AT_GOAL, UNKNOWN, UNVERIFIED
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.common_parameters import SCENARIO, scenario_of
from wholearm_ros.ros.interface.goals import (
    ABORTED,
    ACCEPTED,
    CANCELED,
    CANCELING,
    EXECUTING,
    NAMES,
    SUCCEEDED,
)
from wholearm_ros.ros.interface.messages import (
    FEEL_GOAL,
    goal_id_of,
    goal_message,
    goal_name,
    set_stamp,
    to_goal_id,
    to_joint_trajectory,
    to_nanoseconds,
    values_of,
)
from wholearm_ros.ros.interface.parameters import Declared
from wholearm_ros.ros.node.goal_server import GoalServer
from wholearm_ros.ros.node.node import OK, Health, WholeArmNode
from wholearm_ros.ros.node.run import run_node
from wholearm_ros.ros.visualization.markers import plan_markers
from wholearm_ros.trajectory.main_trajectory import generate

DECLARED = (
    SCENARIO,
    Declared(
        'switcher_timeout',
        0.4,
        'without a word of the mode switcher beyond which a goal is aborted; in lockstep at least '
        '10 [s]',
        0.1,
        600.0,
    ),
)
WATCH_PERIOD = 0.05  # [s]
PATIENCE_IN_LOCKSTEP = 10.0  # [s]: processes may take the time they need


class EarlyGoal(NamedTuple):
    """A goal to feel before the mode switcher has said where the fingers are, since [s]."""

    message: GoalInfo
    since: float


class TrajectoryGenerator(WholeArmNode):
    """contact_plan → trajectories; goal, cancel, progress → status, feedback, result."""

    def __init__(self) -> None:
        super().__init__('trajectory_generator', DECLARED)
        self.goals = GoalServer(
            self,
            'trajectory_generator',
            channels.GOAL_STATUS,
            channels.FEEDBACK,
            channels.RESULT,
        )
        self.trajectory: ManipulationTrajectory | None = None  # of the newest plan
        self.plan_id: bytes | None = None
        self.unfelt = False  # whether the end of the newest plan is not to be felt
        self.executed: ManipulationTrajectory | None = None  # of the last goal
        self.published: bytes | None = None  # plan id of the newest trajectory
        self.early: EarlyGoal | None = None
        self.kept = False  # whether the last run of a plan kept to it
        self.progress: dict[str, str] = {}  # of the mode switcher
        self.silence, self.watched = 0.0, time.monotonic()  # [s] without progress; last watch
        self.last_stamp = 0  # [ns]
        self.scenario = scenario_of(self.parameters)
        self.feeler = Feeler(self.scenario)
        self.claimed: Claim | None = None
        self.felt_before: Felt | None = None  # by the probe before this goal's, nothing moved since

        self.joint_trajectory = self.publisher(channels.JOINT_TRAJECTORY)
        self.manipulation_trajectory = self.publisher(channels.MANIPULATION_TRAJECTORY)
        self.markers = self.publisher(channels.MARKERS)
        self.subscription(channels.CONTACT_PLAN, self.on_plan)
        self.subscription(channels.GOAL, self.on_goal)
        self.subscription(channels.CANCEL, self.on_cancel)
        self.subscription(channels.PROGRESS, self.on_progress)
        self.every(WATCH_PERIOD, self.watch)
        self.goals.publish_status()

    def on_plan(self, message: String) -> None:
        """Its trajectory and what it looks like; raises DocumentError when the plan is damaged."""
        plan = ContactPlan.from_json(message.data)
        self.feeler, self.scenario = Feeler(plan.scenario), plan.scenario
        trajectory = generate(plan.scenario, plan)
        self.unfelt = plan.unfelt_end is not None
        if not self.unfelt:
            trajectory = replace(trajectory, probe=probe_after(self.feeler, trajectory))
        self.trajectory = trajectory
        self.plan_id = to_goal_id(plan.id)
        now = self.get_clock().now().to_msg()
        palm = self.frame(channels.PALM_FRAME)
        self.joint_trajectory.publish(to_joint_trajectory(trajectory, now, palm))
        self.publish_trajectory(trajectory)
        self.markers.publish(plan_markers(plan.scenario, trajectory, palm))
        self.get_logger().info(f'plan {plan.id[:8]}: trajectory of {trajectory.duration:.2f} s')

    def publish_trajectory(self, trajectory: ManipulationTrajectory) -> None:
        """For the mode switcher."""
        self.published = to_goal_id(trajectory.plan_id)
        self.manipulation_trajectory.publish(String(data=trajectory.to_json()))

    def on_goal(self, message: GoalInfo) -> None:
        """The newest plan, or to feel; rejected while another one is active."""
        goal = goal_id_of(message)
        if goal not in (self.plan_id, FEEL_GOAL):
            known = goal_name(self.plan_id) if self.plan_id else 'none yet'
            self.reject(
                message, f'unknown plan {goal_name(goal)}; allowed: the newest plan ({known})'
            )
        elif self.goals.busy:
            self.reject(message, self.goals.busy)
        elif goal == FEEL_GOAL and not self.progress.get('angles'):
            self.early = EarlyGoal(message, time.monotonic())
        else:
            trajectory = self.hold() if goal == FEEL_GOAL else self.trajectory
            assert trajectory is not None  # its plan's id is known
            if self.published != goal or goal == FEEL_GOAL:
                self.publish_trajectory(trajectory)
            self.executed = trajectory
            self.last_stamp = max(self.get_clock().now().nanoseconds, self.last_stamp + 1)
            info = goal_message(goal, self.get_clock().now().to_msg())
            set_stamp(info.stamp, self.last_stamp)
            self.goals.accept(info, to_nanoseconds(message.stamp))
            self.goals.publish_status()
            self.felt_before = self.claimed.felt if self.claimed and goal == FEEL_GOAL else None
            self.silence, self.claimed = 0.0, None
            self.watch()

    def hold(self) -> ManipulationTrajectory:
        """The fingers where they are, and the probe of what lies between them: from the other side
        than the last one, where the last goal ended with one.
        """
        angles = np.array(json.loads(self.progress['angles']))
        felt = self.claimed.felt if self.claimed else None
        hold = hold_to_feel(self.feeler, angles, self.executed, felt)
        return replace(hold, plan_id=goal_name(FEEL_GOAL))

    def reject(self, request: GoalInfo, reason: str) -> None:
        """Logged, and told to the client."""
        self.get_logger().warning(f'goal rejected: {reason}')
        self.goals.reject(request, reason)

    def on_cancel(self, message: GoalInfo) -> None:
        """The mode switcher sees the status and stops the run."""
        if self.goals.canceled_by(message):
            self.goals.move(CANCELING)
            self.goals.publish_status()

    def on_progress(self, message: DiagnosticStatus) -> None:
        """Of the mode switcher, ten times a second and at every change of its mode."""
        self.progress, self.silence = values_of(message), 0.0
        if self.early and self.progress.get('angles'):
            early, self.early = self.early.message, None
            self.on_goal(early)
        active = self.goals.active
        if not active:
            return
        goal = goal_name(goal_id_of(active.info)), str(to_nanoseconds(active.info.stamp))
        its_own = (self.progress.get('goal'), self.progress.get('goal stamp')) == goal
        self.publish_feedback(self.progress if its_own else {})
        if its_own and self.progress.get('mode') in (DONE, STOPPED, IDLE):
            self.conclude(self.progress['mode'], active.status == CANCELING)

    def publish_feedback(self, progress: dict[str, str]) -> None:
        """progress: of the active goal, empty before it runs."""
        self.goals.publish_feedback(
            {
                'mode': progress.get('mode', ''),
                'progress': progress.get('progress', ''),
                'time_left': progress.get('time left s', ''),
            }
        )

    def watch(self) -> None:
        """A goal executes as soon as a mode switcher is there, and ends when it falls silent.

        A watch that comes late tells of this process, not of the mode switcher: it counts as one
        in time, for what has arrived meanwhile is read after it.
        """
        now = time.monotonic()
        self.silence += min(now - self.watched, 2.0 * WATCH_PERIOD)
        self.watched = now
        if self.early and now - self.early.since > PATIENCE_IN_LOCKSTEP:
            early, self.early = self.early.message, None
            self.reject(early, 'the mode switcher has not told where the fingers are')
        active = self.goals.active
        if not active:
            return
        if active.status == ACCEPTED and self.progress and self.silence < self.patience():
            self.goals.move(EXECUTING)  # a mode switcher is there
            self.goals.publish_status()
            self.get_logger().info(f'executing plan {goal_name(goal_id_of(active.info))[:8]}')
        elif self.silence > self.patience():
            self.end(ABORTED, f'nothing from the mode switcher for {self.silence:.2f} s')

    def patience(self) -> float:
        """[s] without a word of the mode switcher; before its first one, as in lockstep."""
        timeout: float = self.parameters.switcher_timeout
        in_real_time = self.progress.get('pacing') == Pacing.realtime.value
        return timeout if in_real_time else max(timeout, PATIENCE_IN_LOCKSTEP)

    def conclude(self, mode: str, canceling: bool) -> None:
        """The active goal's end in a final mode; when it is done, what was felt decides."""
        executed = self.executed
        if mode == DONE and executed:
            self.claimed = self.claim_of(executed)
            reached = self.claimed.outcome in (AT_GOAL, UNVERIFIED)
            self.end(SUCCEEDED if reached else ABORTED, self.claimed.reason)
        else:
            reason = self.progress.get('reason') or f'the mode switcher is {mode}'
            if self.progress.get('stopped by motion') == str(True) and not canceling:
                self.claimed = Claim(UNKNOWN, f'stopped: {reason}')  # the hand may feel, and go on
            self.end(CANCELED if canceling else ABORTED, reason)

    def claim_of(self, executed: ManipulationTrajectory) -> Claim:
        """What may be said of the end of a trajectory that was led to it."""
        if executed is self.trajectory:
            self.kept = reported_as_kept(self.feeler, executed, self.progress)
            if self.unfelt:
                return unfelt_claim(self.progress.get('deviated', ''))
        return reported_claim(
            self.feeler, self.scenario, executed.probe, self.progress, self.kept, self.felt_before
        )

    def end(self, status: int, reason: str) -> None:
        """The active goal's, with its result."""
        assert self.goals.active is not None
        name = goal_name(goal_id_of(self.goals.active.info))
        values = {
            'stamp': self.progress.get('stamp', ''),
            'progress': self.progress.get('progress', ''),
            'duration': self.executed.duration if self.executed else '',
            **({} if self.claimed is None else told_values(self.claimed)),
        }
        ended = self.goals.end(status, reason, values)
        self.get_logger().info(f'goal {name[:8]} {ended}')

    def health(self) -> Health:
        """The newest plan, and the active goal's status."""
        active = self.goals.active
        values = {
            'plan': goal_name(self.plan_id) if self.plan_id else '',
            'goals ended': len(self.goals.ended),
        }
        return OK, NAMES[active.status] if active else 'ready', values


def told_values(claimed: Claim) -> dict[str, Any]:
    """What a result says of a claim."""
    return {key: '' if v is None else v for key, v in claimed.to_dict().items()}


def main() -> None:
    """The executable."""
    run_node(TrajectoryGenerator)


if __name__ == '__main__':
    main()
