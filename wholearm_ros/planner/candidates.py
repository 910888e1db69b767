"""Candidates: the routes of a scenario, and the ways in which each may be executed."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

from wholearm_ros.model.modes import DWELL, DYNAMIC
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.planning.primitive_candidates import STYLES
from wholearm_ros.planning.routes import PrimitiveRoutes, Routes, SearchOptions, make_routes
from wholearm_ros.trajectory.execution_options import AUTO, FRONT, REAR, ExecutionOptions

# velocity finger and torque [N m] in caging, the most promising first
CAGING_EXECUTIONS = ((FRONT, 0.1), (REAR, 0.1), (FRONT, 0.02), (REAR, 0.3), (FRONT, 0.3))
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


def route_sources(
    scenario: Scenario, request: PlanRequest, stop: Callable[[], bool]
) -> Iterator[RouteSource]:
    """Routes of arcs, then routes of dynamic primitives, one style of sweeps after the other.

    stop: whether to give up.
    """
    options = SearchOptions(request.search, request.seed, request.limit, request.moves)
    yield RouteSource(partial(make_routes, scenario, options, stop), arc_executions(request))
    for style in STYLES if request.moves else ():
        yield RouteSource(
            partial(PrimitiveRoutes, scenario, options, style=style, stop=stop),
            primitive_executions(),
        )


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


def primitive_executions() -> tuple[ExecutionOptions, ...]:
    """Ways to execute a route of dynamic primitives: only its caging descent leaves a choice."""
    return tuple(
        ExecutionOptions(caging_finger=finger, caging_torque=torque)
        for finger, torque in CAGING_EXECUTIONS
    )
