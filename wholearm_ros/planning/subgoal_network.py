"""The subgoal network: X and Y subgoals with parents that can be walked back (III-A.1, III-A.2)."""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.mechanics.contacts import pair_name
from wholearm_ros.model.plan import X_END, X_GOAL, X_INIT, X_START, X_THROUGH, Leg, Subgoal, Y
from wholearm_ros.planning.new_subgoal import REACHED, Expansion
from wholearm_ros.planning.problem import PlanningProblem

SAME_CONFIGURATION = 1e-5  # [m, rad] five-contact subgoals nearer than this are one
Key = tuple[tuple[int, ...], tuple[int, ...]]


@dataclass(frozen=True, eq=False)
class Node:
    """Where an X_start can be attached: a five-contact subgoal Y, the start, or a landed object.

    number: of its subgoal; configuration: (5,) [m, rad]; pairs: closed there.
    """

    number: int
    configuration: np.ndarray
    pairs: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Attached:
    """Where an expansion ended: its node (None for a dead end), whether that node is new, and the
    numbers of the subgoals from X_start on.
    """

    node: Node | None
    new: bool
    numbers: tuple[int, ...]


class SubgoalNetwork:
    """Grows by expansions; its subgoals are numbered in order, from 1.

    subgoals: all of them; legs: by the number of the subgoal at which they end; nodes: X_init
    first, then every Y.
    """

    def __init__(self, problem: PlanningProblem) -> None:
        self.problem = problem
        self.subgoals: list[Subgoal] = []
        self.legs: dict[int, Leg] = {}
        self._known: dict[Key, Node] = {}
        self._costs: dict[int, tuple[float, float]] = {}
        first = self._add(X_INIT, problem.start, problem.pairs, 0, None)
        self.nodes = [Node(first, problem.start, problem.pairs)]
        self._known[self._key(problem.start, problem.pairs)] = self.nodes[0]

    def attach(
        self, node: Node, pairs: tuple[int, ...], direction: int, expansion: Expansion
    ) -> Attached:
        """Record an expansion from X_start = (node, pairs); Generate_Y where it ends in a Y."""
        chain = [self._add(X_START, node.configuration, pairs, direction, node.number)]
        lives = bool(expansion.arcs) and (expansion.outcome == REACHED or len(expansion.pairs) > 0)
        for k, arc in enumerate(expansion.arcs):
            last = k == len(expansion.arcs) - 1
            if last and not lives:
                break  # a dead end leaves its X_start and X_through only
            kind = X_THROUGH if not last else X_GOAL if expansion.outcome == REACHED else X_END
            number = self._add(kind, arc.configurations[-1], arc.pairs, direction, chain[-1])
            self.legs[number] = Leg(
                chain[-1], number, arc.mode, tuple(map(pair_name, arc.pairs)), arc.configurations
            )
            chain.append(number)
        if not lives:
            return Attached(None, False, tuple(chain))
        self._costs[chain[-1]] = expansion.margin(), expansion.cost(self.problem.world.scale)
        if expansion.outcome == REACHED:
            return Attached(Node(chain[-1], expansion.end, expansion.pairs), True, tuple(chain))
        known, new = self._five_contact_node(expansion, chain[-1])
        return Attached(known, new, tuple(chain))

    def route_to(self, number: int) -> tuple[tuple[int, ...], tuple[Leg, ...]]:
        """(numbers from X_init, legs) by walking the parents back."""
        numbers: list[int] = []
        parent: int | None = number
        while parent is not None:
            numbers.append(parent)
            parent = self.subgoals[parent - 1].parent
        numbers.reverse()
        return tuple(numbers), tuple(self.legs[n] for n in numbers if n in self.legs)

    def cost_to(self, number: int) -> tuple[float, float]:
        """(margin [N m], cost) of the route that `route_to` gives, as the best search counts
        them.
        """
        numbers, _ = self.route_to(number)
        parts = [self._costs[n] for n in numbers if n in self._costs]
        return min(margin for margin, _ in parts), sum(cost for _, cost in parts)

    def counts(self) -> dict[str, int]:
        """How many subgoals there are, of each number of contacts."""
        kinds = [s.kind for s in self.subgoals]
        five = kinds.count(Y)
        return {
            'subgoals': len(kinds),
            'four_contact_subgoals': len(kinds) - five,
            'five_contact_subgoals': five,
        }

    def _five_contact_node(self, expansion: Expansion, parent: int) -> tuple[Node, bool]:
        """The node in which an expansion ends, and whether it is new."""
        key = self._key(expansion.end, expansion.pairs)
        new = key not in self._known
        if new:
            number = self._add(Y, expansion.end, expansion.pairs, 0, parent)
            self._known[key] = Node(number, expansion.end, expansion.pairs)
            self.nodes.append(self._known[key])
        return self._known[key], new

    def _add(
        self, kind: str, q: np.ndarray, pairs: tuple[int, ...], direction: int, parent: int | None
    ) -> int:
        number = len(self.subgoals) + 1
        self.subgoals.append(
            Subgoal(number, kind, q, tuple(map(pair_name, pairs)), int(direction), parent)
        )
        return number

    @staticmethod
    def _key(q: np.ndarray, pairs: tuple[int, ...]) -> Key:
        return pairs, tuple(np.round(q / SAME_CONFIGURATION).astype(np.int64).tolist())
