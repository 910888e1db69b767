"""Best route on the graph of arcs: the widest torque margin first, then the fewest contact-state changes, then the least motion.

The margin of a route is its least robust half width of the torque range (a bottleneck), the other two are sums. A bottleneck
and sums cannot be minimised in one sweep, so there are two: the first finds the widest margin W by best-first search with
lazily traced arcs (it may stop when the goal is taken from the queue: whatever is left is narrower); the second finds the
cheapest route among the arcs at least as wide as W, tracing what the first left out. The answer is optimal on the graph.
"""

import heapq
from dataclasses import dataclass, field
from itertools import count
from typing import Callable

import numpy as np

from wholearm_ros.mechanics.contacts import four_contact_subsets
from wholearm_ros.model.plan import EXHAUSTED, FOUND, LIMIT_REACHED, TIME_SPENT
from wholearm_ros.planning.arc import tangent
from wholearm_ros.planning.new_subgoal import REACHED, WIDE_ENOUGH, new_subgoal
from wholearm_ros.planning.problem import PlanningProblem
from wholearm_ros.planning.subgoal_network import SubgoalNetwork


@dataclass(frozen=True, eq=False)
class Edge:
    """An expansion as an edge of the graph: from a node (by its place in the network) to another, or to the goal (None).

    choice: the pairs, the side and which of the expansions; margin [N m] and cost: see above; numbers: of its subgoals in the network, X_start to X_end.
    """

    start: int
    choice: tuple
    end: int
    margin: float
    cost: float
    numbers: tuple


@dataclass(eq=False)
class ArcGraph:
    """The graph of a problem, its edges traced when they are first asked for, and kept.

    limit: of expansions; stop: whether to give up, asked before each node.
    """

    task: PlanningProblem
    limit: int
    stop: Callable[[], bool] = lambda: False
    network: SubgoalNetwork = None
    traced: int = 0
    edges: dict = field(default_factory=dict)

    def __post_init__(self):
        self.network = SubgoalNetwork(self.task)
        self._place = {self.network.nodes[0].number: 0}

    @property
    def exhausted(self) -> bool:
        """Whether every edge of every node has been traced."""
        return len(self.edges) == len(self.network.nodes)

    def edges_from(self, k: int) -> tuple:
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

    def _trace(self, k, node, pairs, sign):
        self.traced += 1
        toward = sign * tangent(self.task, node.configuration, pairs)
        for place, expansion in enumerate(
            new_subgoal(self.task, node.configuration, pairs, toward)
        ):
            if not expansion.arcs:
                continue
            attached = self.network.attach(node, pairs, sign, expansion)
            if attached.node is not None:
                end = (
                    None
                    if expansion.outcome == REACHED
                    else self._place.setdefault(attached.node.number, len(self.network.nodes) - 1)
                )
                yield Edge(
                    k,
                    (pairs, sign, place),
                    end,
                    expansion.margin(),
                    expansion.cost(self.task.world.scale),
                    attached.numbers,
                )


def best_route(graph: ArcGraph, without: frozenset = frozenset()):
    """(outcome, edges of the best route, margin W [N m], cost). `without`: edges, as (start, choice), not to be used."""
    outcome, margin = _widest(graph, without)
    if outcome != FOUND:
        return outcome, (), -np.inf, np.inf
    outcome, edges, cost = _cheapest(graph, without, margin)
    return outcome, edges, margin, cost


def _widest(graph, without):
    order, done = count(), set()
    queue = [(-WIDE_ENOUGH, next(order), 0)]
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


def _cheapest(graph, without, margin):
    order, done = count(), set()
    queue = [(0.0, next(order), 0, None)]
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


def _usable(graph, k, without):
    return [edge for edge in graph.edges_from(k) if (edge.start, edge.choice) not in without]


def _unwind(trail):
    edges = []
    while trail is not None:
        edge, trail = trail
        edges.append(edge)
    return tuple(reversed(edges))
