"""Making a face map: which ways are tried, and each of them planned and certified."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from wholearm_ros.errors import ScenarioError
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario import CCW, CW, GoalOnEdge, Scenario, StartOnEdge
from wholearm_ros.model.scenario_file import parse_scenario, scenario_to_dict
from wholearm_ros.planner.face_map import FaceMap, Refused, Way
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest

TARGETS = 2  # places to which a slide for turns of one direction is tried
QUICK_MOVES = 1000  # a search without an answer takes 7000, and most turns are found within 500


@dataclass(frozen=True)
class MapOptions:
    """request: of every way; quick_moves: simulations of the first search for every turn;
    half_range, step: of the places x = -half_range, ... half_range [m] at which ways begin; reach:
    how far from such a place the object may truly lie [m], a little more than half a step, so that
    a felt x is within reach of one.
    """

    request: PlanRequest = PlanRequest(time_budget=60.0)
    quick_moves: int = QUICK_MOVES
    half_range: float = 0.03
    step: float = 0.01
    reach: float = 0.006

    @property
    def places(self) -> tuple[float, ...]:
        """[m], from the middle outwards: the likeliest first."""
        count = int(round(self.half_range / self.step))
        places = (round(self.step * k, 6) for k in range(-count, count + 1))
        return tuple(sorted(places, key=abs))


def next_face(polygon: Polygon, face: int, direction: str) -> int | None:
    """The next edge on which the object can rest when it is turned from `face`; None without
    another.
    """
    sign, begin = (1.0 if direction == CCW else -1.0), polygon.resting_angle(face)
    turns = {
        other: float(np.mod(sign * (polygon.resting_angle(other) - begin), 2.0 * np.pi))
        for other in polygon.resting_edges
        if other != face
    }
    return min(turns, key=lambda other: turns[other]) if turns else None


class Stage(NamedTuple):
    """Of the making of a map: what is tried next, and how."""

    name: str
    wanted: list[Scenario]
    options: MapOptions


def map_stages(
    scenario: Scenario, options: MapOptions, load: Callable[[], FaceMap]
) -> Iterator[Stage]:
    """What a map is made of, in order; `load` gives the map as the stages before have left it.

    All turns are searched for quickly, then slides to those found. What is lacking then is searched
    for as long as `options.request` says, from the middle of every face outwards, as a turn that is
    found may be slid to from the other places.
    """
    quick = min(options.quick_moves, options.request.moves)
    yield Stage('turns', turns_to_try(scenario, options), with_moves(options, quick))
    yield _slides(scenario, options, load())
    for distance in sorted({abs(x) for x in options.places}):
        known = load()
        places = [x for x in options.places if abs(x) == distance]
        turns = turns_to_try(scenario, options, places)
        wanted = [asked for asked in turns if not _leads_on(known, asked)]
        yield Stage('turns that lack', wanted, options)
        yield _slides(scenario, options, load())


def with_moves(options: MapOptions, moves: int) -> MapOptions:
    """The options with so many simulations for every way."""
    return replace(options, request=replace(options.request, moves=moves))


def _slides(scenario: Scenario, options: MapOptions, known: FaceMap) -> Stage:
    return Stage('slides', slides_to_try(scenario, options, known.ways), with_moves(options, 0))


def _leads_on(known: FaceMap, asked: Scenario) -> bool:
    """Whether the turn that is asked for is known from its start, or from where a slide leads."""
    start = asked.start
    assert isinstance(start, StartOnEdge)
    slides = (w for w in known.ways if w.goal.direction is None and w.begins_at(start))
    places = [start, *(slide.end for slide in slides)]
    turns = (way for way in known.ways if way.goal == asked.goal)
    return any(turn.begins_at(place) for turn in turns for place in places)


def turns_to_try(
    scenario: Scenario, options: MapOptions, places: Sequence[float] | None = None
) -> list[Scenario]:
    """From every face, at every place that hand and palm allow, to the next face either way.

    places: x [m], those of the options by default.
    """
    polygon = scenario.object.polygon
    found = []
    for x in options.places if places is None else places:
        for face in polygon.resting_edges:
            for direction in (CCW, CW):
                goal = next_face(polygon, face, direction)
                if goal is not None:
                    asked = between(scenario, StartOnEdge(face, x), GoalOnEdge(goal, direction))
                    found += [asked] if asked else []
    return found


def slides_to_try(scenario: Scenario, options: MapOptions, ways: Iterable[Way]) -> list[Scenario]:
    """On every face, from every place where no turn of a direction begins to the surest places
    where one does: from the places of the options, and from where turns onto that face end.
    """
    turns = [way for way in ways if way.goal.direction]
    found: dict[tuple[int, float, float], Scenario] = {}
    for face in scenario.object.polygon.resting_edges:
        starts = _places_on(face, options, turns)
        for direction in (CCW, CW):
            here = [w for w in turns if (w.start.edge, w.goal.direction) == (face, direction)]
            surest = sorted(here, key=lambda w: (-w.certificate.lower_bound, abs(w.start.x)))
            for x in starts:
                if any(way.begins_at(StartOnEdge(face, x)) for way in here):
                    continue
                for way in surest[:TARGETS]:
                    goal = GoalOnEdge(face, None, way.start.x, 2.0 * options.reach)
                    asked = between(scenario, StartOnEdge(face, x), goal)
                    if asked is not None:
                        found[face, x, way.start.x] = asked
    return list(found.values())


def _places_on(face: int, options: MapOptions, turns: Iterable[Way]) -> list[float]:
    """The places of the options and, out of their reach, those where turns onto the face end."""
    places = list(options.places)
    for way in turns:
        x = way.end.x
        if way.end.edge == face and all(abs(x - place) > options.reach for place in places):
            places.append(x)
    return places


def make_way(scenario: Scenario, options: MapOptions) -> Way | Refused:
    """Plan and certify one way, from a place within `reach` of its start.

    Slides are looked for among arcs only: what needs more is no slide.
    """
    start, goal = scenario.start, scenario.goal
    assert isinstance(start, StartOnEdge) and isinstance(goal, GoalOnEdge)
    request = replace(options.request, start_x_error=options.reach)
    if goal.edge == start.edge:
        request = replace(request, moves=0)
    result = plan_and_verify(scenario, request)
    if result.trajectory is None or result.verification is None:
        limited = 0 < request.moves <= result.plan.counts.get('simulations', 0)
        reason = f'{result.plan.outcome}: {result.plan.reason}'
        return Refused(start, goal, reason, request.moves if limited else None)
    ends = [r.configurations[-1, 0] for r in result.verification.rollouts if r.success]
    end = StartOnEdge(goal.edge, round(float(np.median(ends)), 5))
    return Way(start, options.reach, goal, end, result.plan.route_alone)


def between(scenario: Scenario, start: StartOnEdge, goal: GoalOnEdge) -> Scenario | None:
    """The scenario from start to goal; None where hand or palm does not allow it."""
    asked = replace(scenario, start=start, goal=goal)
    try:
        return parse_scenario(scenario_to_dict(asked))
    except ScenarioError:
        return None
