"""Routes of dynamic primitives, where the graph of four-contact arcs holds none that survives.

A tree of states at rest, grown best first. A state is left by motion primitives; forward dynamics
says where each of them takes the object. What it leads to becomes a new state only if everything
comes to rest there, and if the particles, perturbed samples of the scenario that execute every
primitive so far in closed loop, end up in nearly the same place: what physics does not do reliably
is not built upon. This is the dynamic manipulation of III-B.2 as a step of the search.
"""

import heapq
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wholearm_ros.mechanics.contacts import closed_pairs, pair_name
from wholearm_ros.model.configuration import JOINTS, POSE, ROTATION
from wholearm_ros.model.modes import CAGING, DYNAMIC
from wholearm_ros.model.motion_primitive import MotionPrimitive
from wholearm_ros.model.plan import X_END, X_GOAL, X_INIT, Leg, Subgoal, Y
from wholearm_ros.planning.caging_descent import caging_descent
from wholearm_ros.planning.particles import Particles, ParticleStates
from wholearm_ros.planning.primitive_candidates import (
    LONG_SETTLE,
    STYLES,
    TOUCHING,
    Style,
    flings,
    stops_along,
    sweeps,
)
from wholearm_ros.planning.problem import PlanningProblem
from wholearm_ros.rollout.parallel import parallel_map
from wholearm_ros.rollout.primitive_rollout import PrimitiveRecord, Rest, simulate_primitive

CELL = np.array([0.1, 0.1, 0.06, 0.12, 0.12])  # in scaled coordinates; states in one cell are one
DEPTH_COST = 0.06  # [rad] of a primitive, against the rotation that is left
SAMPLE_EVERY = 10  # of a primitive's records, kept in its leg
Route = tuple[list[Subgoal], list[Leg]]


@dataclass(frozen=True, eq=False)
class State:
    """At rest after `record` from `parent` (place in the tree, −1 at the start, where there is no
    record); particles: where each of them is; depth: primitives since the start.
    """

    rest: Rest
    particles: ParticleStates
    parent: int
    record: PrimitiveRecord | None
    depth: int


