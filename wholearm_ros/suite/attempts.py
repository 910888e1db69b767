"""Attempts without ROS: execute a trajectory, feel its end, plan again from what was felt."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from wholearm_ros.control.execution import Execution
from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.estimation.claim import KEPT, UNKNOWN, UNVERIFIED, Claim, claim
from wholearm_ros.estimation.feel import Feeler
from wholearm_ros.estimation.hold import hold_trajectory
from wholearm_ros.estimation.probe_plan import probe_after
from wholearm_ros.model.orientation import goal_rotation
from wholearm_ros.model.perturbation import Perturbation
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.planner.supervision import END, FEEL, Supervision
from wholearm_ros.rollout.initial_state import perturbed_start
from wholearm_ros.simulation.closed_loop import RunRecord, lead
from wholearm_ros.simulation.hand import HandBackend, make_hand

SETTLE = 0.5  # [s] of holding before the probe
ON_EDGE = 0.03  # [rad] within which the object truly lies on an edge

PlanAgain = Callable[[Scenario], ManipulationTrajectory | None]


@dataclass(frozen=True, eq=False)
class Attempts:
    """A run of one or more attempts.

    records: of every trajectory and every probe alone, in order; trajectories: what each followed;
    claims: what was said after each; attempts: how many of them were trajectories; claim, outcome,
    reason: of the end.
    """

    records: tuple
    trajectories: tuple
    claims: tuple
    attempts: int
    claim: Claim
    outcome: str
    reason: str

    @property
    def last(self) -> RunRecord:
        """The last record, on whose end the truth is judged, its rotations near the goal's."""
        record = self.records[-1]
        turns = np.round((goal_rotation(record.truth) - record.poses[-1, 2]) / (2.0 * np.pi))
        if len(self.records) == 1 or turns == 0.0:
            return record
        return replace(record, poses=record.poses + [0.0, 0.0, 2.0 * np.pi * turns])

    def to_dict(self) -> dict:
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
    backend: str = 'pybullet',
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
        self.records: list[RunRecord] = []
        self.trajectories: list[ManipulationTrajectory] = []
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
        claims = supervision.claims
        return Attempts(
            tuple(self.records),
            tuple(self.trajectories),
            claims,
            supervision.attempts,
            claims[-1],
            decision.outcome,
            decision.reason,
        )

    def execute(self, trajectory: ManipulationTrajectory) -> Claim:
        """A trajectory, and what its probe says."""
        record, held = self._lead(trajectory)
        self.tracked = record.deviation < KEPT
        return self._claim(record, held)

    def feel(self) -> Claim:
        """A probe alone, from the other side than the last one."""
        before = self.trajectories[-1]
        held = 1 - before.segments[-1].velocity_finger
        angles, _ = self.hand.joints()
        weights = self.feeler.model.world.finger_moment
        record, held_probe = self._lead(hold_trajectory(angles, weights, before.poses[-1], held))
        return self._claim(record, held_probe)

    def _lead(self, trajectory: ManipulationTrajectory) -> tuple:
        probe = probe_after(self.feeler, trajectory) if self.probe else None
        seconds = self.controls.ramp + trajectory.duration + SETTLE
        execution = Execution(trajectory, self.controls, SETTLE, probe)
        steps = int(np.ceil(seconds / self.hand.period))
        record = lead(self.hand, execution, self.controls, steps, self.perturbation)
        self.records.append(record)
        self.trajectories.append(trajectory)
        return record, probe

    def _claim(self, record: RunRecord, probe) -> Claim:
        if probe is None:
            return Claim(UNVERIFIED, 'no probe was made')
        if record.reason:
            return Claim(UNKNOWN, f'stopped: {record.reason}')
        felt = self.feeler.feel(probe, np.array(record.pairs), record.interrupted)
        return claim(self.feeler, self.scenario, felt, self.tracked)


def true_rest(record: RunRecord) -> tuple:
    """(edge, x [m]) on which the object truly lies at the end of a record; edge None for none."""
    polygon, pose = record.truth.object.polygon, record.poses[-1]
    angles = np.array([polygon.resting_angle(k) for k in range(len(polygon.vertices))])
    off = np.abs((pose[2] - angles + np.pi) % (2.0 * np.pi) - np.pi)
    low, high = record.truth.palm.vertices[[0, -1], 0]
    lies = off.min() < ON_EDGE and low <= pose[0] <= high and pose[1] > 0.0
    return (int(np.argmin(off)) if lies else None), float(pose[0])
