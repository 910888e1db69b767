"""Attempts without ROS: execute a trajectory, feel its end, plan again from what was felt."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wholearm_ros.control.execution import Execution
from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.estimation.claim import Claim, claim, kept_to_plan
from wholearm_ros.estimation.feel import Feeler
from wholearm_ros.estimation.hold import hold_after
from wholearm_ros.estimation.probe_plan import probe_after
from wholearm_ros.model.backends import DEFAULT_BACKEND
from wholearm_ros.model.modes import PROBING
from wholearm_ros.model.orientation import goal_rotation
from wholearm_ros.model.outcomes import UNKNOWN, UNVERIFIED
from wholearm_ros.model.perturbation import Perturbation
from wholearm_ros.model.probe import Probe
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.planner.supervision import END, FEEL, Supervision
from wholearm_ros.rollout.initial_state import perturbed_start
from wholearm_ros.simulation.closed_loop import RunRecord, lead
from wholearm_ros.simulation.factory import make_hand
from wholearm_ros.simulation.hand import HandBackend

SETTLE = 0.5  # [s] of holding before the probe
ON_EDGE = 0.03  # [rad] within which the object truly lies on an edge

PlanAgain = Callable[[Scenario], ManipulationTrajectory | None]


@dataclass(frozen=True, eq=False)
class Motion:
    """What the hand did between two decisions.

    trajectory: what it followed; record: of that and of the probe after it; claim: what was said
    then; planned: whether the trajectory was one of a plan, not only the hold before a probe alone.
    """

    trajectory: ManipulationTrajectory
    record: RunRecord
    claim: Claim
    planned: bool = True

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
    """A run of one or more attempts: its motions in order; outcome, reason: of the end."""

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
        return self.motions[-1].claim

    @property
    def last(self) -> RunRecord:
        """The last record, on whose end the truth is judged, its rotations near the goal's."""
        record = self.motions[-1].record
        turns = np.round((goal_rotation(record.truth) - record.poses[-1, 2]) / (2.0 * np.pi))
        if len(self.motions) == 1 or turns == 0.0:
            return record
        return replace(record, poses=record.poses + [0.0, 0.0, 2.0 * np.pi * turns])

    def first(self, attempts: int) -> 'Attempts':
        """The same run as it would have been with at most so many attempts."""
        begun = np.cumsum([motion.planned for motion in self.motions])
        kept = tuple(m for m, k in zip(self.motions, begun, strict=True) if k <= attempts)
        if len(kept) == len(self.motions):
            return self
        return Attempts(kept, kept[-1].claim.outcome, kept[-1].claim.reason)

    def to_dict(self) -> dict[str, Any]:
        """What a suite's draw tells of it."""
        edge, x = true_rest(self.last)
        return {
            'claimed': self.outcome,
            'claim_reason': self.reason,
            **{k: v for k, v in self.claim.to_dict().items() if k.startswith('felt')},
            'true_edge': edge,
            'true_x': x,
            'attempts': self.attempts,
        }


def run_attempts(
    scenario: Scenario,
    trajectory: ManipulationTrajectory,
    perturbation: Perturbation,
    plan_again: PlanAgain,
    max_attempts: int = 1,
    probe: bool = True,
    backend: str = DEFAULT_BACKEND,
    rate: float = 1000.0,
    controls: ControlOptions = ControlOptions(),
    feeler: Feeler | None = None,
    view: bool = False,
    start: np.ndarray | None = None,
) -> Attempts:
    """Execute `trajectory`, feel, and go on until it is felt at the goal or nothing is left.

    plan_again: a verified trajectory of a scenario, or None; probe: without it the outcome is
    'unverified'; feeler: of the object, built here when not given; start: (5,) where hand
    and object truly are, when that is not where the perturbed scenario says.
    """
    feeler = feeler or Feeler(scenario)
    hand = make_hand(backend, scenario, rate=rate, perturbation=perturbation, view=view)
    try:
        hand.reset(perturbed_start(scenario, hand.scenario) if start is None else start)
        session = _Session(hand, scenario, perturbation, controls, feeler, probe)
        return session.run(trajectory, plan_again, max_attempts)
    finally:
        hand.disconnect()


class _Session:
    """One hand with an object in it, attempt after attempt."""

    def __init__(
        self,
        hand: HandBackend,
        scenario: Scenario,
        perturbation: Perturbation,
        controls: ControlOptions,
        feeler: Feeler,
        probe: bool,
    ) -> None:
        self.hand, self.scenario, self.perturbation = hand, scenario, perturbation
        self.controls, self.feeler, self.probe = controls, feeler, probe
        self.motions: list[Motion] = []
        self.tracked = False

    def run(
        self, trajectory: ManipulationTrajectory, plan_again: PlanAgain, max_attempts: int
    ) -> Attempts:
        supervision = Supervision(self.scenario, max_attempts)
        supervision, decision = supervision.executed(self.execute(trajectory))
        while decision.action != END:
            if decision.action == FEEL:
                supervision, decision = supervision.felt(self.feel())
                continue
            found = (plan_again(scenario) for scenario in decision.scenarios)
            again = next((t for t in found if t is not None), None)
            if again is None:
                decision = supervision.no_plan('from where the object lies')
                continue
            supervision, decision = supervision.executed(self.execute(again))
        return Attempts(tuple(self.motions), decision.outcome, decision.reason)

    def execute(self, trajectory: ManipulationTrajectory) -> Claim:
        """A trajectory, and what its probe says."""
        return self._lead(trajectory, planned=True)

    def feel(self) -> Claim:
        """A probe alone, from the other side than the last one."""
        angles, _ = self.hand.joints()
        weights = self.feeler.model.world.finger_moment
        hold = hold_after(self.motions[-1].trajectory, angles, weights)
        return self._lead(hold, planned=False)

    def _lead(self, trajectory: ManipulationTrajectory, planned: bool) -> Claim:
        probe = probe_after(self.feeler, trajectory) if self.probe else None
        seconds = self.controls.ramp + trajectory.duration + SETTLE
        execution = Execution(trajectory, self.controls, SETTLE, probe)
        steps = int(np.ceil(seconds / self.hand.period))
        record = lead(self.hand, execution, self.controls, steps, self.perturbation)
        if planned:
            self.tracked = kept_to_plan(self.feeler, trajectory, record.course, record.in_band)
        said = self._claim(record, probe)
        self.motions.append(Motion(trajectory, record, said, planned))
        return said

    def _claim(self, record: RunRecord, probe: Probe | None) -> Claim:
        if probe is None:
            return Claim(UNVERIFIED, 'no probe was made')
        if record.reason:
            return Claim(UNKNOWN, f'stopped: {record.reason}')
        felt = self.feeler.feel(probe, np.array(record.pairs), record.interrupted)
        return claim(self.feeler, self.scenario, felt, self.tracked)


def true_rest(record: RunRecord) -> tuple[int | None, float]:
    """(edge, x [m]) on which the object truly lies at the end of a record; edge None for none."""
    polygon, pose = record.truth.object.polygon, record.poses[-1]
    angles = np.array([polygon.resting_angle(k) for k in range(len(polygon.vertices))])
    off = np.abs((pose[2] - angles + np.pi) % (2.0 * np.pi) - np.pi)
    low, high = record.truth.palm.vertices[[0, -1], 0]
    lies = off.min() < ON_EDGE and low <= pose[0] <= high and pose[1] > 0.0
    return (int(np.argmin(off)) if lies else None), float(pose[0])
