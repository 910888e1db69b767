"""The next leg of a way to a face: of the object's map where it knows one, else planned anew."""

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

from wholearm_ros.model.scenario import CCW, CW, GoalOnEdge, Scenario, StartOnEdge
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.planner.face_map import Way
from wholearm_ros.planner.map_making import next_face
from wholearm_ros.planner.map_store import MapStore
from wholearm_ros.planner.planner import Progress, plan_and_verify
from wholearm_ros.planner.request import PlanRequest, PlanResult
from wholearm_ros.planner.supervision import stop_of
from wholearm_ros.trajectory.main_trajectory import generate


@dataclass(frozen=True, eq=False)
class Leg:
    """trajectory: to the goal of `scenario`, which is a plan's own; stop: that goal when it is only
    a stop on the way, else None.
    """

    trajectory: ManipulationTrajectory
    scenario: Scenario
    stop: GoalOnEdge | None = None


class LegPlanner:
    """Plans leg after leg of one object in one hand, and remembers how those of its map went.

    maps: of the object, None for no map.
    """

    def __init__(self, request: PlanRequest, maps: MapStore | None = None) -> None:
        self.request, self.maps = request, maps
        self._runs: dict[str, tuple[int, int]] = {}

    def plan(self, scenario: Scenario, progress: Progress = lambda line: None) -> PlanResult:
        """A plan to the goal, or to a stop on the way to it; `stop_of` says which.

        Only a goal without a direction may be reached by way of stops. Raises as `plan_and_verify`
        does.
        """
        any_way = isinstance(scenario.goal, GoalOnEdge) and scenario.goal.direction is None
        way = self._known_way(scenario) if any_way else None
        if way is not None:
            return PlanResult(way.plan, generate(way.plan.scenario, way.plan), {})
        began = time.monotonic()
        result = plan_and_verify(scenario, self.request, progress=progress)
        if result.trajectory is not None or not any_way:
            return result
        for detour in _detours(scenario):
            left = self.request.time_budget - (time.monotonic() - began)
            if left <= 0.0:
                break
            progress('by way of another edge')
            request = replace(self.request, time_budget=left)
            found = plan_and_verify(detour, request, progress=progress)
            if found.trajectory is not None:
                return found
        return result

    def happened(self, plan_id: str, success: bool) -> None:
        """A plan was executed, and what was felt at its end was its goal, or was not."""
        succeeded, failed = self._runs.get(plan_id, (0, 0))
        self._runs[plan_id] = (succeeded + success, failed + (not success))

    def _known_way(self, scenario: Scenario) -> Way | None:
        """The first way of the surest route on the map to another face."""
        start, goal = scenario.start, scenario.goal
        if self.maps is None or not isinstance(start, StartOnEdge):
            return None
        if not isinstance(goal, GoalOnEdge) or start.edge == goal.edge:
            return None
        face_map = self.maps.load().after(self._runs)
        return next(iter(face_map.route(start, goal)), None)


def leg_of(asked: Scenario, result: PlanResult) -> Leg | None:
    """What was planned for `asked`; None without a plan."""
    if result.trajectory is None:
        return None
    planned = result.plan.scenario
    return Leg(result.trajectory, planned, stop_of(asked, planned))


def _detours(scenario: Scenario) -> Iterator[Scenario]:
    """The next faces either way, where they are not the goal."""
    start, goal, polygon = scenario.start, scenario.goal, scenario.object.polygon
    if not isinstance(start, StartOnEdge) or not isinstance(goal, GoalOnEdge):
        return
    for direction in (CCW, CW):
        face = next_face(polygon, start.edge, direction)
        if face is not None and face not in (goal.edge, start.edge):
            yield replace(scenario, goal=GoalOnEdge(face, direction))
