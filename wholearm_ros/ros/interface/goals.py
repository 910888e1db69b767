"""The goals of a node: which one is active, and how the last ones ended."""

from dataclasses import dataclass, replace

from action_msgs.msg import GoalInfo, GoalStatus

from wholearm_ros.model import outcomes
from wholearm_ros.ros.interface.channels import REMEMBERED

ACCEPTED, EXECUTING, CANCELING = (
    GoalStatus.STATUS_ACCEPTED,
    GoalStatus.STATUS_EXECUTING,
    GoalStatus.STATUS_CANCELING,
)
SUCCEEDED, CANCELED, ABORTED = (
    GoalStatus.STATUS_SUCCEEDED,
    GoalStatus.STATUS_CANCELED,
    GoalStatus.STATUS_ABORTED,
)
NAMES = {
    ACCEPTED: 'accepted',
    EXECUTING: 'executing',
    CANCELING: 'canceling',
    SUCCEEDED: outcomes.SUCCEEDED,
    CANCELED: outcomes.CANCELED,
    ABORTED: outcomes.ABORTED,
}
ACTIVE = (ACCEPTED, EXECUTING, CANCELING)


@dataclass(frozen=True)
class Goal:
    """info: id and time of acceptance; status: one of the above; requested [ns]: stamp of its
    request; reason: why it ended.
    """

    info: GoalInfo
    status: int
    requested: int
    reason: str = ''

    @property
    def active(self) -> bool:
        """Whether it has not ended."""
        return self.status in ACTIVE

    def to(self, status: int, reason: str = '') -> 'Goal':
        """The same goal in another status."""
        return replace(self, status=status, reason=reason)


class Goals:
    """At most one active goal, and the last ones that ended."""

    def __init__(self) -> None:
        self.ended: list[Goal] = []
        self.active: Goal | None = None

    def accept(self, info: GoalInfo, requested: int) -> None:
        """`info` becomes the active goal; requested [ns]: stamp of its request."""
        self.active = Goal(info, ACCEPTED, requested)

    def move(self, status: int, reason: str = '') -> Goal:
        """The active goal, which must exist, to `status`; an ended one is remembered."""
        assert self.active is not None
        goal = self.active.to(status, reason)
        self.active = goal if goal.active else None
        if not goal.active:
            self.ended = [*self.ended, goal][-REMEMBERED:]
        return goal

    def entries(self) -> list[tuple[GoalInfo, int]]:
        """(info, status) of the ended ones and of the active one, oldest first."""
        goals = [*self.ended, *([self.active] if self.active else [])]
        return [(g.info, g.status) for g in goals]
