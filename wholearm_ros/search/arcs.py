"""The arcs that leave a state at rest: the graph of contact states from there, without physics, as
what guides the search.
"""

import heapq
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from wholearm_ros.mechanics.contacts import closed_pairs, contact_rows
from wholearm_ros.model.plan import Leg
from wholearm_ros.planning.best_first_search import ArcGraph, Edge
from wholearm_ros.planning.new_subgoal import WIDE_ENOUGH
from wholearm_ros.planning.problem import PlanningProblem

TOUCHING = 2e-4  # [m] gap of a closed pair after a simulation
CLOSED = 1e-9  # [m] gap that a projection leaves
FEWEST = 4  # closed pairs from which an arc can leave


class Prospect(NamedTuple):
    """What is left to the goal along arcs: the widest margin [N m], and the cost of such a way."""

    margin: float
    cost: float


NO_WAY = Prospect(-np.inf, np.inf)


@dataclass(frozen=True, eq=False)
class Arcs:
    """A whole graph of arcs and the prospect of each of its nodes, by its place; of the goal, whose
    place is None, too.
    """

    graph: ArcGraph
    prospects: dict[int | None, Prospect]

    def legs(self, edge: Edge) -> tuple[Leg, ...]:
        """Along an edge."""
        return tuple(self.graph.network.legs[number] for number in edge.numbers[1:])

    def number(self, node: int) -> int:
        """Of the subgoal that a node is."""
        return self.graph.network.nodes[node].number

    def beyond(self, edge: Edge) -> Prospect:
        """The prospect of the start of an edge that goes along it."""
        end = self.prospects.get(edge.end, NO_WAY)
        return Prospect(min(edge.margin, end.margin), edge.cost + end.cost)


def arcs_from(problem: PlanningProblem, q: np.ndarray, limit: int) -> Arcs | None:
    """The arcs from q (5,), at rest after a simulation; None where no arc can leave.

    limit: of expansions.
    """
    pairs = closed_pairs(problem.world, q, TOUCHING)
    closed = _closed(problem, q, pairs) if len(pairs) >= FEWEST else None
    if closed is None:
        return None
    return whole_graph(replace(problem, start=closed, pairs=pairs), limit)


def whole_graph(
    problem: PlanningProblem, limit: int, stop: Callable[[], bool] = lambda: False
) -> Arcs:
    """All arcs that can be reached from the start of a problem, in so many expansions.

    stop: whether to give up, asked before each node.
    """
    graph, k = ArcGraph(problem, limit), 0
    while k < len(graph.network.nodes) and graph.traced <= limit and not stop():
        graph.edges_from(k)
        k += 1
    return Arcs(graph, _prospects(graph))


def _prospects(graph: ArcGraph) -> dict[int | None, Prospect]:
    """Of every node from which the goal can be reached, backwards from the goal."""
    into: dict[int | None, list[Edge]] = {}
    for edges in graph.edges.values():
        for edge in edges:
            into.setdefault(edge.end, []).append(edge)
    found: dict[int | None, Prospect] = {}
    queue: list[tuple[float, float, int]] = [(-WIDE_ENOUGH, 0.0, -1)]  # the goal is −1 here
    while queue:
        margin, cost, place = heapq.heappop(queue)
        k = None if place < 0 else place
        if k in found:
            continue
        found[k] = Prospect(-margin, cost)
        for edge in into.get(k, []):
            heapq.heappush(queue, (max(margin, -edge.margin), cost + edge.cost, edge.start))
    return found


def _closed(problem: PlanningProblem, q: np.ndarray, pairs: tuple[int, ...]) -> np.ndarray | None:
    """(5,) the nearest configuration at which the pairs are closed, None when there is none."""
    q, scale = q.copy(), problem.world.scale
    for _ in range(8):
        rows, gaps = contact_rows(problem.world, pairs, q)
        if np.abs(gaps).max() < CLOSED:
            return q
        q -= scale * np.linalg.lstsq(rows * scale, gaps, rcond=None)[0]
    return None
