"""Plan, execute in simulation, and only then offer: Phase 1 and Phase 2 as one call.

Routes come best first. Each is tried with a few ways to execute it; what survives in the nominal simulation and in all
perturbed copies is offered at once. What does not sends the search on, without the leg on which it failed.
"""

import time
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Callable, Optional

import numpy as np

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.errors import DocumentError
from wholearm_ros.model.plan import NOT_EXECUTABLE, ContactPlan
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import CAGING, DWELL, DYNAMIC, ManipulationTrajectory
from wholearm_ros.planning.primitive_tree import STYLES
from wholearm_ros.planning.routes import BEST, PrimitiveRoutes, SearchOptions, make_routes
from wholearm_ros.rollout.perturbed_samples import build_perturbed_samples
from wholearm_ros.rollout.verification import Verification, run_trials, run_trials_at_once, verify
from wholearm_ros.trajectory.execution_options import AUTO, FRONT, REAR, ExecutionOptions
from wholearm_ros.trajectory.main_trajectory import generate

CAGES = (
    (FRONT, 0.1),
    (REAR, 0.1),
    (FRONT, 0.02),
    (REAR, 0.3),
    (FRONT, 0.3),
)  # velocity finger, torque [N m] in caging

DYNAMICS = (
    (0.3, 0.08),
    (0.7, 0.08),
    (2.0, 0.08),
    (0.3, 0.04),
    (0.7, 0.04),
    (2.0, 0.04),
    (0.3, 0.14),
    (2.0, 0.14),
)
PLENTY = 0.9  # share of copies that survive beyond which nothing better is looked for
BETTERING = (
    30  # candidates to try for a better one when the first that is good enough has been found
)
HARDER, HARDER_COPIES = (
    (2.0, 3.0),
    4,
)  # levels, and copies at each, by which ways that all survive are told apart


@dataclass(frozen=True)
class Request:
    """search: best or random; seed: of the random search and of the copies; transition: dwell, dynamic or auto;
    copies, level: how many perturbed copies, and how strongly perturbed; good: share of them that must survive for the search
    to end soon; accept: least share with which the best is offered when nothing good was found;
    candidates: trajectories to try before giving up on the arcs, and again on the moves (so that the answer does not depend
    on the machine); moves: how many dynamic moves may be simulated where arcs alone do not do, 0 for none;
    time_budget: [s] after which no further candidate is begun."""

    search: str = BEST
    seed: int = 0
    transition: str = AUTO
    limit: int = SearchOptions.limit
    copies: int = 12
    level: float = 1.4
    good: float = 0.8
    accept: float = 0.65
    candidates: int = 100
    moves: int = SearchOptions.move_limit
    time_budget: float = 180.0


@dataclass(frozen=True, eq=False)
class Offer:
    """plan: always there, with a route or the reason why not; trajectory: verified, or None;
    timings: plan_ms, generate_ms, verify_ms; verification: of the trajectory, or of the best that was not good enough."""

    plan: ContactPlan
    trajectory: Optional[ManipulationTrajectory]
    timings: dict
    verification: Optional[Verification] = None


@dataclass(eq=False)
class _Best:
    """The best candidate so far."""

    share: float = -1.0
    plan: ContactPlan = None
    trajectory: ManipulationTrajectory = None
    verification: Verification = None


def offer(
    scenario: Scenario,
    request: Request = Request(),
    controls: ControlOptions = ControlOptions(),
    progress: Callable[[str], None] = lambda line: None,
) -> Offer:
    """The first plan that survives, or the best of those tried if enough of its copies survive, or a reason.

    Raises ScenarioError when the start is impossible. `progress` is called with a line for people now and then.
    """
    options = SearchOptions(request.search, request.seed, request.limit, request.moves)
    trying = _Trying(scenario, request, controls, progress)
    first = trying.routes_of(make_routes, options, execution_variants(request))
    for style in STYLES if request.moves else ():
        if trying.best.share < request.good:
            trying.routes_of(
                partial(PrimitiveRoutes, style=style, stop=trying.late), options, move_variants()
            )
    if trying.best.share >= request.accept:
        trying.sharpen()
        return trying.offered()
    return Offer(trying.refused(first), None, trying.clock, trying.best.verification)


