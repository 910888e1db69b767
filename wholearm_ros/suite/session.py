"""A session of a simulated hand with an object in it, without ROS: goal after goal, felt and tried
again, never reset.
"""

from dataclasses import replace
from types import TracebackType

import numpy as np

from wholearm_ros.control.execution import Execution
from wholearm_ros.estimation.claim import Claim, claim, kept_to_plan, unfelt_claim
from wholearm_ros.estimation.feel import Feeler, Felt
from wholearm_ros.estimation.hold import hold_to_feel
from wholearm_ros.estimation.probe_plan import probe_after
from wholearm_ros.model.outcomes import AT_GOAL, LOST, UNKNOWN, UNVERIFIED
from wholearm_ros.model.perturbation import Perturbation
from wholearm_ros.model.probe import Probe
from wholearm_ros.model.scenario import GoalOnEdge, Scenario, StartOnEdge
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.planner.legs import Leg, LegPlanner, leg_of
from wholearm_ros.planner.map_store import MapStore
from wholearm_ros.planner.supervision import END, FEEL, Supervision
from wholearm_ros.rollout.initial_state import perturbed_start
from wholearm_ros.simulation.closed_loop import RunRecord, lead
from wholearm_ros.simulation.factory import make_hand
from wholearm_ros.suite.attempts import Attempts, Motion
from wholearm_ros.suite.suite_options import SuiteOptions


class Pursuit:
    """Where the legs of a session come from: `first` for `scenario` itself, else planned, from the
    object's map where there is one.
    """

    def __init__(self, scenario: Scenario, first: Leg | None, options: SuiteOptions) -> None:
        self.scenario, self.first = scenario, first
        maps = MapStore(scenario) if options.maps else None
        self.planner = LegPlanner(options.request, maps, in_a_row=False)
        if first is not None and first.plan is not None:
            self.planner.remember(first.plan)

    def plan(self, asked: Scenario) -> Leg | None:
        """The next leg, None without a plan."""
        if asked is self.scenario:
            return self.first
        return leg_of(asked, self.planner.plan(asked))

    def happened(self, leg: Leg, success: bool) -> None:
        """Whether a leg ended at its goal, as felt."""
        self.planner.happened(leg.trajectory.plan_id, success)


class HandSession:
    """One hand with an object in it.

    options: of the hand, the control, and whether each end is felt; without a probe an outcome is
    'unverified'; start: (5,) where hand and object truly are, when that is not where the perturbed
    scenario says. Raises HardwareError when the backend is not there.
    """

    def __init__(
        self,
        scenario: Scenario,
        perturbation: Perturbation,
        options: SuiteOptions,
        start: np.ndarray | None = None,
    ) -> None:
        self.perturbation, self.options = perturbation, options
        self.feeler = Feeler(scenario)
        self.motions: list[Motion] = []
        self.tracked = False
        loop = options.loop
        self.hand = make_hand(options.backend, scenario, loop.rate, perturbation, loop.view)
        self.hand.reset(perturbed_start(scenario, self.hand.scenario) if start is None else start)

    def __enter__(self) -> 'HandSession':
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.hand.disconnect()

    def pursue(self, scenario: Scenario, pursuit: Pursuit) -> Attempts:
        """Go for the goal of `scenario`, from its start, until it is felt or nothing is left."""
        begun = len(self.motions)
        supervision = Supervision(scenario, self.options.attempts)
        decision = supervision.begin()
        told = scenario  # of the last leg, of whose goal claims are
        while decision.action != END:
            if decision.action == FEEL:
                supervision, decision = supervision.felt(self.feel(told))
                continue
            assert decision.scenario is not None
            leg = pursuit.plan(decision.scenario)
            if leg is None:
                decision = supervision.no_plan('from where the object lies')
                continue
            told = leg.scenario
            said = self._follow(leg, supervision.spent)
            if said.outcome != UNVERIFIED:
                pursuit.happened(leg, said.outcome == AT_GOAL)
            supervision, decision = supervision.executed(said, leg.stop, leg.unfelt_end)
        made = tuple(self.motions[begun:])
        return Attempts(scenario, made, decision.outcome, decision.reason)

    def pursue_faces(
        self, scenario: Scenario, faces: tuple[int, ...], pursuit: Pursuit
    ) -> tuple[Attempts, ...]:
        """Face after face, each from where the object was felt after the one before; as many as
        were begun: none is after an object that is lost, or not known where.
        """
        done: list[Attempts] = []
        start = scenario.start
        for face in faces:
            asked = replace(scenario, start=start, goal=GoalOnEdge(face)) if done else scenario
            done.append(self.pursue(asked, pursuit))
            felt = self.motions[-1].claim.felt if self.motions else None
            if done[-1].motions and (felt is None or done[-1].outcome in (LOST, UNKNOWN)):
                break
            if felt is not None:
                start = StartOnEdge(felt.best.edges[0], felt.best.x)
        return tuple(done)

    def feel(self, scenario: Scenario) -> Claim:
        """A probe alone, from the other side than the last one, if there was one."""
        angles, _ = self.hand.joints()
        last = self.motions[-1] if self.motions else None
        before = last.claim.felt if last else None
        hold = hold_to_feel(self.feeler, angles, last.trajectory if last else None, before)
        record = self._lead(hold)
        said = self._claim(record, hold.probe, scenario, before)
        self.motions.append(Motion(hold, record, said, planned=False))
        return said

    def _follow(self, leg: Leg, spent: int) -> Claim:
        """A leg, and what the probe after it, if any, says of its goal; spent: see `Motion`."""
        unfelt = leg.unfelt_end is not None
        probed = self.options.probe and not unfelt
        probe = probe_after(self.feeler, leg.trajectory) if probed else None
        trajectory = replace(leg.trajectory, probe=probe)
        record = self._lead(trajectory)
        self.tracked = kept_to_plan(self.feeler, trajectory, record.course, record.in_band)
        if unfelt:
            said = unfelt_claim(record.reason or record.deviated)
        else:
            said = self._claim(record, probe, leg.scenario)
        self.motions.append(Motion(trajectory, record, said, spent=spent))
        return said

    def _lead(self, trajectory: ManipulationTrajectory) -> RunRecord:
        loop = self.options.loop
        execution = Execution(trajectory, loop.controls, loop.settle, trajectory.probe)
        return lead(self.hand, execution, loop, self.perturbation)

    def _claim(
        self,
        record: RunRecord,
        probe: Probe | None,
        scenario: Scenario,
        before: Felt | None = None,
    ) -> Claim:
        if probe is None:
            return Claim(UNVERIFIED, 'no probe was made')
        if record.reason:
            return Claim(UNKNOWN, f'stopped: {record.reason}')
        felt = self.feeler.feel(probe, np.array(record.pairs), record.interrupted, before)
        return claim(self.feeler, scenario, felt, self.tracked)
