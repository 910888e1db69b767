"""What a hand did for a goal, attempt after attempt, and what was said and what is true of it."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wholearm_ros.estimation.claim import Claim
from wholearm_ros.model.modes import PROBING
from wholearm_ros.model.orientation import goal_rotation
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.simulation.closed_loop import RunRecord

ON_EDGE = 0.03  # [rad] within which the object truly lies on an edge


@dataclass(frozen=True, eq=False)
class Motion:
    """What the hand did between two decisions.

    trajectory: what it followed; record: of that and of the probe after it; claim: what was said
    then; planned: whether the trajectory was one of a plan, not only the hold before a probe alone;
    spent: attempts before it, not counting those that arrived at a stop on the way.
    """

    trajectory: ManipulationTrajectory
    record: RunRecord
    claim: Claim
    planned: bool = True
    spent: int = 0

    @property
    def before_probe(self) -> RunRecord:
        """The record up to its probe; all of it when there was none."""
        record = self.record
        if PROBING not in record.modes:
            return record
        end = record.modes.index(PROBING)
        rows = ('times', 'angles', 'velocities', 'efforts', 'poses', 'object_velocities', 'modes')
        return replace(record, **{name: getattr(record, name)[:end] for name in rows})

    @property
    def probing_time(self) -> float:
        """[s] that the probe took."""
        return float(self.record.time_in_modes().get(PROBING, 0.0))


@dataclass(frozen=True, eq=False)
class Attempts:
    """What was done for the goal of `scenario`: motions in order, none when there was no plan;
    outcome, reason: of the end.
    """

    scenario: Scenario
    motions: tuple[Motion, ...]
    outcome: str
    reason: str

    @property
    def attempts(self) -> int:
        """How many plans were executed."""
        return sum(motion.planned for motion in self.motions)

    @property
    def claim(self) -> Claim:
        """What was said last."""
        return self.motions[-1].claim if self.motions else Claim(self.outcome, self.reason)

    @property
    def last(self) -> RunRecord:
        """The last record, on whose end the truth is judged: the true object with this goal, and
        after several motions with its rotations near the goal's.
        """
        record = self.motions[-1].record
        truth = replace(record.truth, start=self.scenario.start, goal=self.scenario.goal)
        if len(self.motions) == 1:
            return replace(record, truth=truth)
        turns = np.round((goal_rotation(truth) - record.poses[-1, 2]) / (2.0 * np.pi))
        return replace(record, truth=truth, poses=record.poses + [0.0, 0.0, 2.0 * np.pi * turns])

    def first(self, attempts: int) -> 'Attempts':
        """The same run as it would have been with at most so many attempts."""
        for place, motion in enumerate(self.motions):
            if motion.planned and motion.spent >= attempts:
                last = self.motions[place - 1].claim
                return Attempts(self.scenario, self.motions[:place], last.outcome, last.reason)
        return self

    def to_dict(self) -> dict[str, Any]:
        """What a suite's draw tells of it."""
        edge, x = true_rest(self.last) if self.motions else (None, None)
        return {
            'claimed': self.outcome,
            'claim_reason': self.reason,
            **{k: v for k, v in self.claim.to_dict().items() if k.startswith('felt')},
            'true_edge': edge,
            'true_x': x,
            'attempts': self.attempts,
        }


def true_rest(record: RunRecord) -> tuple[int | None, float]:
    """(edge, x [m]) on which the object truly lies at the end of a record; edge None for none."""
    polygon, pose = record.truth.object.polygon, record.poses[-1]
    angles = np.array([polygon.resting_angle(k) for k in range(len(polygon.vertices))])
    off = np.abs((pose[2] - angles + np.pi) % (2.0 * np.pi) - np.pi)
    low, high = record.truth.palm.vertices[[0, -1], 0]
    lies = off.min() < ON_EDGE and low <= pose[0] <= high and pose[1] > 0.0
    return (int(np.argmin(off)) if lies else None), float(pose[0])