class _Trying:
    """Candidates tried so far, the best of them, and the milliseconds they took."""

    def __init__(self, scenario, request, controls, progress):
        self.scenario, self.request, self.controls, self.progress = (
            scenario,
            request,
            controls,
            progress,
        )
        self.clock = {'plan_ms': 0.0, 'generate_ms': 0.0, 'verify_ms': 0.0}
        self.best, self.tried, self._began = _Best(), 0, time.monotonic()
        self._copies, self._falls = (
            None,
            np.zeros(request.copies + 1, int),
        )  # falls: how many candidates each copy let down
        self._enough = np.inf

    def routes_of(self, source, options, variants) -> ContactPlan:
        """Try route after route until one survives or there are no more; returns the first one."""
        budget = self.tried + self.request.candidates
        with _timed(self.clock, 'plan_ms'):
            routes = source(self.scenario, options)
            first = plan = routes.next_plan()
        while plan.found and self.tried < budget and not self.late():
            failed = self._try(plan, variants[: budget - self.tried])
            if self._done():
                break
            self.progress(
                f'{self.tried} candidates tried, the best survives {max(self.best.share, 0.0):.0%} of its copies'
            )
            with _timed(self.clock, 'plan_ms'):
                plan = routes.next_plan(failed)
        return first

    def late(self) -> bool:
        """Whether the time budget is spent."""
        return time.monotonic() - self._began > self.request.time_budget

    def _done(self):
        return self.best.share >= max(PLENTY, self.request.good) or self.tried >= self._enough

    def _try(self, plan, variants):
        """All variants of a route, until one survives; returns the leg on which most of them failed."""
        failures, hopeless, release = (
            [],
            set(),
            _first_caging(plan),
        )  # hopeless: whatever comes of caging
        for options in variants:
            before_caging = replace(options, caging_finger=FRONT, caging_torque=0.0)
            if before_caging in hopeless:
                continue
            self.tried += 1
            candidate = plan.with_execution(options.to_dict())
            try:
                with _timed(self.clock, 'generate_ms'):
                    trajectory = generate(self.scenario, candidate, options)
            except DocumentError:  # a move that does not end at rest when it is made again
                failures.append(len(plan.legs) - 1)
                continue
            with _timed(self.clock, 'verify_ms'):
                verification = self._verify(trajectory)
            failures.append(_failed_leg(plan, trajectory, verification))
            if (
                verification.survived > self.best.share
                and verification.survived >= self.request.good
            ):
                self._enough = min(self._enough, self.tried + BETTERING)
            if (
                release == len(plan.legs)
                or failures[-1] < release
                and not verification.nominal.success
            ):
                hopeless.add(before_caging)
            if verification.survived > self.best.share:
                self.best = _Best(verification.survived, candidate, trajectory, verification)
            if self._done():
                break
        return max(set(failures), key=failures.count)

    def _verify(self, trajectory):
        """All copies, but no more of them than it takes to see that the best so far is not beaten, or that this one cannot be
        offered; those that most candidates fell for come first, after the nominal one."""
        if self._copies is None:
            self._copies = build_perturbed_samples(
                self.scenario, self.request.copies, self.request.level, self.request.seed
            )
        order = [0, *(1 + np.argsort(-self._falls[1:], kind='stable'))]
        trials, asked = [], len(self._copies)
        for k, trial in zip(
            order,
            run_trials(trajectory, self.scenario, [self._copies[k] for k in order], self.controls),
        ):
            trials.append(trial)
            self._falls[k] += not trial.success
            share = (asked - sum(not t.success for t in trials)) / asked
            if not trials[0].success or share <= self.best.share or share < self.request.accept:
                break
        return Verification(tuple(trials), asked)

    def sharpen(self):
        """Of the ways to make the transitions where the torque ranges part, take the one that the largest errors leave
        alive: the start and size of the extra torque are found, not set (the paper's future work (ii))."""
        parted = any(not t['condition_2'] for t in self.best.trajectory.transitions)
        chosen = ExecutionOptions.from_dict(self.best.plan.execution)
        ways = [
            replace(
                chosen,
                transition=way.transition,
                extra_torque=way.extra_torque,
                dynamic_lead=way.dynamic_lead,
            )
            for way in _transitions(self.request.transition)
        ]
        if not parted or len(ways) < 2:
            return
        with _timed(self.clock, 'verify_ms'):
            harder = [
                copy
                for level in HARDER
                for copy in build_perturbed_samples(
                    self.scenario, HARDER_COPIES, level, self.request.seed
                )[1:]
            ]
            scored = []
            for options in ways:
                plan = self.best.plan.with_execution(options.to_dict())
                known = plan.id == self.best.plan.id
                trajectory = (
                    self.best.trajectory if known else generate(self.scenario, plan, options)
                )
                alive = sum(
                    t.success
                    for t in run_trials_at_once(trajectory, self.scenario, harder, self.controls)
                )
                scored.append((alive, -len(scored), plan, trajectory))
                if alive == len(harder):
                    break  # no way does better
        for alive, _, plan, trajectory in sorted(scored, key=lambda s: s[:2], reverse=True):
            if plan.id == self.best.plan.id:
                return
            verification = verify(trajectory, self.scenario, self._copies, self.controls)
            if verification.survived >= self.best.share:
                self.best = _Best(verification.survived, plan, trajectory, verification)
                return

    def offered(self) -> Offer:
        best = self.best
        record = {
            **best.verification.to_dict(),
            'level': self.request.level,
            'candidates_tried': self.tried,
        }
        return Offer(
            best.plan,
            replace(best.trajectory, plan_id=best.plan.id, verification=record),
            self.clock,
            best.verification,
        )

    def refused(self, first) -> ContactPlan:
        if self.best.plan is None:
            return first
        nearest = (
            f'fewer than {self.request.accept:.0%} of its perturbed copies end at the goal'
            if self.best.verification.nominal.success
            else 'as told, it does not end at the goal'
        )
        reason = (
            f'no route survives: {self.tried} candidates tried; of the best one, {nearest} '
            f'({"; ".join(self.best.verification.reasons()[:2])})'
        )
        return replace(first, outcome=NOT_EXECUTABLE, reason=reason, path=(), legs=(), cost={})


