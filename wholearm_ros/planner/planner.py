"""Plan, execute in simulation, and only then offer: Phase 1 and Phase 2 as one call.

Routes come best first. Each is tried in a few ways; what succeeds in the nominal rollout and in nearly all perturbed ones is
offered at once. What does not sends the search on, without the leg on which it failed.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.model.plan import NOT_EXECUTABLE, TIME_SPENT, ContactPlan
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.planner.candidates import RouteSource, route_sources
from wholearm_ros.planner.certification import Certification
from wholearm_ros.planner.evaluation import Candidate, Evaluation
from wholearm_ros.planner.refinement import refine_transitions
from wholearm_ros.planner.request import PlanRequest, PlanResult
from wholearm_ros.planner.stopwatch import PLAN, Stopwatch
from wholearm_ros.rollout.band import build_band

Progress = Callable[[str], None]


def plan_and_verify(
    scenario: Scenario,
    request: PlanRequest = PlanRequest(),
    controls: ControlOptions = ControlOptions(),
    progress: Progress = lambda line: None,
) -> PlanResult:
    """The first plan that succeeds in verification, or the best of those tried if it succeeds often enough, or a reason.

    Raises ScenarioError when the start is impossible. `progress` is called with a line for people now and then.
    """
    watch = Stopwatch(request.time_budget)
    evaluation = Evaluation(scenario, request, controls, watch)
    certification = Certification(scenario, request, controls, watch)
    result: PlanResult | None = None
    ended: list[ContactPlan] = []  # of each source, the plan at which its search ended
    for source in route_sources(scenario, request, watch.late):
        for candidate in _promising(source, evaluation, ended, progress):
            result = _certified(candidate, evaluation, certification)
            if result or certification.given_up:
                break
        if result or certification.given_up or watch.late():
            break
    best, least = evaluation.best, request.least_success
    if not (result or certification.given_up) and best is not None and best.success_rate >= least:
        result = _certified(best, evaluation, certification)
    return result or _refusal(ended, evaluation, certification)


def _promising(
    source: RouteSource, evaluation: Evaluation, ended: list[ContactPlan], progress: Progress
) -> Iterator[Candidate]:
    """The best candidate of route after route as soon as it reaches the target; whoever asks for another did not like it."""
    most = evaluation.tried + evaluation.request.candidates
    with evaluation.watch.stage(PLAN):
        routes = source.open()
        plan = routes.next_plan()
    ended.append(plan)
    while plan.found and evaluation.tried < most and not evaluation.watch.late():
        executions = source.executions[: most - evaluation.tried]
        failed_leg = evaluation.try_route(plan, executions)
        if evaluation.done and evaluation.promising:
            yield evaluation.best
            evaluation.discard_best()
        rate = max(evaluation.success_rate, 0.0)
        progress(
            f'{evaluation.tried} candidates tried, the best succeeds in {rate:.0%} of its rollouts'
        )
        with evaluation.watch.stage(PLAN):
            ended[-1] = plan = routes.next_plan(failed_leg)
    if evaluation.promising:
        yield evaluation.best
        evaluation.discard_best()


def _certified(
    candidate: Candidate, evaluation: Evaluation, certification: Certification
) -> PlanResult | None:
    """The candidate, its transitions refined, with its certificate; None when it gets none."""
    best, request = refine_transitions(candidate, evaluation), evaluation.request
    plan, rollouts = best.plan, list(best.verification.rollouts)
    if request.certificate_samples:
        certificate = certification.certify(best)
        if certificate is None:
            return None
        plan = replace(plan, certificate=certificate)
        rollouts.extend(certification.rollouts)
    plan = replace(plan, band=build_band(best.trajectory, rollouts))
    record = {
        **best.verification.to_dict(),
        'level': request.level,
        'candidates_tried': evaluation.tried,
    }
    trajectory = replace(best.trajectory, plan_id=plan.id, verification=record, band=plan.band)
    return PlanResult(plan, trajectory, evaluation.watch.timings, best.verification)


def _refusal(
    ended: list[ContactPlan], evaluation: Evaluation, certification: Certification
) -> PlanResult:
    """No plan: the first search's plan without its route, and why nothing is offered."""
    late, first, tried = evaluation.watch.late(), ended[0], evaluation.tried
    searches = '; '.join(dict.fromkeys(plan.reason for plan in ended if not plan.found))
    if tried:
        outcome = TIME_SPENT if late else NOT_EXECUTABLE
        reason = (
            f'no route survives: {tried} candidates tried; {_shortfall(evaluation, certification)}'
        )
    else:
        outcome, reason = (TIME_SPENT if late else first.outcome), searches
    if late:
        reason = f'the time budget of {evaluation.request.time_budget:g} s is spent: {reason}'
    plan = replace(first, outcome=outcome, reason=reason, path=(), legs=(), cost={})
    verification = evaluation.best.verification if evaluation.best else None
    return PlanResult(plan, None, evaluation.watch.timings, verification)


def _shortfall(evaluation: Evaluation, certification: Certification) -> str:
    """What the best candidate lacks."""
    if certification.best is not None:
        least = evaluation.request.min_success
        return f'of the best one, {certification.best}; allowed: at least {least:g} (min_success)'
    if evaluation.best is None:
        return 'no trajectory can be made of any of them'
    verification = evaluation.best.verification
    nearest = (
        f'fewer than {evaluation.request.least_success:.0%} of its perturbed rollouts end at the goal'
        if verification.nominal.success
        else 'its nominal rollout does not end at the goal'
    )
    return f'of the best one, {nearest} ({"; ".join(verification.reasons()[:2])})'
