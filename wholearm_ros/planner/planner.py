"""Plan, execute in simulation, and only then give the plan: Phases 1 and 2 as one verified call.

Routes come from a search that has executed them, way by way, on perturbed samples. Each is executed
as a whole in a few ways; what succeeds in the nominal rollout and in nearly all perturbed ones is
certified at once. What does not sends the search on.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.errors import ScenarioError
from wholearm_ros.model.orientation import directed
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.polygon import ALIKE, edges_look_alike
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.planner.candidates import RouteSource, route_sources
from wholearm_ros.planner.certification import Certification, harder_rollouts
from wholearm_ros.planner.evaluation import Candidate, Evaluation
from wholearm_ros.planner.refinement import refine_transitions
from wholearm_ros.planner.refusal import better_way, refusal
from wholearm_ros.planner.request import PlanRequest, PlanResult
from wholearm_ros.planner.stopwatch import PLAN, VERIFY, Stopwatch
from wholearm_ros.rollout.band import build_band
from wholearm_ros.rollout.courses import build_courses
from wholearm_ros.trajectory.check_dwell import check_dwells

Progress = Callable[[str], None]


def plan_and_verify(
    scenario: Scenario,
    request: PlanRequest = PlanRequest(),
    controls: ControlOptions = ControlOptions(),
    progress: Progress = lambda line: None,
) -> PlanResult:
    """The first plan that is certified, with its trajectory, or the reason why there is none; for
    a goal without a direction, of both the one that succeeds more surely.

    The plan's own scenario has the direction. Raises ScenarioError when the start is impossible.
    `progress` is called with a line for people now and then.
    """
    if scenario.to_be_felt:
        raise ScenarioError(
            'start: got one that is to be felt first; allowed: to execute it (wholearm run, '
            'wholearm suite), or to plan from a told edge and x'
        )
    watch = Stopwatch(request.time_budget)
    answers: list[PlanResult] = []
    for one_way in directed(scenario):
        answers.append(_plan_one_way(one_way, request, controls, progress, watch))
        if answers[-1].certain or watch.late():
            break
    return better_way(answers)


def _plan_one_way(
    scenario: Scenario,
    request: PlanRequest,
    controls: ControlOptions,
    progress: Progress,
    watch: Stopwatch,
) -> PlanResult:
    """The first plan that is certified of a scenario whose goal has its direction."""
    evaluation = Evaluation(scenario, request, controls, watch)
    certification = Certification(scenario, request, controls, watch)
    ended: list[ContactPlan] = []  # of each source of routes, the plan at which its search ended
    for candidate in _candidates(evaluation, ended, progress):
        refined = refine_transitions(candidate, evaluation)
        result = _certified(refined, evaluation, certification)
        if result is not None:
            return result
        if certification.given_up:
            break
    return refusal(ended, evaluation, certification)


def _candidates(
    evaluation: Evaluation, ended: list[ContactPlan], progress: Progress
) -> Iterator[Candidate]:
    """Candidates that reach the target, from one source of routes after the other; at last the best
    of all, if it succeeds often enough. Whoever asks for another has no use for the one before.
    """
    request, watch = evaluation.request, evaluation.watch
    for source in route_sources(evaluation, progress):
        yield from _candidates_of(source, evaluation, ended, progress)
        if watch.late():
            break
    best = evaluation.best
    if best is not None and best.success_rate >= request.least_success:
        yield best


def _candidates_of(
    source: RouteSource, evaluation: Evaluation, ended: list[ContactPlan], progress: Progress
) -> Iterator[Candidate]:
    """The best candidate of route after route, as soon as it reaches the target."""
    most = evaluation.tried + evaluation.request.candidates
    with evaluation.watch.stage(PLAN):
        routes = source.open()
        plan = routes.next_plan()
    ended.append(plan)
    while plan.found and evaluation.tried < most and not evaluation.watch.late():
        failed_leg = evaluation.try_route(plan, source.executions[: most - evaluation.tried])
        if evaluation.done:
            yield from _promising(evaluation)
        rate, tried = max(evaluation.success_rate, 0.0), evaluation.tried
        progress(f'{tried} candidates tried, the best succeeds in {rate:.0%} of its rollouts')
        with evaluation.watch.stage(PLAN):
            ended[-1] = plan = routes.next_plan(failed_leg)
    yield from _promising(evaluation)


def _promising(evaluation: Evaluation) -> Iterator[Candidate]:
    """The best candidate, if it reaches the target; it is discarded when another is asked for."""
    if evaluation.best is not None and evaluation.promising:
        yield evaluation.best
        evaluation.discard_best()


def _certified(
    candidate: Candidate, evaluation: Evaluation, certification: Certification
) -> PlanResult | None:
    """The candidate with its certificate; None when it is refused one."""
    plan, request, watch = candidate.plan, evaluation.request, evaluation.watch
    rollouts = list(candidate.verification.rollouts)
    if request.certificate_samples:
        certificate = certification.certify(candidate)
        if certificate is None:
            return None
        plan = replace(plan, certificate=certificate)
        rollouts.extend(certification.rollouts)
    band = build_band(candidate.trajectory, rollouts)
    courses, strayed = None, None
    if edges_look_alike(evaluation.scenario.object.polygon, ALIKE):
        with evaluation.watch.stage(VERIFY):
            rollouts += harder_rollouts(
                candidate, evaluation.scenario, request, evaluation.controls
            )
        courses, strayed = build_courses(evaluation.scenario, rollouts)
    plan = replace(plan, band=band, courses=courses, strayed=strayed)
    dwells = check_dwells(evaluation.scenario, candidate.trajectory)
    record = {
        **candidate.verification.to_dict(),
        'dwells': len(dwells),
        'dwells_certified': sum(dwell.certified for dwell in dwells),
        'level': request.level,
        'candidates_tried': evaluation.tried,
    }
    trajectory = replace(
        candidate.trajectory,
        plan_id=plan.id,
        verification=record,
        band=band,
        courses=courses,
        strayed=strayed,
    )
    return PlanResult(plan, trajectory, watch.timings, candidate.verification)
