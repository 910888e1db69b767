"""Candidates: the routes of a scenario, and the ways in which each may be executed."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

from wholearm_ros.model.modes import DWELL, DYNAMIC
from wholearm_ros.planner.evaluation import Evaluation
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.planning.routes import BEST, Routes, SearchOptions, make_routes
from wholearm_ros.search.caging_ways import CAGING_EXECUTIONS
from wholearm_ros.search.state_routes import StateRoutes
from wholearm_ros.trajectory.execution_options import AUTO, FRONT, REAR, ExecutionOptions

STATE_EXECUTIONS = ExecutionOptions(), ExecutionOptions(stops=True)
# extra torque [N m] and its lead [s], likewise
DYNAMIC_TRANSITIONS = (
    (0.3, 0.08),
    (0.7, 0.08),
    (2.0, 0.08),
    (0.3, 0.04),
    (0.7, 0.04),
    (2.0, 0.04),
    (0.3, 0.14),
    (2.0, 0.14),
)


@dataclass(frozen=True, eq=False)
class RouteSource:
    """Where routes come from: `open()` begins the search; executions: options with which each route
    is tried, the most promising first.
    """

    open: Callable[[], Routes]
    executions: tuple[ExecutionOptions, ...]


def route_sources(evaluation: Evaluation, progress: Callable[[str], None]) -> Iterator[RouteSource]:
    """The search over states at rest; before it the paper's random search if that is asked for, and
    for dynamic transitions, which join two arcs without a stop, whole routes of arcs.
    """
    request, stop = evaluation.request, evaluation.watch.late
    options = SearchOptions(request.search, request.seed, request.limit, request.moves)
    routes = partial(make_routes, evaluation.scenario, options, stop)
    if request.search != BEST or request.transition == DYNAMIC:
        yield RouteSource(routes, arc_executions(request))
    if request.transition != DYNAMIC or request.moves:
        states = partial(
            StateRoutes, evaluation.scenario, options, evaluation.beliefs, stop, progress
        )
        yield RouteSource(states, STATE_EXECUTIONS)


def arc_executions(request: PlanRequest) -> tuple[ExecutionOptions, ...]:
    """Ways to execute a route of arcs; a dynamic transition needs one velocity finger throughout.

    Where all of these fail, another route does better than another way: of 21 plans looked at, none
    had the front finger velocity-controlled throughout, or a dynamic transition.
    """
    dynamic = request.transition == DYNAMIC
    transitions = transition_options(DYNAMIC if dynamic else DWELL)
    margins = (0.5, 3.5) if dynamic else (0.5,)
    fingers = (FRONT, REAR, AUTO) if dynamic else (AUTO, REAR)
    return tuple(
        replace(
            transition,
            velocity_finger=finger,
            caging_finger=caging_finger,
            caging_torque=caging_torque,
            torque_margin=margin,
        )
        for transition, margin, finger, (caging_finger, caging_torque) in product(
            transitions, margins, fingers, CAGING_EXECUTIONS
        )
    )


def transition_options(wanted: str) -> tuple[ExecutionOptions, ...]:
    """Ways to cross between torque ranges that part: stop (dwell), or begin the extra torque early
    enough (dynamic). wanted: DWELL, DYNAMIC or AUTO.
    """
    dwell = (ExecutionOptions(transition=DWELL),)
    dynamic = tuple(
        ExecutionOptions(transition=DYNAMIC, extra_torque=extra, dynamic_lead=lead)
        for extra, lead in DYNAMIC_TRANSITIONS
    )
    return {DWELL: dwell, DYNAMIC: dynamic, AUTO: (*dwell, *dynamic[:1])}[wanted]
