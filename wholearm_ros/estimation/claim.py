"""Claims: whether what was felt is the goal. The object's true pose plays no part."""

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from wholearm_ros.estimation.course import went_as_planned
from wholearm_ros.estimation.feel import Candidate, Feeler, Felt, fits
from wholearm_ros.model.goal import goal_region
from wholearm_ros.model.outcomes import (
    AT_GOAL,
    CLAIMS,
    ELSEWHERE,
    LOST,
    LYING,
    NOTHING,
    UNKNOWN,
    UNVERIFIED,
)
from wholearm_ros.model.probe import Probe
from wholearm_ros.model.scenario import Scenario, StartOnEdge
from wholearm_ros.model.trajectory import ManipulationTrajectory

# Probability that is enough for what the plan led to, when the fingers kept to it: by touch alone
# all else together is less likely, and such runs hardly ever end elsewhere.
LIKELY = 0.5


@dataclass(frozen=True)
class Claim:
    """outcome: one of OUTCOMES, or unverified; reason: for people; felt: None when no probe was
    made.
    """

    outcome: str
    reason: str
    felt: Felt | None = None

    @property
    def told(self) -> Candidate | None:
        """What the object is said to lie on, None when no edge is told."""
        if self.felt is None or (self.felt.kind != LYING and self.outcome != AT_GOAL):
            return None
        return self.felt.best

    @property
    def sure(self) -> bool:
        """Whether an edge is told."""
        return self.told is not None

    @property
    def edge(self) -> int:
        """The felt edge, −1 when none is sure."""
        return -1 if self.told is None else self.told.edges[0]

    @property
    def x(self) -> float:
        """[m] the felt x, NaN when none is sure."""
        return float('nan') if self.told is None else self.told.x

    @property
    def place(self) -> StartOnEdge | None:
        """Where the object surely lies, None when that is not known."""
        if self.outcome not in (AT_GOAL, ELSEWHERE) or not self.sure or not np.isfinite(self.x):
            return None
        return StartOnEdge(self.edge, self.x)

    def to_dict(self) -> dict[str, Any]:
        """For documents."""
        told = self.told
        return {
            'claimed': self.outcome,
            'claim_reason': self.reason,
            'felt_edge': told and told.edges[0],
            'felt_edges': list(told.edges) if told else [],
            'felt_x': _finite(self.x),
            'felt_x_deviation': told and _finite(told.x_deviation),
            'felt_probability': told and told.probability,
        }

    @classmethod
    def from_dict(cls, told: dict[str, str]) -> 'Claim':
        """Of texts as a goal's result has them: what `to_dict` tells, '' for None; what is damaged
        is unknown.
        """
        try:
            edges = tuple(int(edge) for edge in json.loads(told.get('felt_edges') or '[]'))
            x = float(told.get('felt_x') or 'nan')
            outcome, reason = told['claimed'], told.get('claim_reason', '')
        except (ValueError, TypeError, KeyError) as error:
            return cls(UNKNOWN, f'a claim that cannot be read: {error!r}')
        if outcome not in CLAIMS:
            return cls(UNKNOWN, f'a claim that cannot be read: {outcome!r}')
        if not edges:
            return cls(outcome, reason)
        candidate = Candidate(edges, 0, x, float('nan'), float('nan'), float('nan'), 1.0)
        return cls(outcome, reason, Felt(LYING, (candidate,)))


