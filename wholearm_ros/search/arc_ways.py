"""Arcs as ways out of a state: along an edge of its graph to the next node, to where the object is
released into a cage, or half of the way.
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wholearm_ros.model.modes import CAGING
from wholearm_ros.model.plan import Leg
from wholearm_ros.planning.best_first_search import Edge
from wholearm_ros.planning.new_subgoal import WIDE_ENOUGH
from wholearm_ros.search.arcs import Arcs, arcs_from
from wholearm_ros.search.state_tree import State, StateTree
from wholearm_ros.search.ways import executed, way_along
from wholearm_ros.trajectory.execution_options import AUTO, REAR

# Prices, against a radian of the rotation that is left
WIDTH_PRICE = 0.5  # of a newton metre by which an arc is narrower than it need be
COST_PRICE = 0.01  # of the cost of an edge
ASIDE_PRICE = 0.06  # of an arc from which no other one leads to the goal
LATER = 0.03  # of another way to execute the same arc
LONG = 0.3  # [rad] an arc on the way of which a stop is worth it


@dataclass(frozen=True, eq=False)
class ArcWays:
    """Along the edges of a state's graph, which is found when it is its turn."""

    tree: StateTree

    def open(self, k: int) -> None:
        """Queue those that leave state k."""
        state = self.tree.states[k]
        if state.node is not None:
            self._push_edges(k)
        elif state.arcs is None:
            self.tree.push(k, self.tree.price_at(k, state.rest.q), partial(self._find_graph, k))

    def _find_graph(self, k: int) -> None:
        """Of a state to which a simulation led."""
        arcs = arcs_from(self.tree.problem, self.tree.states[k].rest.q, self.tree.limit)
        if arcs is not None:
            self.tree.states[k] = replace(self.tree.states[k], arcs=arcs, node=0)
            self._push_edges(k)

    def _push_edges(self, k: int) -> None:
        state = self.tree.states[k]
        assert state.arcs is not None and state.node is not None
        for edge in state.arcs.graph.edges.get(state.node, ()):
            price = self._price(state, state.arcs, edge)
            for number, finger in enumerate((AUTO, REAR)):
                self.tree.push(k, price + number * LATER, partial(self._along, k, edge, finger))
            leg = state.arcs.legs(edge)[0]
            if leg.mode != CAGING and _length(leg, self.tree.problem.world.scale) > LONG:
                middle = leg.configurations[len(leg.configurations) // 2]
                price = self.tree.price_at(k, middle) + ASIDE_PRICE + LATER
                self.tree.push(k, price, partial(self._half, k, leg))

    def _price(self, state: State, arcs: Arcs, edge: Edge) -> float:
        margin, cost = arcs.beyond(edge)
        leads_on = np.isfinite(cost)
        margin = min(state.margin, margin if leads_on else edge.margin)
        price = state.paid + WIDTH_PRICE * (WIDE_ENOUGH - margin)
        if leads_on:
            return float(price + COST_PRICE * cost)
        end = arcs.legs(edge)[-1].configurations[-1]
        return price + ASIDE_PRICE + max(0.0, self.tree.problem.rotation_left(end))

    def _along(self, k: int, edge: Edge, finger: str) -> int | None:
        """To the end of an edge, or to where its caging descent begins."""
        state = self.tree.states[k]
        assert state.arcs is not None
        legs, numbers, node = state.arcs.legs(edge), edge.numbers, edge.end
        caged = legs[-1].mode == CAGING
        if caged:
            legs, numbers, node = legs[:-1], numbers[:-1], None
        goal = edge.end is None and not caged
        end = legs[-1].configurations[-1]
        key: object = (k, edge.key, finger) if goal else self.tree.key(state.arcs, node, end)
        if caged:
            key = 'release', key
        if self.tree.known(key, state.belief.loss):
            return None
        action = {} if finger == AUTO else {'velocity_finger': finger}
        way = way_along(
            self.tree.problem.world, state.rest, [executed(leg, **action) for leg in legs]
        )
        if way is None:
            return None
        if node is not None:
            numbers = (*numbers, state.arcs.number(node))
        after = state.then(
            k,
            replace(way, arcs=state.arcs, numbers=numbers),
            COST_PRICE * edge.cost,
            margin=min(state.margin, edge.margin),
            arcs=state.arcs,
            node=node,
            descent=edge if caged else None,
            goal=goal,
        )
        return self.tree.execute(after, key)

    def _half(self, k: int, leg: Leg) -> int | None:
        """To rest in the middle of an arc, from where primitives may go on."""
        state, count = self.tree.states[k], len(leg.configurations) // 2 + 1
        half = replace(leg, configurations=leg.configurations[:count])
        key = self.tree.cell(half.configurations[-1])
        if self.tree.known(key, state.belief.loss):
            return None
        way = way_along(self.tree.problem.world, state.rest, [half])
        if way is None:
            return None
        return self.tree.execute(state.then(k, way, ASIDE_PRICE, arcs=state.arcs), key)


def _length(leg: Leg, scale: np.ndarray) -> float:
    """In scaled coordinates [rad]."""
    return float(np.linalg.norm(np.diff(leg.configurations, axis=0) / scale, axis=1).sum())
