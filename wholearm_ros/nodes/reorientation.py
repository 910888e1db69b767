"""Leads the scenario's goal to its end: plan, execute, feel, and plan again from what was felt."""

import json
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from action_msgs.msg import GoalInfo
from diagnostic_msgs.msg import DiagnosticStatus
from rcl_interfaces.srv import SetParameters
from std_msgs.msg import String

from wholearm_ros.errors import WholeArmError
from wholearm_ros.estimation.claim import Claim
from wholearm_ros.model import modes
from wholearm_ros.model.outcomes import AT_GOAL, UNVERIFIED
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario import GoalOnEdge, Scenario, StartOnEdge
from wholearm_ros.model.scenario_file import scenario_to_dict
from wholearm_ros.planner.supervision import END, FEEL, MAX_ATTEMPTS, Decision, Supervision, stop_of
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.common_parameters import SCENARIO, scenario_of
from wholearm_ros.ros.interface.goals import (
    ABORTED,
    CANCELED,
    CANCELING,
    EXECUTING,
    SUCCEEDED,
)
from wholearm_ros.ros.interface.messages import (
    FEEL_GOAL,
    NO_GOAL,
    PLANNER_BUSY,
    goal_id_of,
    goal_message,
    goal_name,
    parameter_request,
    to_goal_id,
    to_nanoseconds,
    values_of,
)
from wholearm_ros.ros.interface.parameters import Declared
from wholearm_ros.ros.node.goal_server import GoalServer
from wholearm_ros.ros.node.node import OK, WholeArmNode
from wholearm_ros.ros.node.run import run_node

DECLARED = (
    replace(SCENARIO, read_only=False),
    Declared(
        'max_attempts', MAX_ATTEMPTS, 'trajectories at most for one goal', 1, 20, read_only=False
    ),
)
WATCH_PERIOD = 0.1  # [s]
ANSWER_WITHIN = 5.0  # [s] for the planner to take a scenario
PLANNER_WITHIN = 5.0  # [s] for which the planner's services may be out of sight
SET_PARAMETERS = channels.Service('contact_state_planner/set_parameters', SetParameters)


