"""Plan, execute in simulation, and only then offer: Phase 1 and Phase 2 as one call.

Routes come best first. Each is tried with a few ways to execute it; what survives in the nominal simulation and in all
perturbed copies is offered at once. What does not sends the search on, without the leg on which it failed.
"""
import time
from dataclasses import dataclass, replace
from itertools import product
from typing import Callable, Optional

import numpy as np

from .control.setpoints import ControlOptions
from .model.plan import NOT_EXECUTABLE, ContactPlan
from .model.scenario import Scenario
from .model.trajectory import ManipulationTrajectory
from .planning.search import BEST, SearchOptions, make_routes
from .trajectory.generate import generate
from .trajectory.options import AUTO, FRONT, REAR, ExecutionOptions
from .trajectory.verify import Verification, build_copies, run_trial


@dataclass(frozen=True)
class Request:
    """search: best or random; seed: of the random search and of the copies; transition: dwell, dynamic or auto;
    copies, level: how many perturbed copies, and how strongly perturbed; accept: least share of copies that must survive;
    candidates: trajectories to try before giving up (so that the answer does not depend on the machine);
    time_budget: [s] after which no further candidate is begun."""

    search: str = BEST
    seed: int = 0
    transition: str = AUTO
    limit: int = 5000
    copies: int = 8
    level: float = 1.0
    accept: float = 0.85
    candidates: int = 300
    time_budget: float = 60.0


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


def offer(scenario: Scenario, request: Request = Request(), controls: ControlOptions = ControlOptions(),
          progress: Callable[[str], None] = lambda line: None) -> Offer:
    """The first plan that survives, or the best of those tried if enough of its copies survive, or a reason.

    Raises ScenarioError when the start is impossible. `progress` is called with a line for people now and then.
    """
    clock = {'plan_ms': 0.0, 'generate_ms': 0.0, 'verify_ms': 0.0}
    began = time.monotonic()
    with _timed(clock, 'plan_ms'):
        routes = make_routes(scenario, SearchOptions(request.search, request.seed, request.limit))
        plan = routes.next_plan()
    first, best, tried, route = plan, _Best(), 0, 0
    copies = build_copies(scenario, request.copies, request.level, request.seed) if plan.found else ()
    while plan.found and tried < request.candidates and time.monotonic() - began < request.time_budget:
        failures = []
        for options in execution_variants(request):
            tried += 1
            with _timed(clock, 'generate_ms'):
                candidate = plan.with_execution(options.to_dict())
                trajectory = generate(scenario, candidate, options)
            with _timed(clock, 'verify_ms'):
                verification = _verify(trajectory, scenario, copies, controls, best.share)
            failures.append(_failed_leg(plan, trajectory, verification))
            if verification.survived > best.share:
                best = _Best(verification.survived, candidate, trajectory, verification)
            if best.share == 1.0 or tried >= request.candidates:
                break
        if best.share == 1.0:
            break
        route += 1
        progress(f'route {route}: {tried} candidates tried, best survives {max(best.share, 0.0):.0%} of its copies')
        with _timed(clock, 'plan_ms'):
            plan = routes.next_plan(max(set(failures), key=failures.count))
    if best.share >= request.accept:
        return _offered(best, clock, tried, request)
    return Offer(_refused(first, best, tried), None, clock, best.verification)


def execution_variants(request: Request) -> tuple:
    """Ways to execute a route, the most promising first."""
    base = ExecutionOptions()
    cages = ((REAR, 0.1), (FRONT, 0.1), (FRONT, 0.02), (REAR, 0.3), (FRONT, 0.3))
    return tuple(replace(base, velocity_finger=finger, caging_finger=side, caging_torque=torque, torque_margin=margin)
                 for margin, finger, (side, torque) in product((0.5, 3.5), (AUTO, REAR, FRONT), cages))


def _verify(trajectory, scenario, copies, controls, to_beat):
    """All copies, but no more of them than it takes to see that `to_beat` is not beaten."""
    trials = []
    for k, copy in enumerate(copies):
        trials.append(run_trial(trajectory, scenario, copy, controls))
        failed = sum(not t.success for t in trials)
        if not trials[0].success or (len(copies) - failed) / len(copies) <= to_beat:
            break
    return Verification(tuple(trials), len(copies))


def _failed_leg(plan, trajectory, verification):
    """Place of the leg on which the first failed trial left the plan; the last one when it kept to it to the end."""
    trial = next((t for t in verification.trials if not t.success), None)
    if trial is None:
        return len(plan.legs) - 1
    planned = trajectory.poses[np.minimum((trial.times / trajectory.period).astype(int), len(trajectory.poses) - 1)]
    away = np.abs(trial.configurations[:, 2] - planned[:, 2]) > 0.1
    if not away.any():
        return len(plan.legs) - 1
    pose = planned[int(np.argmax(away))]
    nearest = [np.abs(leg.configurations[:, :3] - pose).sum(axis=1).min() for leg in plan.legs]
    return int(np.argmin(nearest))


def _offered(best, clock, tried, request):
    record = {**best.verification.to_dict(), 'level': request.level, 'candidates_tried': tried}
    return Offer(best.plan, replace(best.trajectory, plan_id=best.plan.id, verification=record), clock, best.verification)


def _refused(first, best, tried):
    if not first.found:
        return first
    reason = f'no route survives: {tried} candidates tried'
    if best.plan is not None:
        reason += f', the best survives {best.share:.0%} of its copies ({"; ".join(best.verification.reasons()[:2])})'
    return replace(first, outcome=NOT_EXECUTABLE, reason=reason, path=(), legs=(), cost={})


class _timed:
    """Adds the milliseconds spent inside to an entry of a dictionary."""

    def __init__(self, clock, name):
        self.clock, self.name = clock, name

    def __enter__(self):
        self.began = time.perf_counter()

    def __exit__(self, *_):
        self.clock[self.name] += 1e3 * (time.perf_counter() - self.began)
