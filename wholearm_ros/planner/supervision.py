"""Supervision of a reorientation: plan, execute, feel, and plan again from what was felt.

Pure: whoever executes tells the claim that came of it and is told what to do next.
"""

from dataclasses import dataclass, replace

import numpy as np

from wholearm_ros.estimation.claim import Claim
from wholearm_ros.model.outcomes import AT_GOAL, ELSEWHERE, LOST, UNKNOWN, UNVERIFIED
from wholearm_ros.model.scenario import CCW, CW, GoalOnEdge, Scenario, StartOnEdge

PLAN, FEEL, END = 'plan', 'feel', 'end'
MAX_ATTEMPTS = 4
FEELS = 2  # probes in a row that may leave it open where the object lies


@dataclass(frozen=True)
class Decision:
    """What to do next.

    action: PLAN one of `scenarios` (the first for which there is a plan), FEEL once more, or END;
    outcome and reason: of the end; scenarios: from what was felt, the shorter turn first.
    """

    action: str
    outcome: str = ''
    reason: str = ''
    scenarios: tuple[Scenario, ...] = ()


@dataclass(frozen=True, eq=False)
class Supervision:
    """scenario: with the goal as given; attempts: trajectories executed so far; feels: probes since
    the last conclusive one; claims: so far, in order.
    """

    scenario: Scenario
    max_attempts: int = MAX_ATTEMPTS
    attempts: int = 0
    feels: int = 0
    claims: tuple[Claim, ...] = ()

    def begin(self) -> Decision:
        """What to do first."""
        return Decision(PLAN, scenarios=(self.scenario,))

    def executed(self, claim: Claim) -> 'tuple[Supervision, Decision]':
        """After a trajectory and its probe."""
        after = replace(self, attempts=self.attempts + 1, feels=0, claims=(*self.claims, claim))
        return after._decide(claim)

    def felt(self, claim: Claim) -> 'tuple[Supervision, Decision]':
        """After a probe alone."""
        return replace(self, claims=(*self.claims, claim))._decide(claim)

    def _decide(self, claim: Claim) -> 'tuple[Supervision, Decision]':
        after = replace(self, feels=self.feels + 1)
        if claim.outcome in (AT_GOAL, LOST, UNVERIFIED):
            return after, Decision(END, claim.outcome, claim.reason)
        if claim.outcome == UNKNOWN:
            if after.feels < FEELS:
                return after, Decision(FEEL)
            return after, Decision(END, UNKNOWN, claim.reason)
        if self.attempts >= self.max_attempts:
            return after, Decision(END, ELSEWHERE, claim.reason)
        return replace(after, feels=0), Decision(PLAN, scenarios=self.from_felt(claim))

    def from_felt(self, claim: Claim) -> tuple[Scenario, ...]:
        """Scenarios that start where the object was felt; for a goal on an edge both directions,
        the shorter turn first.
        """
        start = StartOnEdge(claim.edge, claim.x)
        moved = replace(self.scenario, start=start)
        if not isinstance(moved.goal, GoalOnEdge):
            return (moved,)
        polygon = moved.object.polygon
        turn = polygon.resting_angle(moved.goal.edge) - polygon.resting_angle(claim.edge)
        ccw = float(np.mod(turn, 2.0 * np.pi))
        if ccw == 0.0:  # on its edge, but not where it should be
            return (moved,)
        order = (CCW, CW) if ccw <= np.pi else (CW, CCW)
        return tuple(replace(moved, goal=replace(moved.goal, direction=d)) for d in order)

    def no_plan(self, reason: str) -> Decision:
        """When none of the scenarios can be planned."""
        last: Claim | None = self.claims[-1] if self.claims else None
        where = f'; {last.reason}' if last else ''
        return Decision(END, last.outcome if last else UNKNOWN, f'no plan: {reason}{where}')
