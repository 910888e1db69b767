"""Phase 1 as a whole: a scenario in, contact plans out, one route after the other."""

from dataclasses import dataclass
from typing import Callable

import numpy as np

from wholearm_ros.mechanics.mirror import mirror_plan
from wholearm_ros.model.hand import LEFT, RIGHT
from wholearm_ros.model.orientation import turns_clockwise
from wholearm_ros.model.plan import EXHAUSTED, FOUND, LIMIT_REACHED, TIME_SPENT, ContactPlan
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.planning.best_first_search import ArcGraph, best_route
from wholearm_ros.planning.main_random_search import main_random_search
from wholearm_ros.planning.primitive_tree import STYLES, PrimitiveTree, Style, primitive_tree_search
from wholearm_ros.planning.problem import build_problem

BEST, RANDOM = 'best', 'random'
Stop = Callable[[], bool]


@dataclass(frozen=True)
class SearchOptions:
    """search: best or random; seed: of the random one, and of the copies that judge dynamic moves; limit: of expansions
    (i_max); move_limit: of moves simulated in one tree where the arcs do not lead to the goal, 0 for none."""

    search: str = BEST
    seed: int = 0
    limit: int = 5000
    move_limit: int = 8000


def make_routes(scenario: Scenario, options: SearchOptions, stop: Stop = lambda: False) -> 'Routes':
    """The routes of a scenario: call `.next_plan(failed_leg)` for one after the other.

    Raises ScenarioError when the fingers cannot touch the object or the start penetrates the hand.
    """
    return (BestRoutes if options.search == BEST else RandomRoutes)(scenario, options, stop)


def plan(scenario: Scenario, options: SearchOptions = SearchOptions()) -> ContactPlan:
    """The first route."""
    return make_routes(scenario, options).next_plan()


class Routes:
    """Route after route; a clockwise scenario is searched as its mirror image. stop: whether to give up."""

    def __init__(self, scenario: Scenario, options: SearchOptions, stop: Stop = lambda: False):
        self.scenario, self.options, self.stop = scenario, options, stop
        self._mirrored = turns_clockwise(scenario)
        self.task = build_problem(scenario.mirrored() if self._mirrored else scenario)

    def _plan(self, outcome, reason, network, counts, path=(), legs=(), cost=None) -> ContactPlan:
        return self._document(
            outcome,
            reason,
            {**counts, **network.counts()},
            tuple(network.subgoals),
            path,
            legs,
            cost or {},
        )

    def _document(
        self, outcome, reason, counts, subgoals=(), path=(), legs=(), cost=None
    ) -> ContactPlan:
        found = ContactPlan(
            self.task.scenario,
            self.options.search,
            self.options.seed,
            outcome,
            reason,
            counts,
            subgoals,
            path,
            legs,
            cost or {},
        )
        return mirror_plan(found, self.scenario) if self._mirrored else found


class BestRoutes(Routes):
    """The best route first; each one that failed costs the graph the edge on which it failed."""

    def __init__(self, scenario: Scenario, options: SearchOptions, stop: Stop = lambda: False):
        super().__init__(scenario, options, stop)
        self.graph = ArcGraph(self.task, options.limit, stop)
        self._without, self._edges = frozenset(), ()

    def next_plan(self, failed_leg: int = None) -> ContactPlan:
        """The best route that avoids the edge of every leg (by its place in the last plan) that failed before."""
        if failed_leg is not None:
            edge = self._edge_of_leg(failed_leg)
            self._without |= {(edge.start, edge.choice)}
        outcome, self._edges, margin, cost = best_route(self.graph, self._without)
        counts = {'expansions': self.graph.traced, 'routes_ruled_out': len(self._without)}
        network = self.graph.network
        if outcome != FOUND:
            return self._plan(outcome, _why(outcome, self._without), network, counts)
        path, legs = [1], []
        for edge in self._edges:
            path.extend(edge.numbers)
            legs.extend(network.legs[n] for n in edge.numbers[1:])
            if edge.end is not None:
                path.append(network.nodes[edge.end].number)
        whole = (
            'exhausted' if self.graph.exhausted else 'not exhausted, what is left of it is narrower'
        )
        width = (
            f'widest torque margin {margin:.3f} N m'
            if margin > 0.0
            else 'no torque margin where it is narrowest'
        )
        reason = f'{width}, cost {cost:.2f}, best on the graph ({whole})'
        return self._plan(
            FOUND,
            reason,
            network,
            counts,
            tuple(path),
            tuple(legs),
            {'margin': margin, 'total': cost},
        )

    def _edge_of_leg(self, leg):
        for edge in self._edges:
            leg -= len(edge.numbers) - 1
            if leg < 0:
                return edge
        raise IndexError('the last plan has fewer legs')