class PrimitiveTree:
    """The tree and the queue of primitives yet to be tried; `grow` takes one of them.

    states: in the order in which they were found.
    """

    def __init__(self, problem: PlanningProblem, seed: int, style: Style = STYLES[0]) -> None:
        self.problem, self._style = problem, style
        self._particles = Particles(problem, seed + 1)
        rest = Rest(problem.start, problem.world.finger_moment * np.cos(problem.start[JOINTS]))
        self.states = [State(rest, self._particles.start, -1, None, 0)]
        self._queue: list[tuple[float, int, int, MotionPrimitive]] = []
        self._order, self._primitives = 0, 0
        self._seen = {self._cell(problem.start)}
        self._branch(0)

    @property
    def open(self) -> bool:
        """Whether a primitive is left to try."""
        return bool(self._queue)

    @property
    def simulated(self) -> int:
        """How many simulations were made so far, of primitives and of particles."""
        return self._primitives + self._particles.rollouts

    def grow(self) -> int | None:
        """Place of a new state, or None when the most promising primitive came to nothing."""
        _, _, parent, move = heapq.heappop(self._queue)
        before = self.states[parent]
        record = self._brought_to_rest(before.rest, move)
        end = record.configurations[-1]
        if not record.at_rest or record.stops_met.any() or self.problem.hopeless(end):
            return None
        cell = self._cell(end)
        if cell in self._seen:
            return None
        side = -1 if before.record is None else before.record.move.velocity_finger
        particles = self._particles.after(record, before.rest, before.particles, side)
        if particles is None:
            return None
        self._seen.add(cell)
        self.states.append(State(record.rest(), particles, parent, record, before.depth + 1))
        self._branch(len(self.states) - 1)
        return len(self.states) - 1

    def route_to(self, k: int) -> Route:
        """(subgoals, legs) from the start to state k."""
        states = []
        while k >= 0:
            states.append(self.states[k])
            k = self.states[k].parent
        states.reverse()
        first = states[0].rest.q
        subgoals, legs = [Subgoal(1, X_INIT, first, self._names(first))], []
        for number, state in enumerate(states[1:], start=2):
            assert state.record is not None, 'only the start has no record'
            names, move = self._names(state.rest.q), state.record.move
            kind, turn = Y if len(names) > 4 else X_END, int(np.sign(move.turn))
            samples = _samples(subgoals[-1].configuration, state.record)
            subgoals.append(Subgoal(number, kind, state.rest.q, names, turn, number - 1))
            legs.append(Leg(number - 1, number, DYNAMIC, names, samples, move.to_dict()))
        return subgoals, legs

    def _names(self, q: np.ndarray) -> tuple[str, ...]:
        return tuple(pair_name(c) for c in closed_pairs(self.problem.world, q, TOUCHING))

    def _brought_to_rest(self, rest: Rest, move: MotionPrimitive) -> PrimitiveRecord:
        """The primitive simulated, with a longer pause after it where it does not end at rest."""
        (record,) = self._simulate(rest, [move])
        if record.at_rest or move.settle >= LONG_SETTLE:
            return record
        if self.problem.hopeless(record.configurations[-1]):
            return record
        (record,) = self._simulate(rest, [replace(move, settle=LONG_SETTLE)])
        return record

    def _branch(self, k: int) -> None:
        """Queue the primitives that may leave state k: to stops along sweeps, and flings."""
        state = self.states[k]
        tried = sweeps(self.problem, state.rest.q, self._style)
        for sweep, record in zip(tried, self._simulate(state.rest, tried)):
            for move, q in stops_along(self.problem, state.rest, sweep, record):
                if self._cell(q) not in self._seen:
                    self._push(k, q, move)
        quick = flings(self.problem, state.rest.q)
        for fling, record in zip(quick, self._simulate(state.rest, quick)):
            q = record.configurations[-1]
            past_the_top = record.at_rest and self.problem.rotation_left(q) < 0.0
            if past_the_top and not self.problem.hopeless(q):
                self._push(k, q, fling)

    def _push(self, k: int, q: np.ndarray, move: MotionPrimitive) -> None:
        """Queue a primitive that leaves state k towards q (5,)."""
        self._order += 1
        left = max(0.0, self.problem.rotation_left(q))
        cost = left + DEPTH_COST * (self.states[k].depth + 1)
        heapq.heappush(self._queue, (cost, self._order, k, move))

    def _simulate(self, rest: Rest, moves: list[MotionPrimitive]) -> list[PrimitiveRecord]:
        """The records of primitives from rest."""
        self._primitives += len(moves)
        return list(parallel_map(partial(simulate_primitive, self.problem.world, rest), moves))

    def _cell(self, q: np.ndarray) -> tuple[int, ...]:
        return tuple(np.round(q / (CELL * self.problem.world.scale)).astype(int).tolist())


def primitive_tree_search(
    problem: PlanningProblem,
    tree: PrimitiveTree,
    limit: int,
    stop: Callable[[], bool] = lambda: False,
) -> Route | None:
    """(subgoals, legs) of the next route that the tree finds to the goal, or None without one.

    limit: of simulated primitives in the whole tree; stop: whether to give up, asked now and then.
    """
    while tree.open and tree.simulated < limit and not stop():
        k = tree.grow()
        if k is None:
            continue
        q = tree.states[k].rest.q
        if problem.reached(q[POSE]):
            return tree.route_to(k)
        cage = problem.cage_at(q[ROTATION])
        down = caging_descent(problem, q, cage) if cage is not None else None
        if down is not None and problem.reached(down[-1, POSE]):
            return _with_descent(problem, tree.route_to(k), down)
    return None


def _with_descent(problem: PlanningProblem, route: Route, down: np.ndarray) -> Route:
    """A route that ends with the caging descent `down` (m, 5)."""
    subgoals, legs = route
    names = tuple(map(pair_name, closed_pairs(problem.world, down[-1])))
    number = len(subgoals) + 1
    goal = Subgoal(number, X_GOAL, down[-1], names, 0, number - 1)
    return [*subgoals, goal], [*legs, Leg(number - 1, number, CAGING, names, down)]


def _samples(start: np.ndarray, record: PrimitiveRecord) -> np.ndarray:
    """(m, 5) the start, every tenth record and the last."""
    last = len(record.configurations) - 1
    places = [*range(SAMPLE_EVERY, last, SAMPLE_EVERY), last]
    return np.vstack([start[None], record.configurations[places]])