class Reorientation(WholeArmNode):
    """goal, cancel → status, feedback, result; asks the planner, sends goals to the generator."""

    def __init__(self) -> None:
        super().__init__('reorientation', DECLARED)
        self.scenario = scenario_of(self.parameters)  # refused now rather than at the first goal
        self.goals = GoalServer(
            self,
            'reorientation',
            channels.REORIENTATION_STATUS,
            channels.REORIENTATION_FEEDBACK,
            channels.REORIENTATION_RESULT,
        )
        self.supervision = Supervision(self.scenario)
        self.phase, self.round = '', 0
        self.asked: Scenario | None = None  # what the planner was asked for
        self.stop: GoalOnEdge | None = None  # where what is executed ends, if not at the goal
        self.unfelt_end: StartOnEdge | None = None  # and where, if that is not felt
        self.wanted = ''  # beginning of the id of the plan that shall be executed
        self.plan: ContactPlan | None = None  # the newest
        self.trajectory_of = ''  # id of the plan of the newest trajectory
        self.sent: tuple[bytes, int] | None = None  # id and request stamp of the generator's goal
        self.last: dict[str, str] = {}  # the generator's last result
        self.tries: list[dict[str, Any]] = []
        self.planner_is_busy = False
        self.unasked: str | None = None  # scenario that the planner has not confirmed yet
        self.ask_after = 0.0  # [s], when it is told again: an answer may be lost
        self.planner_seen = 0.0  # [s] on the machine's clock

        self.planner = self.create_client(channels.PLAN_SCENARIO.type, channels.PLAN_SCENARIO.name)
        self.planner_parameters = self.create_client(SET_PARAMETERS.type, SET_PARAMETERS.name)
        self.generator_goal = self.publisher(channels.GOAL)
        self.generator_cancel = self.publisher(channels.CANCEL)
        self.subscription(channels.REORIENTATION_GOAL, self.on_goal)
        self.subscription(channels.REORIENTATION_CANCEL, self.on_cancel)
        self.subscription(channels.CONTACT_PLAN, self.on_plan)
        self.subscription(channels.MANIPULATION_TRAJECTORY, self.on_trajectory)
        self.subscription(channels.FEEDBACK, self.on_generator_feedback)
        self.subscription(channels.RESULT, self.on_generator_result)
        self.every(WATCH_PERIOD, self.watch)
        self.goals.publish_status()

    # -- goals of clients

    def on_goal(self, message: GoalInfo) -> None:
        """Accepted unless another one is active; any id, the scenario is the parameter's now."""
        goal = goal_id_of(message)
        zero = '' if goal != NO_GOAL else 'the goal id is zero; allowed: any other UUID'
        reason = self.goals.busy or zero or self.read_scenario()
        if reason:
            self.get_logger().warning(f'rejected: {reason}')
            self.goals.reject(message, reason)
            return
        info = goal_message(goal, self.get_clock().now().to_msg())
        self.goals.accept(info, to_nanoseconds(message.stamp))
        self.goals.move(EXECUTING)
        self.goals.publish_status()
        self.round, self.sent, self.last, self.tries = self.round + 1, None, {}, []
        self.stop = None
        self.supervision = Supervision(self.scenario, self.parameters.max_attempts)
        self.decide(self.supervision.begin())

    def read_scenario(self) -> str:
        """Why the scenario that is configured now cannot be pursued; '' when it can."""
        try:
            self.scenario = scenario_of(self.parameters)
        except WholeArmError as error:
            return str(error)
        return ''

    def on_cancel(self, message: GoalInfo) -> None:
        """At once while planning; while executing the hand comes to a hold first."""
        if not self.goals.canceled_by(message):
            return
        self.goals.move(CANCELING)
        self.goals.publish_status()
        if self.sent is None:
            self.end(CANCELED, f'canceled while {self.phase}')
        else:
            self.generator_cancel.publish(goal_message(self.sent[0], self.now()))

    # -- what is done next

    def decide(self, decision: Decision) -> None:
        """Plan one of the scenarios, feel, or end."""
        if decision.action == END:
            reached = decision.outcome in (AT_GOAL, UNVERIFIED)
            self.end(SUCCEEDED if reached else ABORTED, decision.reason)
        elif decision.action == FEEL:
            self.send(FEEL_GOAL, modes.FEELING)
        else:
            assert decision.scenario is not None
            self.ask(decision.scenario)

    def ask(self, scenario: Scenario) -> None:
        """For a plan of that scenario."""
        self.phase, self.wanted, self.asked = modes.PLANNING, '', scenario
        self.publish_feedback({})
        self.unasked, self.ask_after = json.dumps(scenario_to_dict(scenario)), 0.0
        self.planner_seen = time.monotonic()
        self.look_for_planner()

    def no_plan(self, reason: str) -> None:
        """The end of the goal."""
        self.end(ABORTED, self.supervision.no_plan(reason).reason)

    def look_for_planner(self) -> None:
        """Asked as soon as it is seen: a node that has just begun may not have found it yet."""
        ready = self.planner.service_is_ready() and self.planner_parameters.service_is_ready()
        if not ready:
            if time.monotonic() - self.planner_seen > PLANNER_WITHIN:
                self.end(ABORTED, 'contact_state_planner is gone, or not there yet')
            return
        self.planner_seen = time.monotonic()
        if self.unasked is not None and self.planner_seen > self.ask_after:
            self.ask_after = self.planner_seen + ANSWER_WITHIN
            self.configure_planner(self.unasked, then=self.on_configured)
        elif self.planner_is_busy:
            self.ask_for_plan()

    def configure_planner(self, scenario: str, then: Callable[[Any], None] | None) -> None:
        """Tell the planner its scenario, a document or what the parameter was."""
        request = parameter_request('scenario', scenario)
        if then is None:
            self.planner_parameters.call_async(request)
        else:
            self.call(self.planner_parameters, request, then)

    def on_configured(self, answer: Any) -> None:
        """The planner has its scenario, or says why not."""
        if self.unasked is None:
            return  # it was asked again, and has answered twice
        told, self.unasked = answer.results[0], None
        if told.successful:
            self.ask_for_plan()
        else:
            self.no_plan(told.reason)

    def ask_for_plan(self) -> None:
        """Of the scenario that the planner has."""
        self.planner_is_busy = False
        self.call(self.planner, channels.PLAN_SCENARIO.type.Request(), self.on_answer)

    def on_answer(self, answer: Any) -> None:
        """Of the planner: the plan is on its way, or there is none."""
        if answer.message == PLANNER_BUSY:  # with the plan of a goal that was canceled: asked again
            self.planner_is_busy = True
            return
        if not answer.success:
            self.no_plan(answer.message)
            return
        self.wanted = answer.message.partition('plan ')[2].partition(':')[0]
        self.send_when_ready()

    def call(self, client: Any, request: Any, then: Callable[[Any], None]) -> None:
        """`then(response)`, unless the goal has ended meanwhile."""
        asked = self.round

        def done(future: Any) -> None:
            if self.round == asked and self.goals.active:
                then(future.result())

        client.call_async(request).add_done_callback(done)

    def on_plan(self, message: String) -> None:
        """The planner's newest; one from where the object lies is what was asked for, even if the
        planner's answer is lost.
        """
        self.plan = _plan(message.data)
        if self.plan and self.asked and self.phase == modes.PLANNING:
            if _same_start(self.asked, self.plan.scenario):
                self.wanted, self.planner_is_busy = self.plan.id, False
        self.send_when_ready()

    def on_trajectory(self, message: String) -> None:
        """The generator's newest: now it takes goals of that plan."""
        self.trajectory_of = _key(message.data, 'plan_id')
        self.send_when_ready()

    def send_when_ready(self) -> None:
        """The generator's goal, as soon as plan and trajectory are those that were answered."""
        plan = self.plan
        if not (plan and self.asked and self.wanted and plan.id.startswith(self.wanted)):
            return
        if self.trajectory_of == plan.id and self.phase == modes.PLANNING:
            self.stop, self.unfelt_end = stop_of(self.asked, plan.scenario), plan.unfelt_end
            self.send(to_goal_id(plan.id), modes.EXECUTING)

    def send(self, goal: bytes, phase: str) -> None:
        """A goal for the generator."""
        stamp = self.now()
        self.phase, self.sent = phase, (goal, to_nanoseconds(stamp))
        self.generator_goal.publish(goal_message(goal, stamp))
        self.publish_feedback({})

    # -- what the generator says

    def on_generator_feedback(self, message: DiagnosticStatus) -> None:
        """Passed on."""
        values = values_of(message)
        if self.sent and self.goals.active and values.get('goal_id') == goal_name(self.sent[0]):
            self.publish_feedback(values)

    def on_generator_result(self, message: DiagnosticStatus) -> None:
        """Of the goal that was sent: felt, or ended before that."""
        values = values_of(message)
        if not self.sent or values.get('goal_id') != goal_name(self.sent[0]):
            return
        if values.get('request_stamp') != str(self.sent[1]):
            return  # of another request: an earlier one, or another client's
        canceling = bool(self.goals.active and self.goals.active.status == CANCELING)
        planned, self.sent, self.last = self.phase == modes.EXECUTING, None, values
        said = _claim(values)
        self.tries.append(_told(values, planned, self.stop))
        if canceling or values.get('outcome') == 'canceled' or said is None:
            ended_by_cancel = canceling or values.get('outcome') == 'canceled'
            self.end(CANCELED if ended_by_cancel else ABORTED, values.get('reason', ''))
            return
        if planned:
            self.supervision, decision = self.supervision.executed(said, self.stop, self.unfelt_end)
        else:
            self.supervision, decision = self.supervision.felt(said)
        self.decide(decision)

    def watch(self) -> None:
        """A node that is gone answers no more."""
        if not self.goals.active:
            return
        if self.phase == modes.PLANNING:
            self.look_for_planner()
        elif self.phase != modes.PLANNING and not self.count_publishers(channels.RESULT.name):
            self.end(ABORTED, 'trajectory_generator is gone')

    # -- what is told

    def end(self, status: int, reason: str) -> None:
        """The active goal's; the planner gets back the scenario it had."""
        self.round, self.phase, self.sent, self.asked = self.round + 1, '', None, None
        self.configure_planner(self.parameters.scenario, then=None)
        felt = {k: v for k, v in self.last.items() if k.startswith(('felt', 'claimed'))}
        values = {
            **felt,
            'attempts': self.supervision.attempts,
            'stamp': self.last.get('stamp', ''),
            'tries': json.dumps(self.tries),
        }
        message = self.goals.end(status, reason, values)
        if status == SUCCEEDED:
            self.get_logger().info(message)
        else:  # rclpy wants every line of code to keep to one severity
            self.get_logger().warning(message)

    def publish_feedback(self, progress: dict[str, str]) -> None:
        """phase and attempt, and what the generator says while it executes."""
        values = {
            'phase': self.phase,
            'attempt': self.supervision.attempts + (self.phase != modes.FEELING),
            'max_attempts': self.supervision.max_attempts,
            'tries': json.dumps(self.tries),
            **{key: progress.get(key, '') for key in ('mode', 'progress', 'time_left')},
        }
        self.goals.publish_feedback(values)

    def now(self) -> Any:
        """Stamp of this instant."""
        return self.get_clock().now().to_msg()

    def health(self) -> tuple[bytes, str, dict[str, Any]]:
        """For /diagnostics."""
        values = {
            'attempts': self.supervision.attempts,
            channels.GOAL_LISTENERS: self.generator_goal.get_subscription_count(),
        }
        return OK, self.phase or 'ready', values

    def leave(self) -> None:
        """Whoever waits is told, and the hand holds."""
        if self.goals.active:
            if self.sent:
                self.generator_cancel.publish(goal_message(self.sent[0], self.now()))
            self.end(ABORTED, 'the node reorientation was ended')