class RandomRoutes(Routes):
    """The paper's search, with the right finger velocity-controlled, and with the left one when that finds none."""

    def __init__(self, scenario: Scenario, options: SearchOptions, stop: Stop = lambda: False):
        super().__init__(scenario, options, stop)
        self._rng = np.random.default_rng(options.seed)

    def next_plan(self, failed_leg: int = None) -> ContactPlan:
        """Another random route; which leg failed makes no difference."""
        for finger in (RIGHT, LEFT):
            outcome, network, goal, iterations = main_random_search(
                self.task, self._rng, self.options.limit, finger, self.stop
            )
            if outcome == FOUND:
                break
        counts = {'iterations': iterations}
        if outcome != FOUND:
            return self._plan(outcome, _why(outcome, ()), network, counts)
        path, legs = network.route_to(goal)
        margin, cost = network.cost_to(goal)
        return self._plan(
            FOUND,
            f'reached after {iterations} iterations',
            network,
            counts,
            path,
            legs,
            {'margin': margin, 'total': cost},
        )


class PrimitiveRoutes(Routes):
    """Routes of dynamic moves, each one another way through the tree of states at rest."""

    def __init__(
        self,
        scenario: Scenario,
        options: SearchOptions,
        stop: Stop = lambda: False,
        style: Style = STYLES[0],
    ):
        super().__init__(scenario, options, stop)
        self._tree = PrimitiveTree(self.task, options.seed, style)

    def next_plan(self, failed_leg: int = None) -> ContactPlan:
        """The next route the tree grows into; which leg of the last one failed makes no difference."""
        route = primitive_tree_search(self.task, self._tree, self.options.move_limit, self.stop)
        counts = {'states_at_rest': len(self._tree.states), 'moves_simulated': self._tree.simulated}
        if route is None:
            return self._document(
                *self._why_none(),
                counts,
            )
        subgoals, legs = route
        cost = {'total': float(len(legs))}
        reason = f'{len(legs)} legs of dynamic moves and caging'
        return self._document(
            FOUND,
            reason,
            {**counts, 'subgoals': len(subgoals)},
            tuple(subgoals),
            tuple(s.number for s in subgoals),
            tuple(legs),
            cost,
        )

    def _why_none(self) -> tuple[str, str]:
        """(outcome, reason) of a search that ended without a route."""
        none = 'no sequence of dynamic primitives was found'
        if self._tree.simulated >= self.options.move_limit:
            return LIMIT_REACHED, f'{none} in {self._tree.simulated} simulated ones'
        if self._tree.open:
            return TIME_SPENT, f'{none} before the time was spent'
        return EXHAUSTED, f'{none}, and no state at rest is left to go on from'


def _why(outcome, without):
    if outcome == TIME_SPENT:
        return 'the time was spent before the search found a route'
    if outcome != EXHAUSTED:
        return 'the limit of expansions was reached before a route was found'
    if without:
        return (
            f'no route is left on the exhausted graph without {len(without)} that did not survive'
        )
    return 'the graph of contact states is exhausted and holds no route to the goal'
