"""NEW_SUBGOAL: move the velocity-controlled finger from a four-contact subgoal until something happens (III-A.4)."""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.kernels import arc_tracing, geometry
from wholearm_ros.kernels.linear import null_vector
from wholearm_ros.mechanics.contacts import closed_pairs, contact_rows, pose_on_palm
from wholearm_ros.mechanics.torque_range import ROBUST_FRICTION
from wholearm_ros.model.orientation import palm_segment_under
from wholearm_ros.model.trajectory import CAGING, QUASI_STATIC
from wholearm_ros.planning.problem import PlanningProblem

EMPTY_WIDTH = (
    -1.0
)  # [N m] of a range that is empty somewhere; how empty says nothing near a singular configuration
WIDE_ENOUGH = 0.4  # [N m] robust half widths beyond this count as equal
CHANGE_COST = 1.0  # of one contact-state change, against motion in rad
MOST_THROUGH = 12  # X_through in one expansion
MOST_SAMPLES = 300  # configurations on one arc
UNREACHED, REACHED, NEW_Y = 'unreached', 'reached', 'new_y'
EVENTS = {
    arc_tracing.CLOSED: 'contact',
    arc_tracing.EDGE_END: 'end of edge',
    arc_tracing.JOINT_LIMIT: 'joint limit',
    arc_tracing.SINGULAR: 'singular',
    arc_tracing.NO_EQUILIBRIUM: 'no equilibrium',
    arc_tracing.CAGED: 'caged',
    arc_tracing.BLOCKED: 'blocked',
    arc_tracing.TOO_LONG: 'too long',
}


@dataclass(frozen=True, eq=False)
class Arc:
    """Configurations (m, 5) with the same four closed pairs, unit tangents (m, 5) and statics (m, 2, 4): for either
    torque-controlled finger (τ_min, τ_max) without friction and the part of it that is good with friction, too [N m]."""

    mode: str
    pairs: tuple
    configurations: np.ndarray
    tangents: np.ndarray
    statics: np.ndarray
    event: str

    def robust_half_width(self) -> np.ndarray:
        """(2,) [N m]: for either torque-controlled finger, the least half width of the robust range along the arc."""
        if len(self.statics) == 0:
            return np.full(2, -np.inf)
        return np.maximum(
            (0.5 * (self.statics[:, :, 3] - self.statics[:, :, 2])).min(axis=0), EMPTY_WIDTH
        )

    def length(self, scale: np.ndarray) -> float:
        """Length in scaled coordinates [rad]."""
        return float(np.linalg.norm(np.diff(self.configurations, axis=0) / scale, axis=1).sum())


@dataclass(frozen=True, eq=False)
class Expansion:
    """What NEW_SUBGOAL found: the arcs (an X_through between each two), and how it ended.

    outcome: NEW_Y with the closed pairs at the end, REACHED with the goal or a cage, or UNREACHED.
    """

    arcs: tuple
    outcome: str
    pairs: tuple = ()

    @property
    def end(self) -> np.ndarray:
        """(5,) the last configuration."""
        return self.arcs[-1].configurations[-1]

    def margin(self) -> float:
        """Least robust half width [N m] of the quasi-static arcs, each with the better assignment; at most WIDE_ENOUGH."""
        widths = [
            arc.robust_half_width().max()
            for arc in self.arcs
            if arc.mode != CAGING and len(arc.statics) > 1
        ]
        return float(min([WIDE_ENOUGH, *widths]))

    def cost(self, scale: np.ndarray) -> float:
        """Contact-state changes, and motion in scaled coordinates [rad]."""
        return sum(CHANGE_COST + arc.length(scale) for arc in self.arcs)


def tangent(task: PlanningProblem, q: np.ndarray, pairs: tuple) -> np.ndarray:
    """(5,) unit vector along which the pairs stay closed, its sign arbitrary."""
    t = np.empty(5)
    null_vector(contact_rows(task.world, pairs, q)[0], task.world.scale, t)
    return t


def new_subgoal(
    task: PlanningProblem, q: np.ndarray, pairs: tuple, toward: np.ndarray, driver: int = -1
) -> tuple:
    """NEW_SUBGOAL from X = (q, pairs) towards the side of `toward` (5,): the expansions it ends in.

    More than one when the object can be let go on the way: each place to do so is an end, and so is where the arc leads.
    driver: the velocity-controlled finger (LEFT or RIGHT), which must not have to reverse, or −1 when either will do.
    """
    ends, done = [], []
    for _ in range(MOST_THROUGH):
        arc, event, which = _trace(task, q, pairs, toward, driver)  # steps 1–6, 10
        if len(arc.configurations) == 0:
            break
        goal = _first_reached(task, arc)
        if goal is not None:  # step 7
            return (*ends, Expansion((*done, goal), REACHED))
        ends.extend(_releases(task, tuple(done), arc))  # steps 4 and 7: gravity does the rest
        done.append(arc)
        q = arc.configurations[-1]
        if event == arc_tracing.CLOSED:  # step 8
            after = closed_pairs(task.world, q)
            if len(after) > 4:
                return (*ends, Expansion(tuple(done), NEW_Y, after))
        if event != arc_tracing.EDGE_END:  # step 5
            break
        following = arc_tracing.next_pair_at_end(
            *task.world.geometry, which, q
        )  # step 9: X_through
        if following < 0 or following in pairs:
            break
        pairs = tuple(sorted(int(following) if c == which else c for c in pairs))
        if driver < 0:
            toward = _inward(task, q, pairs, following)
    return tuple(ends) or (Expansion(tuple(done), UNREACHED),)


