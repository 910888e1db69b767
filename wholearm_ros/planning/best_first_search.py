"""Best route on the graph of arcs: the widest torque margin first, then the fewest contact-state
changes, then the least motion.

The margin of a route is its least robust half width of the torque range (a bottleneck); the other
two criteria are sums. A bottleneck and sums cannot be minimised in one sweep, so there are two. The
first finds the widest margin W by best-first search with lazily traced arcs; it may stop when the
goal is taken from the queue, because whatever is left is narrower. The second finds the cheapest
route among the arcs at least as wide as W, tracing what the first left out. The answer is optimal
on the graph.
"""

import heapq
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import count
from typing import Any, NamedTuple

import numpy as np

from wholearm_ros.mechanics.contacts import four_contact_subsets
from wholearm_ros.model.plan import EXHAUSTED, FOUND, LIMIT_REACHED, TIME_SPENT
from wholearm_ros.planning.arc import tangent
from wholearm_ros.planning.new_subgoal import REACHED, WIDE_ENOUGH, new_subgoal
from wholearm_ros.planning.problem import PlanningProblem
from wholearm_ros.planning.subgoal_network import Node, SubgoalNetwork

Choice = tuple[tuple[int, ...], int, int]  # four pairs to keep, the side, which of the expansions
EdgeKey = tuple[int, Choice]  # the start of an edge and its choice


@dataclass(frozen=True, eq=False)
class Edge:
    """An expansion as an edge of the graph, from a node (by its place in the network) to another,
    or to the goal (None).

    margin [N m] and cost: see above; numbers: of its subgoals in the network, X_start to X_end.
    """

    start: int
    choice: Choice
    end: int | None
    margin: float
    cost: float
    numbers: tuple[int, ...]

    @property
    def key(self) -> EdgeKey:
        """What names the edge in the graph."""
        return self.start, self.choice


class BestRoute(NamedTuple):
    """outcome: see ContactPlan; edges: of the route, empty when there is none; margin [N m], cost:
    see above.
    """

    outcome: str
    edges: tuple[Edge, ...]
    margin: float
    cost: float


@dataclass(eq=False)
class ArcGraph:
    """The graph of a problem; its edges are traced when they are first asked for, and kept.

    limit: of expansions; stop: whether to give up, asked before each node; traced: expansions so
    far; edges: those that leave each node, by its place.
    """

    problem: PlanningProblem
    limit: int
    stop: Callable[[], bool] = lambda: False
    network: SubgoalNetwork = field(init=False)
    traced: int = field(default=0, init=False)
    edges: dict[int, tuple[Edge, ...]] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        self.network = SubgoalNetwork(self.problem)
        self._place = {self.network.nodes[0].number: 0}

    @property
    def exhausted(self) -> bool:
        """Whether every edge of every node has been traced."""
        return len(self.edges) == len(self.network.nodes)

    def edges_from(self, k: int) -> tuple[Edge, ...]:
        """Every edge that leaves node k."""
        if k not in self.edges:
            node = self.network.nodes[k]
            self.edges[k] = tuple(
                edge
                for pairs in four_contact_subsets(node.pairs)
                for sign in (1, -1)
                for edge in self._trace(k, node, pairs, sign)
            )
        return self.edges[k]

    def _trace(self, k: int, node: Node, pairs: tuple[int, ...], sign: int) -> Iterator[Edge]:
        self.traced += 1
        toward = sign * tangent(self.problem, node.configuration, pairs)
        expansions = new_subgoal(self.problem, node.configuration, pairs, toward)
        for which, expansion in enumerate(expansions):
            if not expansion.arcs:
                continue
            attached = self.network.attach(node, pairs, sign, expansion)
            if attached.node is None:
                continue
            end = None
            if expansion.outcome != REACHED:
                newest = len(self.network.nodes) - 1
                end = self._place.setdefault(attached.node.number, newest)
            margin, cost = expansion.margin(), expansion.cost(self.problem.world.scale)
            yield Edge(k, (pairs, sign, which), end, margin, cost, attached.numbers)


def best_route(graph: ArcGraph, without: frozenset[EdgeKey] = frozenset()) -> BestRoute:
    """The best route that uses none of the edges `without`."""
    outcome, margin = _widest(graph, without)
    if outcome != FOUND:
        return BestRoute(outcome, (), -np.inf, np.inf)
    outcome, edges, cost = _cheapest(graph, without, margin)
    return BestRoute(outcome, edges, margin, cost)


def _widest(graph: ArcGraph, without: frozenset[EdgeKey]) -> tuple[str, float]:
    """(outcome, the widest margin with which the goal can be reached [N m])."""
    order, done = count(), set()
    queue: list[tuple[float, int, int | None]] = [(-WIDE_ENOUGH, next(order), 0)]
    while queue:
        width, _, k = heapq.heappop(queue)
        if k is None:
            return FOUND, -width
        if k in done:
            continue
        done.add(k)
        if graph.traced > graph.limit:
            return LIMIT_REACHED, -np.inf
        if graph.stop():
            return TIME_SPENT, -np.inf
        for edge in _usable(graph, k, without):
            heapq.heappush(queue, (max(width, -edge.margin), next(order), edge.end))
    return EXHAUSTED, -np.inf


def _cheapest(
    graph: ArcGraph, without: frozenset[EdgeKey], margin: float
) -> tuple[str, tuple[Edge, ...], float]:
    """(outcome, edges, cost) of the cheapest route among the edges at least as wide as `margin`."""
    order, done = count(), set()
    # cost, order, place of the node, and the way to it as nested pairs (edge, way before it)
    queue: list[tuple[float, int, int | None, Any]] = [(0.0, next(order), 0, None)]
    while queue:
        cost, _, k, trail = heapq.heappop(queue)
        if k is None:
            return FOUND, _unwind(trail), cost
        if k in done:
            continue
        if graph.stop():
            return TIME_SPENT, (), np.inf
        done.add(k)
        for edge in _usable(graph, k, without):
            if edge.margin >= margin:
                heapq.heappush(queue, (cost + edge.cost, next(order), edge.end, (edge, trail)))
    raise AssertionError('the widest route was found, so there is a cheapest one')


def _usable(graph: ArcGraph, k: int, without: frozenset[EdgeKey]) -> list[Edge]:
    return [edge for edge in graph.edges_from(k) if edge.key not in without]


def _unwind(trail: Any) -> tuple[Edge, ...]:
    edges = []
    while trail is not None:
        edge, trail = trail
        edges.append(edge)
    return tuple(reversed(edges))
