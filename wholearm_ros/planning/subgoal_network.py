"""The subgoal network: X and Y subgoals with parents that can be walked (III-A.1, III-A.2)."""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.mechanics.contacts import pair_name
from wholearm_ros.model.plan import X_END, X_GOAL, X_INIT, X_START, X_THROUGH, Leg, Subgoal, Y
from wholearm_ros.planning.new_subgoal import REACHED, Expansion
from wholearm_ros.planning.problem import PlanningProblem

SAME_CONFIGURATION = 1e-5  # [m, rad] five-contact subgoals nearer than this are one


@dataclass(frozen=True, eq=False)
class Node:
    """A five-contact subgoal Y, the start, or a landed object: where new X_start can be attached. pairs: closed there."""

    number: int
    configuration: np.ndarray
    pairs: tuple


@dataclass(frozen=True, eq=False)
class Attached:
    """Where an expansion ended: its node (None for a dead end), whether that is new, and the numbers from X_start on."""

    node: Node
    new: bool
    numbers: tuple


class SubgoalNetwork:
    """Grows by expansions; numbers are given in order, from 1."""

    def __init__(self, task: PlanningProblem):
        self.task = task
        self.subgoals, self.legs, self._known, self._costs = [], {}, {}, {}
        first = self._add(X_INIT, task.start, task.pairs, 0, None)
        self.nodes = [Node(first, task.start, task.pairs)]
        self._known[self._key(task.start, task.pairs)] = self.nodes[0]

    def attach(self, node: Node, pairs: tuple, direction: int, expansion: Expansion) -> 'Attached':
        """Record an expansion from X_start = (node, pairs)."""
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
        self._costs[chain[-1]] = expansion.margin(), expansion.cost(self.task.world.scale)
        if expansion.outcome == REACHED:
            return Attached(Node(chain[-1], expansion.end, expansion.pairs), True, tuple(chain))
        key = self._key(expansion.end, expansion.pairs)
        new = key not in self._known
        if new:
            number = self._add(Y, expansion.end, expansion.pairs, 0, chain[-1])
            self._known[key] = Node(number, expansion.end, expansion.pairs)
            self.nodes.append(self._known[key])
        return Attached(self._known[key], new, tuple(chain))

    def route_to(self, number: int) -> tuple:
        """(numbers from X_init, legs) by walking the parents back."""
        numbers = []
        while number is not None:
            numbers.append(number)
            number = self.subgoals[number - 1].parent
        numbers.reverse()
        return tuple(numbers), tuple(self.legs[n] for n in numbers if n in self.legs)

    def cost_to(self, number: int) -> tuple:
        """(margin [N m], cost) of the route that `route_to` gives, as the best search counts them."""
        numbers, _ = self.route_to(number)
        parts = [self._costs[n] for n in numbers if n in self._costs]
        return min(margin for margin, _ in parts), sum(cost for _, cost in parts)

    def counts(self) -> dict:
        kinds = [s.kind for s in self.subgoals]
        five = kinds.count(Y)
        return {
            'subgoals': len(kinds),
            'four_contact_subgoals': len(kinds) - five,
            'five_contact_subgoals': five,
        }

    def _add(self, kind, q, pairs, direction, parent):
        number = len(self.subgoals) + 1
        self.subgoals.append(
            Subgoal(number, kind, q, tuple(map(pair_name, pairs)), int(direction), parent)
        )
        return number

    @staticmethod
    def _key(q, pairs):
        return pairs, tuple(np.round(q / SAME_CONFIGURATION).astype(np.int64).tolist())
