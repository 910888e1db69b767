"""The server's side of action-like topics: a node's goals, and its messages to clients."""

from typing import Any

from action_msgs.msg import GoalInfo

from wholearm_ros.model.outcomes import REJECTED
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.goals import CANCELING, NAMES, SUCCEEDED, Goals
from wholearm_ros.ros.interface.messages import (
    NO_GOAL,
    goal_id_of,
    goal_name,
    goal_statuses,
    status_message,
    to_nanoseconds,
)
from wholearm_ros.ros.node.node import OK, WARN, WholeArmNode


class GoalServer(Goals):
    """The goals of a node that publishes their status, feedback and results.

    name: of the server in its messages; status, feedback, result: its topics.
    """

    def __init__(
        self,
        node: WholeArmNode,
        name: str,
        status: channels.Topic,
        feedback: channels.Topic,
        result: channels.Topic,
    ) -> None:
        super().__init__()
        self._name = name
        self._status, self._feedback, self._result = map(node.publisher, (status, feedback, result))

    @property
    def busy(self) -> str:
        """Why another goal is rejected now, '' when it is not."""
        if self.active is None:
            return ''
        running = goal_name(goal_id_of(self.active.info))
        return f'busy with goal {running}; allowed: one at a time'

    def canceled_by(self, message: GoalInfo) -> bool:
        """Whether a message on `cancel` ends the active goal: its own id or none, and not again."""
        active = self.active
        if active is None or active.status == CANCELING:
            return False
        return goal_id_of(message) in (NO_GOAL, goal_id_of(active.info))

    def publish_status(self) -> None:
        """Of every goal that is remembered."""
        self._status.publish(goal_statuses(self.entries()))

    def publish_feedback(self, values: dict[str, Any]) -> None:
        """Of the active goal, which must exist."""
        assert self.active is not None
        told = {'goal_id': goal_name(goal_id_of(self.active.info)), **values}
        self._feedback.publish(status_message(self._name, OK, NAMES[self.active.status], told))

    def end(self, status: int, reason: str, values: dict[str, Any]) -> str:
        """The active goal's, which must exist, with its result; the line that says so."""
        goal = self.move(status, reason)
        self.publish_status()
        message = f'{NAMES[status]}: {reason}'
        level = OK if status == SUCCEEDED else WARN
        told = {'outcome': NAMES[status], 'reason': reason, **values}
        self._publish_result(level, message, goal_id_of(goal.info), goal.requested, told)
        return message

    def reject(self, request: GoalInfo, reason: str) -> None:
        """Told to its client; the active goal and its result stay."""
        told = {'outcome': REJECTED, 'reason': reason}
        requested = to_nanoseconds(request.stamp)
        self._publish_result(WARN, f'{REJECTED}: {reason}', goal_id_of(request), requested, told)

    def _publish_result(
        self, level: bytes, message: str, goal: bytes, requested: int, values: dict[str, Any]
    ) -> None:
        """requested [ns]: stamp of the request, which tells its client that it is meant: the same
        goal may be sent again, and by others.
        """
        told = {'goal_id': goal_name(goal), 'request_stamp': requested, **values}
        self._result.publish(status_message(self._name, level, message, told))
