"""Candidates: the motion primitives worth simulating from a state at rest.

Either finger is swept either way under a few torques of the other one; every so far along a sweep
is a place to stop. Flings are quick primitives whose momentum carries the object over
configurations that no torque holds: gentle ones near the top of the last cage, throws from afar.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from wholearm_ros.kernels import geometry
from wholearm_ros.mechanics.contacts import closed_pairs, four_contact_subsets
from wholearm_ros.mechanics.quasistatic import build_quasistatics
from wholearm_ros.mechanics.torque_range import build_torque_range, solve_torque_range
from wholearm_ros.model.configuration import POSE, joint_index
from wholearm_ros.model.hand import CLOSING, LEFT, RIGHT
from wholearm_ros.model.motion_primitive import MotionPrimitive
from wholearm_ros.planning.problem import PlanningProblem
from wholearm_ros.rollout.primitive_rollout import PrimitiveRecord, Rest
from wholearm_ros.search.arcs import TOUCHING

SWEEP = 0.9  # [rad]
STOP_EVERY = 0.1  # [rad] along a sweep
JAMMED = 0.1  # [rad] by which a swept finger may lag behind before the sweep counts as jammed
HELD = 1e-3  # [m] gap of a finger that is at the object, on the way
LONG_SETTLE = 0.6  # [s] for a primitive that does not end at rest at once
FLING_SLEW = 50.0  # [N m/s]
FASTEST = 15.0  # [rad/s] of a fling
FLING_STEPS = 1.35, 1.6, 1.35  # factors of turn, torque and speed between flings beside one another


@dataclass(frozen=True)
class Style:
    """Of a tree's sweeps: peak speed [rad/s], and torques of the other finger towards closing
    [N m].
    """

    speed: float
    torques: tuple[float, ...]


STYLES = Style(2.0, (0.05, 0.2, 0.6, 1.5, 3.5)), Style(1.2, (0.1, 0.35, 1.0, 2.5))


@dataclass(frozen=True)
class Flings:
    """Where to begin looking for one: peak speed [rad/s], turns [rad] and torques of the other
    finger towards closing [N m]; within: so far [rad] from where the object may be released.
    """

    speed: float
    turns: tuple[float, ...]
    torques: tuple[float, ...]
    within: float


GENTLE = Flings(5.0, (-0.5, -0.2, 0.2, 0.5), (0.2, 1.0, 3.5), within=0.8)
THROWS = Flings(10.0, (-0.9, -0.5, 0.5, 0.9), (0.4, 1.0, 2.5), within=1.3)


def sweeps(problem: PlanningProblem, q: np.ndarray, style: Style) -> list[MotionPrimitive]:
    """Sweeps of either finger either way from q (5,), under every torque of the other."""
    return [
        MotionPrimitive(side, way * SWEEP, torque, style.speed, settle=0.0)
        for side in (LEFT, RIGHT)
        for way, torque in product((1.0, -1.0), _torques(problem, q, 1 - side, style))
    ]


def flings(problem: PlanningProblem, q: np.ndarray, kind: Flings) -> list[MotionPrimitive]:
    """Those of a kind from q (5,) with which to begin."""
    if not problem.caged_goal or problem.rotation_left(q) >= kind.within:
        return []
    return [
        MotionPrimitive(side, turn, torque, kind.speed, LONG_SETTLE, FLING_SLEW)
        for side, turn, torque in product((LEFT, RIGHT), kind.turns, kind.torques)
    ]


def flings_beside(fling: MotionPrimitive) -> list[MotionPrimitive]:
    """Those with a little more and a little less of turn, torque or speed, none too fast."""
    beside = []
    for sign in (1, -1):
        turn, torque, speed = (step**sign for step in FLING_STEPS)
        beside += [
            replace(fling, turn=turn * fling.turn),
            replace(fling, torque=torque * fling.torque),
            replace(fling, speed=speed * fling.speed),
        ]
    return [other for other in beside if other.speed <= FASTEST]


def stops_along(
    problem: PlanningProblem, rest: Rest, sweep: MotionPrimitive, record: PrimitiveRecord
) -> Iterator[tuple[MotionPrimitive, np.ndarray]]:
    """Primitives that stop on the way of a simulated sweep, and where (5,) each of them stops, as
    far as nothing is hopeless. Not where the other finger is in the air: its torque would take it
    to its end stop.
    """
    side = sweep.velocity_finger
    turned = np.abs(record.wanted - rest.q[joint_index(side)])
    for stop in _stops(problem, turned, record):
        i = int(np.searchsorted(turned, stop - 1e-9))
        if i >= len(turned):
            return
        q = record.configurations[i]
        if abs(q[joint_index(side)] - record.wanted[i]) > JAMMED or problem.hopeless(q):
            return
        if not _touches(problem, q, 1 - side):
            continue
        yield MotionPrimitive(side, float(np.sign(sweep.turn) * stop), sweep.torque), q


def _stops(problem: PlanningProblem, turned: np.ndarray, record: PrimitiveRecord) -> np.ndarray:
    """Turns [rad] of the finger after which to stop: every so far, and, for a goal to which no cage
    leads, where the object is nearest to it. turned: (m,) at every record [rad].
    """
    stops = np.arange(STOP_EVERY, SWEEP + 1e-9, STOP_EVERY)
    if problem.caged_goal:
        return stops
    away = [problem.goal.distance(q[POSE]) for q in record.configurations]
    return np.sort(np.append(stops, turned[int(np.argmin(away))]))


def _touches(problem: PlanningProblem, q: np.ndarray, side: int) -> bool:
    """Whether finger `side` is at the object in q (5,), on the way."""
    pairs = closed_pairs(problem.world, q, HELD)
    return any(geometry.pair_body(pair) == geometry.LEFT_FINGER + side for pair in pairs)


def _torques(problem: PlanningProblem, q: np.ndarray, side: int, style: Style) -> list[float]:
    """Torques [N m] of finger `side` worth trying from q (5,): those of the style, and one inside
    the range of each of its four-contact equilibria.
    """
    torques = list(style.torques)
    for pairs in four_contact_subsets(closed_pairs(problem.world, q, TOUCHING)):
        model = build_quasistatics(problem.world, pairs, q)
        found = solve_torque_range(build_torque_range(model, side, problem.world.torque_limits))
        if found.empty:
            continue
        ends = sorted(CLOSING[side] * (np.array([found.low, found.high]) - model.g_h[side]))
        wanted = ends[0] + min(0.5, 0.5 * (ends[1] - ends[0]))
        if all(abs(wanted - other) > 0.2 * abs(other) for other in torques):
            torques.append(float(wanted))
    return torques
