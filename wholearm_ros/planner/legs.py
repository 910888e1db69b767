"""The next leg of a way to a face: of the object's map where it knows one, else planned anew; with
the turns that are meant to follow it.
"""

import time
from dataclasses import dataclass, replace
from itertools import islice

from wholearm_ros.model.configuration import X
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario import CCW, CW, GoalOnEdge, Scenario, StartOnEdge
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.planner.certification import certify_in_a_row
from wholearm_ros.planner.face_map import FaceMap, Refused, Way
from wholearm_ros.planner.map_making import TARGETS, MapOptions, between, make_way, next_face
from wholearm_ros.planner.map_store import MapStore
from wholearm_ros.planner.planner import Progress, plan_and_verify
from wholearm_ros.planner.request import PlanRequest, PlanResult
from wholearm_ros.planner.supervision import stop_of
from wholearm_ros.trajectory.main_trajectory import generate

REACH = 0.002  # [m] how far from where one turn ends, as planned, the next one may begin
SLIDE_WITHIN = 2.0 * MapOptions.reach  # [m] of where a slide leads


@dataclass(frozen=True, eq=False)
class Leg:
    """trajectory: to the goal of `scenario`, which is a plan's own; stop: that goal when it is only
    a stop on the way, else None; plan: with the turns that are meant to follow.
    """

    trajectory: ManipulationTrajectory
    scenario: Scenario
    stop: GoalOnEdge | None = None
    plan: ContactPlan | None = None

    @property
    def unfelt_end(self) -> StartOnEdge | None:
        """Of its plan."""
        return self.plan.unfelt_end if self.plan else None


