"""The tree of states at rest, and the queue of what is yet to be tried."""

import heapq
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wholearm_ros.mechanics.contacts import closed_pairs, pair_name
from wholearm_ros.model.configuration import POSE
from wholearm_ros.planning.best_first_search import Edge
from wholearm_ros.planning.new_subgoal import WIDE_ENOUGH
from wholearm_ros.planning.problem import PlanningProblem
from wholearm_ros.rollout.primitive_rollout import Rest, released
from wholearm_ros.search.arcs import TOUCHING, Arcs
from wholearm_ros.search.belief import Belief, Passage, Samples
from wholearm_ros.search.ways import Way

CELL = np.array([0.12, 0.12, 0.06, 0.15, 0.15])  # in scaled coordinates; states in one cell are one
EXPANSIONS = 400  # in the graph of arcs of every state but the start
REFUSAL_PRICE = 0.3  # [rad] of the rotation that is left, against a route that failed on the way
LOSS_PRICE = 1.0  # [rad] of the rotation that is left, against the loss of all samples


@dataclass(frozen=True, eq=False)
class State:
    """At rest after `way` from `parent` (place in the tree, −1 and None at the start).

    belief: where the samples are; paid: the price of what lies behind [rad]; margin: the least of
    the arcs so far [N m]; arcs: the graph to which it belongs, None when none is known yet; node:
    its place there, None on the way along an edge; descent: the edge whose caging descent begins
    here; goal: whether it is one.
    """

    rest: Rest
    belief: Belief
    parent: int
    way: Way | None
    paid: float = 0.0
    margin: float = WIDE_ENOUGH
    arcs: Arcs | None = None
    node: int | None = None
    descent: Edge | None = None
    goal: bool = False

    def then(self, k: int, way: Way, price: float, **changes: Any) -> 'State':
        """What a way leads to; k: place of this state."""
        after = State(way.rest, self.belief, k, way, self.paid + price, self.margin)
        return replace(after, **changes)


@dataclass(frozen=True, eq=False)
class _Attempt:
    """What is to be tried from state k on; refused: routes that had failed on the way to it."""

    k: int
    work: Callable[[], int | None]
    refused: int


class StateTree:
    """Grown best first: the price of a way out of a state is what was paid to get there, and what
    is still left to the goal in the best case.

    states: in the order in which they were found; primitives: simulated so far; limit: of
    expansions in each graph of arcs; openers: each queues the ways of one kind that leave a state.
    """

    def __init__(self, problem: PlanningProblem, samples: Samples, arcs: Arcs) -> None:
        self.problem, self._samples = problem, samples
        rest = released(problem.world, problem.start)
        self.states = [State(rest, samples.start, -1, None, arcs=arcs, node=0)]
        self.primitives, self.limit = 0, min(arcs.graph.limit, EXPANSIONS)
        self.openers: tuple[Callable[[int], None], ...] = ()
        self._queue: list[tuple[float, int, _Attempt]] = []
        self._pushed = 0
        # by cell, of routes that failed on the way to it
        self._refusals: Counter[tuple[int, ...]] = Counter()
        self._cells = [self.cell(problem.start)]  # of the states
        self._losses: dict[object, float] = {self._cells[0]: 0.0}

    @property
    def exhausted(self) -> bool:
        """Whether nothing is left to try."""
        return not self._queue

    @property
    def simulated(self) -> int:
        """How many simulations were made so far, of primitives and of samples."""
        return self.primitives + self._samples.rollouts

    def open(self, k: int) -> None:
        """Queue the ways that leave state k."""
        for opener in self.openers:
            opener(k)

    def push(self, k: int, price: float, work: Callable[[], int | None]) -> None:
        """Queue something from state k on that gives the place of a new state, or None."""
        refused = self.refusals(k)
        self._push(price + REFUSAL_PRICE * refused, _Attempt(k, work, refused))

    def refuse(self, k: int) -> None:
        """A route failed on the way to state k: what goes on from its cell is tried later."""
        self._refusals[self._cells[k]] += 1

    def refusals(self, k: int) -> int:
        """How many routes failed on the way to the cells of state k and of those before it."""
        if not self._refusals:
            return 0
        return sum(self._refusals[self._cells[p]] for p in self.places_to(k))

    def grow(self) -> int | None:
        """Do what is most promising; the place of a new state, or None when it came to nothing."""
        price, _, attempt = heapq.heappop(self._queue)
        refused = self.refusals(attempt.k)
        if refused > attempt.refused:
            later = REFUSAL_PRICE * (refused - attempt.refused)
            self._push(price + later, replace(attempt, refused=refused))
            return None
        return attempt.work()

    def _push(self, price: float, attempt: '_Attempt') -> None:
        self._pushed += 1
        heapq.heappush(self._queue, (price, self._pushed, attempt))

    def price_at(self, k: int, q: np.ndarray) -> float:
        """Of what leads from state k to q (5,)."""
        return self.states[k].paid + max(0.0, self.problem.rotation_left(q))

    def key(self, arcs: Arcs | None, node: int | None, q: np.ndarray) -> object:
        """What names a state at q (5,): its place in the first graph of arcs, else its cell, since
        later graphs hold the same contact states over and over.
        """
        return (arcs, node) if node is not None and arcs is self.states[0].arcs else self.cell(q)

    def known(self, key: object, loss: float) -> bool:
        """Whether a state with that key has lost as little."""
        return self._losses.get(key, np.inf) <= loss

    def execute(self, planned: State, key: object) -> int | None:
        """The samples of the parent execute the way of a planned state, to which their belief is
        added; its place when enough of them arrive.
        """
        before, way = self.states[planned.parent], planned.way
        assert way is not None, 'only the start has no way'
        if self.known(key, before.belief.loss):
            return None
        finger = -1 if before.way is None else before.way.finger
        passage = Passage(way.course, before.rest, finger, way.rest.q[POSE], planned.goal)
        belief = self._samples.after(passage, before.belief)
        if belief is None or self.known(key, belief.loss):
            return None
        self._losses[key] = belief.loss
        paid = planned.paid + LOSS_PRICE * (belief.loss - before.belief.loss)
        self.states.append(replace(planned, belief=belief, paid=paid))
        self._cells.append(self.cell(planned.rest.q))
        if not planned.goal:
            self.open(len(self.states) - 1)
        return len(self.states) - 1

    def places_to(self, k: int) -> list[int]:
        """Of the states on the way to state k, without the start."""
        places = []
        while k > 0:
            places.append(k)
            k = self.states[k].parent
        return places[::-1]

    def cell(self, q: np.ndarray) -> tuple[int, ...]:
        """The cell in which q (5,) lies."""
        return tuple(np.round(q / (CELL * self.problem.world.scale)).astype(int).tolist())

    def names(self, q: np.ndarray) -> tuple[str, ...]:
        """Of the pairs closed at q (5,), after a simulation."""
        return tuple(pair_name(c) for c in closed_pairs(self.problem.world, q, TOUCHING))