def _key(document: str, key: str) -> str:
    """Text under a key of a JSON document of whatever kind; '' of one that is damaged."""
    try:
        found = json.loads(document).get(key)
    except (ValueError, AttributeError, RecursionError):
        return ''
    return found if isinstance(found, str) else ''


def _plan(document: str) -> ContactPlan | None:
    """None of a damaged one."""
    try:
        return ContactPlan.from_json(document)
    except WholeArmError:
        return None


def _same_start(asked: Scenario, planned: Scenario) -> bool:
    """Whether both are of one object in one hand, from one start."""
    one, other = (scenario_to_dict(replace(s, name='', goal=asked.goal)) for s in (asked, planned))
    return one == other


def _claim(values: dict[str, str]) -> Claim | None:
    """What a result of the generator claims; None of one that claims nothing."""
    return Claim.from_dict(values) if values.get('claimed') else None


def _told(values: dict[str, str], planned: bool, stop: GoalOnEdge | None) -> dict[str, Any]:
    """An attempt, or a probe alone, in the list of a result."""
    keys = ('goal_id', 'outcome', 'claimed', 'reason', 'felt_edge', 'felt_x', 'stamp')
    return {
        'planned': planned,
        'stop': stop.edge if stop else '',
        **{key: values.get(key, '') for key in keys},
    }


def main() -> None:
    """Entry point of the executable."""
    run_node(Reorientation)


if __name__ == '__main__':
    main()