def claim(feeler: Feeler, scenario: Scenario, felt: Felt, tracked: bool) -> Claim:
    """What may be said of the goal of `scenario`.

    tracked: whether the fingers kept to the plan, see `kept_to_plan`; only then is one of several
    edges that feel alike taken for the one at which the plan ends.
    """
    if felt.kind == NOTHING:
        return Claim(LOST, 'nothing in the hand', felt)
    if felt.kind != LYING:
        if tracked and felt.candidates and fits(felt.best) and felt.best.probability > LIKELY:
            best = felt.best
            if any(not _missing(feeler, scenario, e, best.segment, best.x) for e in best.edges):
                return Claim(AT_GOAL, f'felt, as planned, on edge {best.edges[0]}', felt)
        return Claim(UNKNOWN, felt.describe(), felt)
    best = felt.best
    fitting = [
        edge for edge in best.edges if not _missing(feeler, scenario, edge, best.segment, best.x)
    ]
    if not fitting:
        missing = _missing(feeler, scenario, best.edges[0], best.segment, best.x)
        return Claim(ELSEWHERE, f'felt {felt.describe()}: {missing}', felt)
    if len(best.edges) > 1 and not tracked:
        reason = (
            f'felt up to symmetry {felt.describe()}; the fingers did not go the way they go when '
            'the object arrives, so it may be any of them'
        )
        return Claim(UNKNOWN, reason, felt)
    if len(best.edges) > 1:
        reason = (
            f'felt up to symmetry {felt.describe()}; the fingers went the way they go when it '
            'arrives'
        )
        return Claim(AT_GOAL, reason, felt)
    return Claim(AT_GOAL, f'felt {felt.describe()}', felt)


def unfelt_claim(deviated: str) -> Claim:
    """Of a slide whose end is not felt (`ContactPlan.unfelt_end`); deviated: why it was stopped, or
    what the monitor says of the fingers, '' for nothing.
    """
    if deviated:
        return Claim(UNKNOWN, f'not felt yet, and the fingers deviated: {deviated}')
    return Claim(UNVERIFIED, 'led along the palm, to be felt after the turn that follows')


def kept_to_plan(
    feeler: Feeler, trajectory: ManipulationTrajectory, course: np.ndarray, in_band: bool
) -> bool:
    """Whether the fingers kept to the plan.

    course (m, 2) [rad], in_band: see `Execution`. For an object with edges that feel alike the way
    counts: the band leaves it open whether the object slipped back by an edge.
    """
    if feeler.symmetric:
        return went_as_planned(course, trajectory.courses, trajectory.strayed)
    return in_band


def reported_claim(
    feeler: Feeler,
    scenario: Scenario,
    probe: Probe | None,
    said: dict[str, str],
    tracked: bool,
    before: Felt | None = None,
) -> Claim:
    """The claim from what the mode switcher says after a probe: texts `pairs` (JSON, '' when none
    was begun) and `interrupted`; before: see `Feeler.feel`.
    """
    try:
        pairs = np.array(json.loads(said.get('pairs') or '[]'), float).reshape(-1, 2)
    except ValueError as error:
        return Claim(UNKNOWN, f'what the probe measured cannot be read: {error}')
    if probe is None or not said.get('pairs'):
        return Claim(
            UNVERIFIED, 'unverified: the trajectory was led to its end, and no probe was made'
        )
    felt = feeler.feel(probe, pairs, said.get('interrupted', ''), before)
    return claim(feeler, scenario, felt, tracked)


def reported_as_kept(
    feeler: Feeler, trajectory: ManipulationTrajectory, said: dict[str, str]
) -> bool:
    """`kept_to_plan` from what the mode switcher says: texts `course` (JSON) and `in band`; what
    cannot be read was not kept to.
    """
    try:
        course = np.array(json.loads(said.get('course') or '[]'), float).reshape(-1, 2)
        return kept_to_plan(feeler, trajectory, course, said.get('in band') == str(True))
    except ValueError:
        return False


def _finite(number: float) -> float | None:
    return number if np.isfinite(number) else None


def _missing(feeler: Feeler, scenario: Scenario, edge: int, segment: int, x: float) -> str:
    """What of an object on an edge at x is not at the goal; '' when nothing is."""
    resting, region = feeler.model.resting(edge, segment), goal_region(scenario)
    if not np.isfinite(x):
        return 'its x is not known'
    pose = resting.pose_at((x - resting.pose[0]) / resting.along[0])
    pose[2] += 2.0 * np.pi * np.round((region.rotation - pose[2]) / (2.0 * np.pi))
    return '; '.join(region.missing(pose))