def _trace(task, q, pairs, toward, driver):
    w = task.world
    qs, ts, st = (
        np.empty((MOST_SAMPLES, 5)),
        np.empty((MOST_SAMPLES, 5)),
        np.empty((MOST_SAMPLES, 2, 4)),
    )
    count, event, which = arc_tracing.trace_arc(
        *w.geometry,
        w.corners,
        w.scale,
        w.limits,
        w.load,
        w.finger_moment,
        w.torque_limits,
        ROBUST_FRICTION,
        task.cage_intervals,
        np.array(pairs, dtype=np.int64),
        q,
        toward,
        driver,
        qs,
        ts,
        st,
    )
    arc = Arc(
        QUASI_STATIC, pairs, qs[:count].copy(), ts[:count].copy(), st[:count].copy(), EVENTS[event]
    )
    return arc, event, which


def _first_reached(task, arc):
    """The arc cut where the object first is at its goal, or None."""
    for i, q in enumerate(arc.configurations):
        if task.reached(q[:3]):
            keep = max(i + 1, 2) if len(arc.configurations) > 1 else 1
            return Arc(
                arc.mode,
                arc.pairs,
                arc.configurations[:keep],
                arc.tangents[:keep],
                arc.statics[:keep],
                'goal',
            )
    return None


def _releases(task, done, arc):
    """Check_Caging: the expansions that let the object go on this arc: as soon as it may be, half-way, and at the last."""
    angles = arc.configurations[:, 2]
    held = (arc.statics[:, :, 1] >= arc.statics[:, :, 0]).any(axis=1)
    caged = [
        i
        for i, angle in enumerate(angles)
        if held[i] and arc.tangents[i, 2] > 0.0 and task.cage_at(angle) is not None
    ]
    if not caged or not any(
        geometry.pair_body(c) == geometry.PALM and geometry.pair_kind(c) == geometry.VERTEX_EDGE
        for c in arc.pairs
    ):
        return
    for i in sorted({caged[0], caged[len(caged) // 2], caged[-1]}, reverse=True):
        cage = task.cage_at(angles[i])
        down = lowering(task, arc.configurations[i], cage)
        if down is None or i == 0:
            continue
        before = Arc(
            arc.mode,
            arc.pairs,
            arc.configurations[: i + 1],
            arc.tangents[: i + 1],
            arc.statics[: i + 1],
            'caged',
        )
        pairs = closed_pairs(task.world, down[-1])
        caging = Arc(CAGING, pairs, down, np.empty((0, 5)), np.empty((0, 2, 4)), 'landed')
        yield Expansion(
            (*done, before, caging), REACHED if task.reached(down[-1, :3]) else NEW_Y, pairs
        )


def lowering(task: PlanningProblem, q: np.ndarray, cage) -> np.ndarray:
    """(m, 5): the centroid falls straight, the object rolls over its lowest vertices, each finger keeps closed on it.

    None when somewhere on the way a finger has no room.
    """
    w = task.world
    landed = task.landed(q, cage)
    if landed is None:
        return None
    angles = np.linspace(q[2], cage.landing, max(3, int(np.ceil((cage.landing - q[2]) / 0.08)) + 1))
    samples, segment = [q], palm_segment_under(task.scenario.palm, q[0])
    for angle in angles[1:-1]:
        y = pose_on_palm(w, q[0], angle, segment)[1]
        fingers = [
            geometry.closing_angle(w.obj, w.fingers, w.limits, side, q[0], y, angle)
            for side in range(2)
        ]
        if np.isnan(fingers).any():
            return None
        samples.append(np.array([q[0], y, angle, *fingers]))
    return np.array([*samples, landed])


def _inward(task, q, pairs, pair):
    """The tangent along which the contact point of `pair`, at the end of its edge, moves onto the edge."""
    t = tangent(task, q, pairs)
    here = geometry.contact(*task.world.geometry, pair, q)
    there = geometry.contact(*task.world.geometry, pair, q + 1e-6 * t)
    away_from_start = there[5] - here[5]
    at_start = here[5] < 0.5 * here[6]
    return t if (away_from_start > 0.0) == at_start else -t
