"""Routes of dynamic moves, where the graph of four-contact arcs holds none that survives.

A tree of states at rest, grown best first. From each of them either finger is swept either way under a few torques of the
other one; forward dynamics says where the object goes, and every so far along a sweep is a place to stop. A stop becomes
a new state only if the move to it ends at rest, and if a few perturbed copies of the task, led through all moves so far
as the controllers would, end up in nearly the same place: what physics does not do reliably is not built upon.
"""

import heapq
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Callable

import numpy as np

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.kernels.rollout import Start
from wholearm_ros.mechanics.contacts import closed_pairs, four_contact_subsets, pair_name
from wholearm_ros.mechanics.quasistatic import build_quasistatics
from wholearm_ros.mechanics.torque_range import build_torque_range, solve_torque_range
from wholearm_ros.model.hand import CLOSING, LEFT, RIGHT
from wholearm_ros.model.motion_primitive import MotionPrimitive
from wholearm_ros.model.plan import X_END, X_GOAL, X_INIT, Leg, Subgoal, Y
from wholearm_ros.model.trajectory import CAGING, DYNAMIC
from wholearm_ros.planning.caging_descent import caging_descent
from wholearm_ros.planning.problem import PlanningProblem
from wholearm_ros.rollout.parallel import parallel_map
from wholearm_ros.rollout.perturbed_samples import build_perturbed_samples, follow_course
from wholearm_ros.rollout.primitive_rollout import PrimitiveRecord, Rest, simulate_primitive

SWEEP = 0.9  # [rad]
STOP_EVERY = 0.1  # [rad] along a sweep
LONG_SETTLE = 0.6  # [s] for a move that does not end at rest at once
THROW_TURNS = (-0.5, -0.2, 0.2, 0.5)  # [rad]
THROW_TORQUES = (0.2, 1.0, 3.5)  # [N m]
THROW_SPEED, THROW_SLEW = 5.0, 50.0  # [rad/s], [N m/s]
THROW_WITHIN = 0.8  # [rad] of where the object may be let go
PARTICLES = 3  # perturbed copies besides the nominal one
SPREAD = 0.08  # in scaled coordinates, by which samples may differ from the plan
STILL = 0.05  # [1/s] in scaled coordinates, of a sample at rest
CELL = np.array(
    [0.1, 0.1, 0.06, 0.12, 0.12]
)  # in scaled coordinates; states in the same cell are one
DEPTH_COST = 0.06  # [rad] of a move, against the rotation that is left
TOUCHING = 2e-4  # [m] gap of a closed pair after a simulation
SAMPLE_EVERY = 10  # of a move's records, kept in its leg


@dataclass(frozen=True)
class Style:
    """Of a tree's sweeps: greatest speed [rad/s], and torques of the other finger [N m] towards closing."""

    speed: float
    torques: tuple


STYLES = Style(2.0, (0.05, 0.2, 0.6, 1.5, 3.5)), Style(1.2, (0.1, 0.35, 1.0, 2.5))


@dataclass(frozen=True, eq=False)
class State:
    """At rest after `record` from `parent` (place in the tree); copies: q, v (5,) of each particle."""

    rest: Rest
    copies: tuple
    parent: int
    record: PrimitiveRecord
    depth: int


