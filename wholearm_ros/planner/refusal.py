"""Refusal: the answer when no plan is given, with a true reason."""

from dataclasses import replace

from wholearm_ros.model.plan import NOT_EXECUTABLE, TIME_SPENT, ContactPlan
from wholearm_ros.model.scenario import CCW
from wholearm_ros.planner.certification import Certification
from wholearm_ros.planner.evaluation import Evaluation
from wholearm_ros.planner.request import PlanResult


def refusal(
    ended: list[ContactPlan], evaluation: Evaluation, certification: Certification
) -> PlanResult:
    """The plan of the first search without its route, and why no plan is given.

    ended: of each source of routes, the plan at which its search ended.
    """
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


def better_way(answers: list[PlanResult]) -> PlanResult:
    """The surest of the answers for either direction, the first of equals; without a plan, why
    neither has one.
    """
    best = max(answers, key=lambda answer: answer.success_rate)
    if best.trajectory is not None or len(answers) == 1:
        return best
    reasons = (f'{_direction(answer)}: {answer.plan.reason}' for answer in answers)
    return replace(best, plan=replace(best.plan, reason='; '.join(reasons)))


def _direction(answer: PlanResult) -> str:
    goal = answer.plan.scenario.goal
    return 'counter-clockwise' if getattr(goal, 'direction', None) == CCW else 'clockwise'


def _shortfall(evaluation: Evaluation, certification: Certification) -> str:
    """What the best candidate lacks."""
    if certification.best is not None:
        least = evaluation.request.min_success
        return f'of the best one, {certification.best}; allowed: at least {least:g} (min_success)'
    if evaluation.best is None:
        return 'no trajectory can be made of any of them'
    verification, least = evaluation.best.verification, evaluation.request.least_success
    nearest = (
        f'fewer than {least:.0%} of its perturbed rollouts end at the goal'
        if verification.nominal.success
        else 'its nominal rollout does not end at the goal'
    )
    return f'of the best one, {nearest} ({"; ".join(verification.reasons()[:2])})'
