"""Evaluation: success rates of candidates over perturbed rollouts, with early stopping, and the
best candidate so far.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.errors import DocumentError
from wholearm_ros.model.configuration import POSE, ROTATION
from wholearm_ros.model.modes import CAGING
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.planner.stopwatch import GENERATE, VERIFY, Stopwatch
from wholearm_ros.planning.problem import PlanningProblem
from wholearm_ros.rollout.perturbed_samples import PerturbedSample, build_perturbed_samples
from wholearm_ros.rollout.verification import Verification, rollouts
from wholearm_ros.search.belief import Samples
from wholearm_ros.trajectory.execution_options import FRONT, ExecutionOptions
from wholearm_ros.trajectory.main_trajectory import generate

AWAY = 0.1  # [rad] from the planned rotation: a rollout that is further from it has left the plan


@dataclass(frozen=True, eq=False)
class Candidate:
    """A plan with one way to execute it, the trajectory made of it, and its rollouts."""

    plan: ContactPlan
    trajectory: ManipulationTrajectory
    verification: Verification

    @property
    def success_rate(self) -> float:
        """Share of its rollouts that end at the goal."""
        return self.verification.success_rate


class Evaluation:
    """Tries candidates until one is good enough.

    best: the best so far, or None; tried: how many there were.
    """

    def __init__(
        self,
        scenario: Scenario,
        request: PlanRequest,
        controls: ControlOptions,
        watch: Stopwatch,
    ) -> None:
        self.scenario, self.request, self.controls, self.watch = scenario, request, controls, watch
        self.best: Candidate | None = None
        self.tried = 0
        self._last = np.inf  # number of the candidate after which nothing better is looked for
        self._failures = np.zeros(request.samples + 1, int)  # by sample, of all candidates

    @property
    def success_rate(self) -> float:
        """Of the best so far; −1 before there is one."""
        return -1.0 if self.best is None else self.best.success_rate

    def discard_best(self) -> None:
        """Forget the best candidate, so that the search goes on as if there had been none."""
        self.best, self._last = None, np.inf

    @property
    def promising(self) -> bool:
        """Whether the best reaches the target."""
        return self.success_rate >= self.request.target_success

    @property
    def done(self) -> bool:
        """Whether the best candidate is good enough, or the improvement budget or time is spent."""
        enough = max(self.request.early_stop_success, self.request.target_success)
        return self.success_rate >= enough or self.tried >= self._last or self.watch.late()

    def try_route(self, plan: ContactPlan, executions: tuple[ExecutionOptions, ...]) -> int:
        """Try the ways to execute a route until one is good enough; returns the place of the leg on
        which most of them failed.
        """
        failed_legs: list[int] = []
        hopeless: set[ExecutionOptions] = set()  # they fail whatever is done in the caging descent
        first_caging = next(
            (k for k, leg in enumerate(plan.legs) if leg.mode == CAGING), len(plan.legs)
        )
        for options in executions:
            before_caging = replace(options, caging_finger=FRONT, caging_torque=0.0)
            if before_caging in hopeless:
                continue
            candidate = self._try(plan.with_execution(options.to_dict()), options)
            if candidate is None:
                failed_legs.append(len(plan.legs) - 1)
                continue
            failed_legs.append(_failed_leg(candidate))
            early = failed_legs[-1] < first_caging and not candidate.verification.nominal.success
            if early or first_caging == len(plan.legs):
                hopeless.add(before_caging)
            if self.done:
                break
        return max(set(failed_legs), key=failed_legs.count)

    def _try(self, plan: ContactPlan, options: ExecutionOptions) -> Candidate | None:
        """One candidate, kept when it is the best; None when no trajectory can be made of it."""
        self.tried += 1
        try:
            with self.watch.stage(GENERATE):
                trajectory = generate(self.scenario, plan, options)
        except DocumentError:  # a primitive that does not end at rest when it is made again
            return None
        with self.watch.stage(VERIFY):
            candidate = Candidate(plan, trajectory, self._verify(trajectory))
        if candidate.success_rate > self.success_rate:
            self.best = candidate
            if candidate.success_rate >= self.request.target_success:
                self._last = min(self._last, self.tried + self.request.improvement_budget)
        return candidate

    @cached_property
    def samples(self) -> tuple[PerturbedSample, ...]:
        """The nominal sample, then the perturbed ones."""
        return self._samples_of(self.scenario)

    def beliefs(self, problem: PlanningProblem) -> Samples:
        """The same for the search, whose problem may be the mirror image of the scenario."""
        samples = self._samples_of(problem.scenario)
        return Samples(problem, samples, self.request.least_success, self.controls)

    def _samples_of(self, scenario: Scenario) -> tuple[PerturbedSample, ...]:
        r = self.request
        return build_perturbed_samples(
            scenario, r.samples, r.level, r.seed, r.hand_errors, r.start_x_error
        )

    def _verify(self, trajectory: ManipulationTrajectory) -> Verification:
        """Roll out on all samples, the nominal one first, then those on which most candidates
        failed; stop as soon as the best candidate cannot be beaten, or this one cannot be given any
        more.
        """
        order = [0, *(1 + np.argsort(-self._failures[1:], kind='stable'))]
        done, asked = [], len(order)
        for k, rollout in zip(
            order, rollouts(trajectory, [self.samples[k] for k in order], self.controls)
        ):
            done.append(rollout)
            self._failures[k] += not rollout.success
            possible = (asked - sum(not r.success for r in done)) / asked
            beaten = possible <= self.success_rate or possible < self.request.least_success
            if beaten or not done[0].success:
                break
        return Verification(tuple(done), asked)


def _failed_leg(candidate: Candidate) -> int:
    """Place of the leg on which the first failed rollout left the plan; the last leg when it kept
    to the plan to the end.
    """
    legs, trajectory = candidate.plan.legs, candidate.trajectory
    rollout = next((r for r in candidate.verification.rollouts if not r.success), None)
    if rollout is None:
        return len(legs) - 1
    rows = (rollout.times / trajectory.period).astype(int)
    planned = trajectory.poses[np.minimum(rows, len(trajectory.poses) - 1)]
    away = np.abs(rollout.configurations[:, ROTATION] - planned[:, 2]) > AWAY
    if not away.any():
        return len(legs) - 1
    pose = planned[int(np.argmax(away))]
    nearest = [np.abs(leg.configurations[:, POSE] - pose).sum(axis=1).min() for leg in legs]
    return int(np.argmin(nearest))