class PrimitiveTree:
    """The tree, its open stops in a queue; `grow` takes one of them."""

    def __init__(self, task: PlanningProblem, seed: int, style: Style = STYLES[0]):
        self.task, self._style, self._controls = task, style, ControlOptions()
        self._copies = build_perturbed_samples(task.scenario, PARTICLES, 1.0, seed + 1)
        world = task.world
        rest = Rest(task.start, world.finger_moment * np.cos(task.start[3:]))
        self.states = [
            State(rest, tuple((c.start, np.zeros(5)) for c in self._copies), -1, None, 0)
        ]
        self._queue, self._order, self._seen, self.simulated = [], 0, {self._cell(task.start)}, 0
        self._sweep(0)

    @property
    def open(self) -> bool:
        """Whether a stop is left to grow from."""
        return bool(self._queue)

    def grow(self) -> int:
        """Place of a new state, or None when the best of the open stops came to nothing."""
        _, _, parent, move = heapq.heappop(self._queue)
        before = self.states[parent]
        (record,) = self._simulate(before.rest, [move])
        if (
            not record.at_rest
            and move.settle < LONG_SETTLE
            and not self.task.hopeless(record.configurations[-1])
        ):
            (record,) = self._simulate(before.rest, [replace(move, settle=LONG_SETTLE)])
        if (
            not record.at_rest
            or record.stops_met.any()
            or self.task.hopeless(record.configurations[-1])
        ):
            return None
        cell = self._cell(record.configurations[-1])
        if cell in self._seen:
            return None
        copies = self._led(before, record)
        if copies is None:
            return None
        self._seen.add(cell)
        self.states.append(State(record.rest(), copies, parent, record, before.depth + 1))
        self._sweep(len(self.states) - 1)
        return len(self.states) - 1

    def route_to(self, k: int) -> tuple:
        """(subgoals, legs) from the start to state k."""
        states = []
        while k >= 0:
            states.append(self.states[k])
            k = self.states[k].parent
        states.reverse()
        subgoals = [Subgoal(1, X_INIT, states[0].rest.q, self._names(states[0].rest.q))]
        legs = []
        for number, state in enumerate(states[1:], start=2):
            names = self._names(state.rest.q)
            move = state.record.move
            subgoals.append(
                Subgoal(
                    number,
                    Y if len(names) > 4 else X_END,
                    state.rest.q,
                    names,
                    int(np.sign(move.turn)),
                    number - 1,
                )
            )
            legs.append(
                Leg(
                    number - 1,
                    number,
                    DYNAMIC,
                    names,
                    _samples(subgoals[-2].configuration, state.record),
                    move.to_dict(),
                )
            )
        return subgoals, legs

    def _names(self, q):
        return tuple(pair_name(c) for c in closed_pairs(self.task.world, q, TOUCHING))

    def _sweep(self, k):
        """Open the stops that can be come to from state k."""
        state = self.states[k]
        sweeps = [
            MotionPrimitive(side, way * SWEEP, torque, self._style.speed, settle=0.0)
            for side in (LEFT, RIGHT)
            for way, torque in product((1.0, -1.0), self._torques(state.rest.q, 1 - side))
        ]
        for sweep, record in zip(sweeps, self._simulate(state.rest, sweeps)):
            self._open_stops(k, state, sweep, record)
        if self.task.caged_goal and self.task.rotation_left(state.rest.q) < THROW_WITHIN:
            self._open_throws(k, state)

    def _torques(self, q, side):
        """Torques of finger `side` worth trying from q: a few, and those in the ranges of its four-contact equilibria."""
        torques = list(self._style.torques)
        model_pairs = four_contact_subsets(closed_pairs(self.task.world, q, TOUCHING))
        for pairs in model_pairs:
            model = build_quasistatics(self.task.world, pairs, q)
            found = solve_torque_range(
                build_torque_range(model, side, self.task.world.torque_limits)
            )
            if found.empty:
                continue
            ends = sorted(CLOSING[side] * (np.array([found.low, found.high]) - model.g_h[side]))
            wanted = ends[0] + min(0.5, 0.5 * (ends[1] - ends[0]))
            if all(abs(wanted - other) > 0.2 * abs(other) for other in torques):
                torques.append(float(wanted))
        return torques

    def _open_throws(self, k, state):
        """Quick moves after which the object comes to rest past the top: momentum carries it over what no torque holds."""
        throws = [
            MotionPrimitive(side, turn, torque, THROW_SPEED, LONG_SETTLE, THROW_SLEW)
            for side, turn, torque in product((LEFT, RIGHT), THROW_TURNS, THROW_TORQUES)
        ]
        for throw, record in zip(throws, self._simulate(state.rest, throws)):
            q = record.configurations[-1]
            if record.at_rest and self.task.rotation_left(q) < 0.0 and not self.task.hopeless(q):
                self._open(k, state, q, throw)

    def _open(self, k, state, q, move):
        self._order += 1
        cost = max(0.0, self.task.rotation_left(q)) + DEPTH_COST * (state.depth + 1)
        heapq.heappush(self._queue, (cost, self._order, k, move))

    def _open_stops(self, k, state, sweep, record):
        turned = np.abs(record.wanted - state.rest.q[3 + sweep.velocity_finger])
        for stop in self._stops(turned, record):
            i = int(np.searchsorted(turned, stop - 1e-9))
            if i >= len(turned):
                return
            q = record.configurations[i]
            if abs(q[3 + sweep.velocity_finger] - record.wanted[i]) > 0.1 or self.task.hopeless(q):
                return
            if self._cell(q) not in self._seen:
                self._open(
                    k,
                    state,
                    q,
                    MotionPrimitive(
                        sweep.velocity_finger, float(np.sign(sweep.turn) * stop), sweep.torque
                    ),
                )

    def _stops(self, turned, record):
        """Turns [rad] of the finger after which to stop: every so far, and where the object is nearest to its goal."""
        stops = np.arange(STOP_EVERY, SWEEP + 1e-9, STOP_EVERY)
        if self.task.caged_goal:
            return stops
        away = [self.task.goal.distance(q[:3]) for q in record.configurations]
        return np.sort(np.append(stops, turned[int(np.argmin(away))]))

    def _led(self, before, record):
        """The particles after the move, or None when they do not agree with the plan."""
        course = record.course(before.rest)
        finger = -1 if before.record is None else before.record.move.velocity_finger
        after = []

        def lead(k):
            q, v = before.copies[k]
            start = Start(q, v, before.rest.efforts, False, finger)
            return follow_course(self._copies[k], course, start, self._controls)

        for copy, run in zip(self._copies, parallel_map(lead, range(len(self._copies)))):
            self.simulated += 1
            turn = copy.goal.rotation - self._copies[0].goal.rotation
            difference = np.abs(run.q[:3] - record.configurations[-1, :3] - [0.0, 0.0, turn])
            if (
                run.stopped
                or run.stops_met.any()
                or (difference / self.task.world.scale[:3] > SPREAD).any()
                or np.abs(run.v / self.task.world.scale).max() > STILL
            ):
                return None
            after.append((run.q, run.v))
        return tuple(after)

    def _simulate(self, rest, moves):
        """The records of moves from rest."""
        self.simulated += len(moves)
        return list(parallel_map(partial(simulate_primitive, self.task.world, rest), moves))

    def _cell(self, q):
        return tuple(np.round(q / (CELL * self.task.world.scale)).astype(int).tolist())


def primitive_tree_search(
    task: PlanningProblem, tree: PrimitiveTree, limit: int, stop: Callable[[], bool] = lambda: False
):
    """(subgoals, legs) of the next route that the tree leads to the goal, or None when it is done with.

    limit: of simulated moves in the whole tree; stop: whether to give up, asked now and then.
    """
    while tree.open and tree.simulated < limit and not stop():
        k = tree.grow()
        if k is None:
            continue
        q = tree.states[k].rest.q
        if task.reached(q[:3]):
            return tree.route_to(k)
        cage = task.cage_at(q[2])
        down = caging_descent(task, q, cage) if cage is not None else None
        if down is not None and task.reached(down[-1, :3]):
            subgoals, legs = tree.route_to(k)
            names = tuple(map(pair_name, closed_pairs(task.world, down[-1])))
            number = len(subgoals) + 1
            subgoals.append(Subgoal(number, X_GOAL, down[-1], names, 0, number - 1))
            return subgoals, [*legs, Leg(number - 1, number, CAGING, names, down)]
    return None


def _samples(start, record):
    last = len(record.configurations) - 1
    places = [*range(SAMPLE_EVERY, last, SAMPLE_EVERY), last]
    return np.vstack([start[None], record.configurations[places]])
