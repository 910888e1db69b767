"""Plan, execute in simulation, and only then offer: Phase 1 and Phase 2 as one call.

Routes come best first. Each is tried in a few ways; what succeeds in the nominal rollout and in nearly all perturbed ones is
offered at once. What does not sends the search on, without the leg on which it failed.
"""

from dataclasses import replace
from typing import Callable

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.model.plan import NOT_EXECUTABLE, TIME_SPENT, ContactPlan
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.planner.candidates import RouteSource, route_sources
from wholearm_ros.planner.evaluation import Candidate, Evaluation
from wholearm_ros.planner.refinement import refine_transitions
from wholearm_ros.planner.request import PlanRequest, PlanResult
from wholearm_ros.planner.stopwatch import PLAN, Stopwatch

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
    unexecuted: list[ContactPlan] = []  # of each source, the plan at which it ended
    for source in route_sources(scenario, request, watch.late):
        if evaluation.success_rate >= request.target_success or unexecuted and watch.late():
            break
        unexecuted.append(_try_routes(source, evaluation, progress))
    if evaluation.best is None or evaluation.success_rate < request.least_success:
        verification = evaluation.best and evaluation.best.verification
        return PlanResult(_refusal(unexecuted, evaluation), None, watch.timings, verification)
    best = refine_transitions(evaluation.best, evaluation)
    return _result(best, evaluation)


def _try_routes(source: RouteSource, evaluation: Evaluation, progress: Progress) -> ContactPlan:
    """Try route after route until the evaluation is done or there are no more; returns the last plan."""
    most = evaluation.tried + evaluation.request.candidates
    with evaluation.watch.stage(PLAN):
        routes = source.open()
        plan = routes.next_plan()
    while plan.found and evaluation.tried < most and not evaluation.watch.late():
        executions = source.executions[: most - evaluation.tried]
        failed_leg = evaluation.try_route(plan, executions)
        if evaluation.done:
            break
        rate = max(evaluation.success_rate, 0.0)
        progress(
            f'{evaluation.tried} candidates tried, the best succeeds in {rate:.0%} of its rollouts'
        )
        with evaluation.watch.stage(PLAN):
            plan = routes.next_plan(failed_leg)
    return plan


def _result(best: Candidate, evaluation: Evaluation) -> PlanResult:
    record = {
        **best.verification.to_dict(),
        'level': evaluation.request.level,
        'candidates_tried': evaluation.tried,
    }
    trajectory = replace(best.trajectory, plan_id=best.plan.id, verification=record)
    return PlanResult(best.plan, trajectory, evaluation.watch.timings, best.verification)


def _refusal(ended: list[ContactPlan], evaluation: Evaluation) -> ContactPlan:
    """No plan: the first search's plan without its route, and why nothing is offered."""
    late, first = evaluation.watch.late(), ended[0]
    searches = '; '.join(dict.fromkeys(plan.reason for plan in ended if not plan.found))
    if evaluation.tried:
        outcome = TIME_SPENT if late else NOT_EXECUTABLE
        reason = f'no route survives: {evaluation.tried} candidates tried; {_shortfall(evaluation)}'
    else:
        outcome, reason = (TIME_SPENT if late else first.outcome), searches
    if late:
        reason = f'the time budget of {evaluation.request.time_budget:g} s is spent: {reason}'
    return replace(first, outcome=outcome, reason=reason, path=(), legs=(), cost={})


def _shortfall(evaluation: Evaluation) -> str:
    """What the best candidate lacks."""
    if evaluation.best is None:
        return 'no trajectory can be made of any of them'
    verification = evaluation.best.verification
    nearest = (
        f'fewer than {evaluation.request.least_success:.0%} of its perturbed rollouts end at the goal'
        if verification.nominal.success
        else 'its nominal rollout does not end at the goal'
    )
    return f'of the best one, {nearest} ({"; ".join(verification.reasons()[:2])})'