class LegPlanner:
    """Plans leg after leg of one object in one hand, and remembers the turns that were found on the
    way to another face, and how those that were executed went.

    maps: of the object, None for no map; in_a_row: whether an answer of several turns is given the
    certificate of all of them in a row.
    """

    def __init__(
        self, request: PlanRequest, maps: MapStore | None = None, in_a_row: bool = True
    ) -> None:
        self.request, self.maps, self.in_a_row = request, maps, in_a_row
        self._runs: dict[str, tuple[int, int]] = {}  # by a turn's plan id
        self._turn_of: dict[str, str] = {}  # by the id of an answer of several turns
        self._found: tuple[Way, ...] = ()

    def plan(self, scenario: Scenario, progress: Progress = lambda line: None) -> PlanResult:
        """A plan to the goal; or one to a stop on the way to it (`stop_of`), with the turns that
        follow and the certificate of all of them in a row.

        Only a goal without a direction may be reached by way of stops. Raises as `plan_and_verify`
        does.
        """
        if not isinstance(scenario.goal, GoalOnEdge) or scenario.goal.direction is not None:
            return plan_and_verify(scenario, self.request, progress=progress)
        ends = time.monotonic() + self.request.time_budget
        route = self._known_route(scenario) or self._slide_to_known(scenario, ends)
        if route:
            return self._answer(route)
        result = plan_and_verify(scenario, self.request, progress=progress)
        if result.trajectory is not None:
            return result
        route = self._slide_and_turn(scenario, ends, progress)
        reached: list[int] = []
        if not route:
            route, reached = self._by_way_of_others(scenario, ends, progress)
        if route:
            return self._answer(route)
        return _with_nearest(result, reached)

    def remember(self, plan: ContactPlan) -> None:
        """The turns of a plan of several, so that the later ones are not planned again."""
        if not plan.then:
            return
        turns = (plan.turn, *plan.then)
        ends = (*(turn.scenario.start for turn in plan.then), _end(turns[-1]))
        for turn, end in zip(turns, ends):
            start, goal = turn.scenario.start, turn.scenario.goal
            if not isinstance(start, StartOnEdge) or not isinstance(goal, GoalOnEdge):
                continue
            if isinstance(end, StartOnEdge):
                self._found += (Way(start, REACH, goal, end, turn),)

    def happened(self, plan_id: str, success: bool) -> None:
        """A plan was executed, and what was felt at its end was its goal, or was not."""
        turn = self._turn_of.get(plan_id, plan_id)
        succeeded, failed = self._runs.get(turn, (0, 0))
        self._runs[turn] = (succeeded + success, failed + (not success))

    def _answer(self, route: tuple[Way, ...]) -> PlanResult:
        plan = route[0].plan
        if len(route) > 1:
            turns = tuple(way.plan for way in route)
            overall = certify_in_a_row(turns, self.request) if self.in_a_row else None
            plan = replace(plan, then=turns[1:], overall=overall)
            self._turn_of[plan.id] = route[0].plan.id
        return PlanResult(plan, generate(plan.scenario, plan), {})

    def _known_route(self, scenario: Scenario) -> tuple[Way, ...]:
        """The surest one to another face, of the map and of what was found before."""
        start, goal = scenario.start, scenario.goal
        if not isinstance(start, StartOnEdge) or not isinstance(goal, GoalOnEdge):
            return ()
        if start.edge == goal.edge:
            return ()
        return self._known(scenario).route(start, goal)

    def _known(self, scenario: Scenario) -> FaceMap:
        """The map, what was found besides, and how its ways went in this session."""
        known = self.maps.load() if self.maps else FaceMap(scenario.object.polygon.resting_edges)
        return replace(known, ways=(*known.ways, *self._found)).after(self._runs)

    def _slide_to_known(self, scenario: Scenario, ends: float) -> tuple[Way, ...]:
        """A slide to where a known route to the goal begins, of the surest ones, and that route."""
        start, goal = scenario.start, scenario.goal
        if not isinstance(start, StartOnEdge) or not isinstance(goal, GoalOnEdge):
            return ()
        known = self._known(scenario)
        places = {way.start for way in known.ways if way.start.edge == start.edge}
        routes = {place: known.route(place, goal) for place in places}
        surest = sorted(
            (place for place in places if routes[place]),
            key=lambda place: (-known.success_rate(routes[place]), abs(place.x - start.x)),
        )
        for place in surest[:TARGETS]:
            slide = self._slide(scenario, place.x, ends)
            route = known.route(slide.end, goal) if slide else ()
            if slide and route:
                return slide, *route
        return ()

    def _slide_and_turn(
        self, scenario: Scenario, ends: float, progress: Progress
    ) -> tuple[Way, ...]:
        """A slide along the palm, towards its middle, and from where it ends the turn to the next
        face that has no plan from the start.
        """
        start, goal, polygon = scenario.start, scenario.goal, scenario.object.polygon
        if not isinstance(start, StartOnEdge) or not isinstance(goal, GoalOnEdge):
            return ()
        turns = [
            replace(goal, direction=direction)
            for direction in (CCW, CW)
            if next_face(polygon, start.edge, direction) == goal.edge
        ]
        slides = (self._slide(scenario, x, ends) for x in MapOptions().places if turns)
        for slide in islice((slide for slide in slides if slide is not None), TARGETS):
            progress(f'by way of x = {1e3 * slide.end.x:+.0f} mm')
            for turn in turns:
                way = self._way(scenario, slide.end, turn, ends)
                if way is not None:
                    return slide, way
        return ()

    def _slide(self, scenario: Scenario, x: float, ends: float) -> Way | None:
        """To within SLIDE_WITHIN of x, from further away than that."""
        start = scenario.start
        assert isinstance(start, StartOnEdge)
        goal = GoalOnEdge(start.edge, None, x, SLIDE_WITHIN)
        if abs(x - start.x) <= SLIDE_WITHIN or between(scenario, start, goal) is None:
            return None
        return self._way(scenario, start, goal, ends)

    def _by_way_of_others(
        self, scenario: Scenario, ends: float, progress: Progress
    ) -> tuple[tuple[Way, ...], list[int]]:
        """From face to face in either direction, until the goal can be reached from one: (route,
        faces on the way that were reached). No route, (), when it cannot, or when the time `ends`.
        """
        reached: list[int] = []
        start, goal, polygon = scenario.start, scenario.goal, scenario.object.polygon
        if not isinstance(start, StartOnEdge) or not isinstance(goal, GoalOnEdge):
            return (), reached
        for direction in (CCW, CW):
            route: tuple[Way, ...] = ()
            place, face = start, next_face(polygon, start.edge, direction)
            while face not in (None, goal.edge, start.edge):
                assert face is not None
                progress(f'by way of edge {face}')
                way = self._way(scenario, place, GoalOnEdge(face, direction), ends)
                if way is None:
                    break
                route, place = (*route, way), way.end
                reached.append(face)
                last = self._way(scenario, place, goal, ends)
                if last is not None:
                    return (*route, last), reached
                face = next_face(polygon, face, direction)
        return (), reached

    def _way(
        self, scenario: Scenario, place: StartOnEdge, goal: GoalOnEdge, ends: float
    ) -> Way | None:
        """One turn, from exactly the start of the scenario or from about where another one ends."""
        left = ends - time.monotonic()
        if left <= 0.0:
            return None
        reach = 0.0 if place is scenario.start else REACH
        options = MapOptions(replace(self.request, time_budget=left), reach=reach)
        made = make_way(replace(scenario, start=place, goal=goal), options)
        if isinstance(made, Refused):
            return None
        self._found += (made,)
        return made


def leg_of(asked: Scenario, result: PlanResult) -> Leg | None:
    """What was planned for `asked`; None without a plan."""
    if result.trajectory is None:
        return None
    planned = result.plan.scenario
    return Leg(result.trajectory, planned, stop_of(asked, planned), result.plan)


def whole_task(plan: ContactPlan) -> Scenario:
    """The scenario of a plan, with the goal of the last of its turns."""
    goals = [turn.scenario.goal for turn in plan.then]
    return replace(plan.scenario, goal=goals[-1]) if goals else plan.scenario


def _end(plan: ContactPlan) -> StartOnEdge | None:
    """Where a plan lays the object."""
    goal = plan.scenario.goal
    if not isinstance(goal, GoalOnEdge) or not plan.legs:
        return None
    return StartOnEdge(goal.edge, float(plan.legs[-1].configurations[-1, X]))


def _with_nearest(result: PlanResult, reached: list[int]) -> PlanResult:
    """The refusal, and which faces on the way can be reached."""
    if not reached:
        return result
    faces = ', '.join(str(face) for face in dict.fromkeys(reached))
    reason = f'{result.plan.reason}; of the faces on the way these can be reached: {faces}'
    return replace(result, plan=replace(result.plan, reason=reason))
