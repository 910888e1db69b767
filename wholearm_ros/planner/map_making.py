"""Making a face map: which ways are tried, and each of them planned and certified."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from wholearm_ros.errors import ScenarioError
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario import CCW, CW, GoalOnEdge, Scenario, StartOnEdge
from wholearm_ros.model.scenario_file import parse_scenario, scenario_to_dict
from wholearm_ros.planner.face_map import Refused, Way
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest

TARGETS = 2  # places to which a slide for turns of one direction is tried


@dataclass(frozen=True)
class MapOptions:
    """request: of every way; half_range, step: of the places x = -half_range, ... half_range [m] at
    which ways begin; reach: how far from such a place the object may truly lie [m], a little more
    than half a step, so that a felt x is within reach of one.
    """

    request: PlanRequest = PlanRequest(time_budget=60.0)
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


def turns_to_try(scenario: Scenario, options: MapOptions) -> list[Scenario]:
    """From every face, at every place that hand and palm allow, to the next face either way."""
    polygon = scenario.object.polygon
    found = []
    for x in options.places:
        for face in polygon.resting_edges:
            for direction in (CCW, CW):
                goal = next_face(polygon, face, direction)
                if goal is not None:
                    asked = _between(scenario, StartOnEdge(face, x), GoalOnEdge(goal, direction))
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
                    asked = _between(scenario, StartOnEdge(face, x), goal)
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
        return Refused(start, goal, f'{result.plan.outcome}: {result.plan.reason}')
    ends = [r.configurations[-1, 0] for r in result.verification.rollouts if r.success]
    end = StartOnEdge(goal.edge, round(float(np.median(ends)), 5))
    return Way(start, options.reach, goal, end, result.plan)


def _between(scenario: Scenario, start: StartOnEdge, goal: GoalOnEdge) -> Scenario | None:
    """The scenario from start to goal; None where hand or palm does not allow it."""
    asked = replace(scenario, start=start, goal=goal)
    try:
        return parse_scenario(scenario_to_dict(asked))
    except ScenarioError:
        return None
