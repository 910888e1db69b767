"""Phase 1 as a whole: a scenario in, contact plans out, one route after the other."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from wholearm_ros.mechanics.mirror import mirror_plan
from wholearm_ros.model.choices import Search
from wholearm_ros.model.hand import LEFT, RIGHT
from wholearm_ros.model.orientation import turns_clockwise
from wholearm_ros.model.plan import (
    EXHAUSTED,
    FOUND,
    TIME_SPENT,
    ContactPlan,
    Leg,
    Subgoal,
)
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.planning.best_first_search import ArcGraph, BestRoute, Edge, EdgeKey, best_route
from wholearm_ros.planning.main_random_search import main_random_search
from wholearm_ros.planning.problem import build_problem

BEST, RANDOM = Search.best.value, Search.random.value
Stop = Callable[[], bool]


@dataclass(frozen=True)
class SearchOptions:
    """search: BEST or RANDOM; seed: of the random search; limit: of expansions (i_max); move_limit:
    of simulations in the search over states at rest, 0 for no limit and no motion primitives.
    """

    search: str = BEST
    seed: int = 0
    limit: int = 5000
    move_limit: int = 7000


@dataclass(frozen=True)
class Found:
    """What a search came to: the fields of a ContactPlan that it fills."""

    outcome: str
    reason: str
    counts: dict[str, Any]
    subgoals: tuple[Subgoal, ...] = ()
    path: tuple[int, ...] = ()
    legs: tuple[Leg, ...] = ()
    cost: dict[str, Any] = field(default_factory=dict)


def make_routes(scenario: Scenario, options: SearchOptions, stop: Stop = lambda: False) -> 'Routes':
    """The routes of a scenario: call `.next_plan(failed_leg)` for one after the other.

    Raises ScenarioError when the fingers cannot touch the object or the start penetrates the hand.
    """
    return (BestRoutes if options.search == BEST else RandomRoutes)(scenario, options, stop)


def plan(scenario: Scenario, options: SearchOptions = SearchOptions()) -> ContactPlan:
    """The first route. Raises as `make_routes` does."""
    return make_routes(scenario, options).next_plan()


class Routes(ABC):
    """Route after route; a clockwise scenario is searched as its mirror image.

    stop: whether to give up, asked now and then.
    """

    def __init__(
        self, scenario: Scenario, options: SearchOptions, stop: Stop = lambda: False
    ) -> None:
        self.scenario, self.options, self.stop = scenario, options, stop
        self._mirrored = turns_clockwise(scenario)
        self.problem = build_problem(scenario.mirrored() if self._mirrored else scenario)

    def next_plan(self, failed_leg: int | None = None) -> ContactPlan:
        """The next route, or why there is none; failed_leg: place of the leg on which the last plan
        failed, if it did.
        """
        found, options = self._search(failed_leg), self.options
        document = ContactPlan(self.problem.scenario, options.search, options.seed, **vars(found))
        return mirror_plan(document, self.scenario) if self._mirrored else document

    @abstractmethod
    def _search(self, failed_leg: int | None) -> Found:
        """See `next_plan`; of the counter-clockwise scenario."""


class BestRoutes(Routes):
    """The best route first; each one that failed costs the graph the edge on which it failed."""

    def __init__(
        self, scenario: Scenario, options: SearchOptions, stop: Stop = lambda: False
    ) -> None:
        super().__init__(scenario, options, stop)
        self.graph = ArcGraph(self.problem, options.limit, stop)
        self._without: frozenset[EdgeKey] = frozenset()
        self._edges: tuple[Edge, ...] = ()

    def _search(self, failed_leg: int | None) -> Found:
        if failed_leg is not None:
            self._without |= {self._edge_of_leg(failed_leg).key}
        route = best_route(self.graph, self._without)
        self._edges = route.edges
        network = self.graph.network
        counts = {
            'expansions': self.graph.traced,
            'routes_ruled_out': len(self._without),
            **network.counts(),
        }
        subgoals = tuple(network.subgoals)
        if route.outcome != FOUND:
            return Found(route.outcome, _why(route.outcome, self._without), counts, subgoals)
        path: list[int] = [1]
        legs: list[Leg] = []
        for edge in route.edges:
            path.extend(edge.numbers)
            legs.extend(network.legs[n] for n in edge.numbers[1:])
            if edge.end is not None:
                path.append(network.nodes[edge.end].number)
        cost = {'margin': route.margin, 'total': route.cost}
        return Found(FOUND, self._reason(route), counts, subgoals, tuple(path), tuple(legs), cost)

    def _reason(self, route: BestRoute) -> str:
        exhausted = self.graph.exhausted
        whole = 'exhausted' if exhausted else 'not exhausted, what is left of it is narrower'
        width = (
            f'widest torque margin {route.margin:.3f} N m'
            if route.margin > 0.0
            else 'no torque margin where it is narrowest'
        )
        return f'{width}, cost {route.cost:.2f}, best on the graph ({whole})'

    def _edge_of_leg(self, leg: int) -> Edge:
        for edge in self._edges:
            leg -= len(edge.numbers) - 1
            if leg < 0:
                return edge
        raise IndexError('the last plan has fewer legs')


class RandomRoutes(Routes):
    """The paper's search, with the right finger velocity-controlled, and with the left one when
    that finds none. Every call searches anew, whichever leg failed.
    """

    def __init__(
        self, scenario: Scenario, options: SearchOptions, stop: Stop = lambda: False
    ) -> None:
        super().__init__(scenario, options, stop)
        self._rng = np.random.default_rng(options.seed)

    def _search(self, failed_leg: int | None) -> Found:
        for finger in (RIGHT, LEFT):
            outcome, network, goal, iterations = main_random_search(
                self.problem, self._rng, self.options.limit, finger, self.stop
            )
            if outcome == FOUND:
                break
        counts = {'iterations': iterations, **network.counts()}
        subgoals = tuple(network.subgoals)
        if goal is None:
            return Found(outcome, _why(outcome), counts, subgoals)
        reason = f'reached after {iterations} iterations'
        path, legs = network.route_to(goal)
        margin, cost = network.cost_to(goal)
        return Found(FOUND, reason, counts, subgoals, path, legs, {'margin': margin, 'total': cost})


def _why(outcome: str, without: frozenset[EdgeKey] = frozenset()) -> str:
    """Why a search of the contact states found no route."""
    if outcome == TIME_SPENT:
        return 'the time was spent before the search found a route'
    if outcome != EXHAUSTED:
        return 'the limit of expansions was reached before a route was found'
    if without:
        return (
            f'no route is left on the exhausted graph without {len(without)} that did not survive'
        )
    return 'the graph of contact states is exhausted and holds no route to the goal'
