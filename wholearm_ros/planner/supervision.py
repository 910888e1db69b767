"""Supervision of a reorientation: plan, execute, feel, and plan again from what was felt.

Pure: whoever executes tells the claim that came of it and is told what to do next.
"""

from dataclasses import dataclass, replace

from wholearm_ros.estimation.claim import Claim
from wholearm_ros.model.goal import goal_region
from wholearm_ros.model.outcomes import AT_GOAL, ELSEWHERE, LOST, UNKNOWN, UNVERIFIED
from wholearm_ros.model.scenario import GoalAtPose, GoalOnEdge, Scenario, StartOnEdge

PLAN, FEEL, END = 'plan', 'feel', 'end'
MAX_ATTEMPTS = 4
FEELS = 2  # probes in a row that may leave it open where the object lies
MOST_STOPS = 6  # on the way to one goal


@dataclass(frozen=True)
class Decision:
    """What to do next.

    action: PLAN `scenario`, from what was felt; FEEL once more; or END, with outcome and reason.
    """

    action: str
    outcome: str = ''
    reason: str = ''
    scenario: Scenario | None = None


@dataclass(frozen=True, eq=False)
class Supervision:
    """scenario: with the goal as given; attempts: trajectories executed so far; stops: those that
    arrived where they should on the way to the goal, which are not counted against `max_attempts`;
    stop: where the last trajectory should end, None for the goal itself: claims are of that; feels:
    probes since the last conclusive one; doubted: whether what the last one said is being felt once
    more; claims: so far, in order.
    """

    scenario: Scenario
    max_attempts: int = MAX_ATTEMPTS
    attempts: int = 0
    stops: int = 0
    stop: GoalOnEdge | None = None
    feels: int = 0
    doubted: bool = False
    claims: tuple[Claim, ...] = ()

    @property
    def spent(self) -> int:
        """Attempts, not counting those that arrived at a stop on the way."""
        return self.attempts - self.stops

    def begin(self) -> Decision:
        """What to do first."""
        if self.scenario.to_be_felt:
            return Decision(FEEL)
        return Decision(PLAN, scenario=self.scenario)

    def executed(
        self, claim: Claim, stop: GoalOnEdge | None = None, unfelt_end: StartOnEdge | None = None
    ) -> 'tuple[Supervision, Decision]':
        """After a trajectory and its probe; stop: where it should end when that is not the goal;
        unfelt_end: where it ended if it went as planned and was not to be felt.
        """
        begun = replace(self, attempts=self.attempts + 1, stop=stop, feels=0, doubted=False)
        if unfelt_end is None or claim.outcome != UNVERIFIED:
            return begun.felt(claim)
        arrived = replace(begun, stops=self.stops + 1, claims=(*self.claims, claim))
        return arrived._go_on(claim, unfelt_end)

    def felt(self, claim: Claim) -> 'tuple[Supervision, Decision]':
        """After a probe alone, or that of a trajectory; the claim is of where the last one should
        end, and before the first one of whatever was done before. The goal, felt where another
        face was to be expected, is felt once more.
        """
        after = replace(self, claims=(*self.claims, claim))
        sure = claim.outcome in (AT_GOAL, ELSEWHERE) and claim.felt is not None
        of_the_goal = self.attempts > 0 and self.stop is None
        if of_the_goal or not sure:
            return after._decide(claim)
        if self._fulfilled(claim):
            if self.stop is not None and claim.outcome != AT_GOAL and not self.doubted:
                return replace(after, doubted=True), Decision(FEEL)
            return after, Decision(END, AT_GOAL, claim.reason)
        arrived = self.stop is not None and claim.outcome == AT_GOAL
        return replace(after, stops=self.stops + arrived)._go_on(claim, _felt_place(claim))

    def no_plan(self, reason: str) -> Decision:
        """When the scenario cannot be planned."""
        last: Claim | None = self.claims[-1] if self.claims else None
        where = f'; {last.reason}' if last else ''
        outcome = last.outcome if last else UNKNOWN
        outcome = {AT_GOAL: ELSEWHERE, UNVERIFIED: UNKNOWN}.get(outcome, outcome)
        return Decision(END, outcome, f'no plan: {reason}{where}')

    def onwards(self, place: StartOnEdge) -> Scenario:
        """The scenario from where the object lies, to its goal in either direction."""
        moved = replace(self.scenario, start=place)
        if isinstance(moved.goal, GoalAtPose):
            return moved
        return replace(moved, goal=replace(moved.goal, direction=None))

    def _decide(self, claim: Claim) -> 'tuple[Supervision, Decision]':
        after = replace(self, feels=self.feels + 1)
        if claim.outcome in (AT_GOAL, LOST, UNVERIFIED):
            return after, Decision(END, claim.outcome, claim.reason)
        if claim.outcome == UNKNOWN:
            if after.feels < FEELS:
                return after, Decision(FEEL)
            return after, Decision(END, UNKNOWN, claim.reason)
        return replace(after, feels=0)._go_on(claim, _felt_place(claim))

    def _go_on(self, claim: Claim, place: StartOnEdge) -> 'tuple[Supervision, Decision]':
        """From where the object surely lies."""
        if self.spent >= self.max_attempts or self.stops > MOST_STOPS:
            return self, Decision(END, ELSEWHERE, claim.reason)
        return self, Decision(PLAN, scenario=self.onwards(place))

    def _fulfilled(self, claim: Claim) -> bool:
        """Whether what was felt at a stop, or short of it, is the goal already."""
        goal = self.scenario.goal
        if isinstance(goal, GoalAtPose) or claim.felt is None or len(claim.felt.best.edges) > 1:
            return False
        region, best = goal_region(self.scenario), claim.felt.best
        there = goal.x is None or abs(best.x - region.target[0]) <= region.tolerance[0]
        return goal.edge == best.edges[0] and bool(there)


def _felt_place(claim: Claim) -> StartOnEdge:
    """Where a claim that is sure has the object."""
    assert claim.felt is not None
    return StartOnEdge(claim.felt.best.edges[0], claim.felt.best.x)


def stop_of(asked: Scenario, planned: Scenario) -> GoalOnEdge | None:
    """The goal of a plan that was made for `asked` when it is only a stop on the way; else None."""
    here, there = planned.goal, asked.goal
    if not isinstance(here, GoalOnEdge) or not isinstance(there, GoalOnEdge):
        return None
    same_x = there.x is None or here.x == there.x
    return None if here.edge == there.edge and same_x else here