def execution_variants(request: Request) -> tuple:
    """Ways to execute a route, the most promising first; a dynamic transition needs one velocity finger on both its sides.

    Where all of these fail another route does better than another way: of 21 offered plans that were looked at none had the
    front finger velocity-controlled throughout, or a dynamic transition."""
    fingers, margins = (
        ((FRONT, REAR, AUTO), (0.5, 3.5))
        if request.transition == DYNAMIC
        else ((AUTO, REAR), (0.5,))
    )
    transitions = _transitions(DYNAMIC if request.transition == DYNAMIC else DWELL)
    return tuple(
        replace(
            transition,
            velocity_finger=finger,
            caging_finger=side,
            caging_torque=torque,
            torque_margin=margin,
        )
        for transition, margin, finger, (side, torque) in product(
            transitions, margins, fingers, CAGES
        )
    )


def _transitions(wanted):
    """What to do where the torque ranges part: stop (dwell), or start the extra torque early enough (dynamic)."""
    dwell = (ExecutionOptions(transition=DWELL),)
    dynamic = tuple(
        ExecutionOptions(transition=DYNAMIC, extra_torque=extra, dynamic_lead=lead)
        for extra, lead in DYNAMICS
    )
    return {DWELL: dwell, DYNAMIC: dynamic, AUTO: (*dwell, *dynamic[:1])}[wanted]


def move_variants() -> tuple:
    """Ways to execute a route of dynamic moves: only its caging leaves a choice."""
    return tuple(
        ExecutionOptions(caging_finger=side, caging_torque=torque) for side, torque in CAGES
    )


def _first_caging(plan):
    return next((k for k, leg in enumerate(plan.legs) if leg.mode == CAGING), len(plan.legs))


def _failed_leg(plan, trajectory, verification):
    """Place of the leg on which the first failed trial left the plan; the last one when it kept to it to the end."""
    trial = next((t for t in verification.trials if not t.success), None)
    if trial is None:
        return len(plan.legs) - 1
    planned = trajectory.poses[
        np.minimum((trial.times / trajectory.period).astype(int), len(trajectory.poses) - 1)
    ]
    away = np.abs(trial.configurations[:, 2] - planned[:, 2]) > 0.1
    if not away.any():
        return len(plan.legs) - 1
    pose = planned[int(np.argmax(away))]
    nearest = [np.abs(leg.configurations[:, :3] - pose).sum(axis=1).min() for leg in plan.legs]
    return int(np.argmin(nearest))


class _timed:
    """Adds the milliseconds spent inside to an entry of a dictionary."""

    def __init__(self, clock, name):
        self.clock, self.name = clock, name

    def __enter__(self):
        self.began = time.perf_counter()

    def __exit__(self, *_):
        self.clock[self.name] += 1e3 * (time.perf_counter() - self.began)
