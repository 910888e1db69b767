"""An arc of configurations on which four contacts stay closed, with its statics."""

from dataclasses import dataclass, replace

import numpy as np

from wholearm_ros.kernels import arc_tracing
from wholearm_ros.kernels.linear import null_vector
from wholearm_ros.mechanics.contacts import contact_rows
from wholearm_ros.mechanics.torque_range import ROBUST_FRICTION
from wholearm_ros.model.configuration import POSE, SIZE
from wholearm_ros.model.modes import QUASI_STATIC
from wholearm_ros.planning.problem import PlanningProblem

# [N m] of a range that is empty somewhere: how empty says nothing near a singular configuration.
EMPTY_WIDTH = -1.0
MOST_SAMPLES = 300  # configurations on one arc
SAME_SAMPLE = 1e-6  # fraction of a step: what lies this near to a sample is the sample
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
    """Configurations along which the same four pairs stay closed.

    mode: QUASI_STATIC or CAGING; configurations: (m, 5) [m, rad]; tangents: (m, 5) of unit scaled
    length; statics: (m, 2, 4) [N m], for either torque-controlled finger (τ_min, τ_max) without
    friction and of the friction-robust part of that range; event: what ends the arc.
    """

    mode: str
    pairs: tuple[int, ...]
    configurations: np.ndarray
    tangents: np.ndarray
    statics: np.ndarray
    event: str

    def robust_half_width(self) -> np.ndarray:
        """(2,) [N m]: for either torque-controlled finger, the least half width of the robust range
        along the arc.
        """
        if len(self.statics) == 0:
            return np.full(2, -np.inf)
        half_widths = 0.5 * (self.statics[:, :, 3] - self.statics[:, :, 2])
        least: np.ndarray = np.maximum(half_widths.min(axis=0), EMPTY_WIDTH)
        return least

    def length(self, scale: np.ndarray) -> float:
        """Length in scaled coordinates [rad]."""
        return float(np.linalg.norm(np.diff(self.configurations, axis=0) / scale, axis=1).sum())

    def up_to(self, count: int, event: str) -> 'Arc':
        """Its first `count` samples, and the event that ends it there."""
        return replace(
            self,
            configurations=self.configurations[:count],
            tangents=self.tangents[:count],
            statics=self.statics[:count],
            event=event,
        )


def tangent(problem: PlanningProblem, q: np.ndarray, pairs: tuple[int, ...]) -> np.ndarray:
    """(5,) unit vector along which the pairs stay closed, its sign arbitrary."""
    t: np.ndarray = np.empty(SIZE)
    null_vector(contact_rows(problem.world, pairs, q)[0], problem.world.scale, t)
    return t


def trace(
    problem: PlanningProblem,
    q: np.ndarray,
    pairs: tuple[int, ...],
    toward: np.ndarray,
    driver: int,
) -> tuple[Arc, int, int]:
    """The arc from q (5,) towards the side of `toward` (5,), the code of the event that ends it,
    and the pair of that event.

    driver: the finger that must not reverse, LEFT or RIGHT, or −1 when either may.
    """
    samples = arc_tracing.ArcSamples(
        np.empty((MOST_SAMPLES, SIZE)),
        np.empty((MOST_SAMPLES, SIZE)),
        np.empty((MOST_SAMPLES, 2, 4)),
    )
    codes = np.array(pairs, dtype=np.int64)
    task = arc_tracing.ArcTask(codes, q, toward, driver, ROBUST_FRICTION, problem.cage_intervals)
    count, event, which = arc_tracing.trace_arc(problem.world, task, samples)
    q, t, statics = (rows[:count].copy() for rows in samples)
    return Arc(QUASI_STATIC, pairs, q, t, statics, EVENTS[event]), event, which


def arc_to_goal(problem: PlanningProblem, arc: Arc) -> Arc | None:
    """The arc, cut where the object is nearest to the goal inside the goal region; None when it
    never gets there.
    """
    found = None  # (distance, sample before, share of the step to the next one)
    poses = arc.configurations[:, POSE]
    if len(poses) == 1:
        return arc if problem.reached(poses[0]) else None
    for i in problem.goal.near_steps(poses, problem.margin):
        if found is not None and i > found[1] + 1:
            break
        u, distance = _nearest_on_step(problem, poses[i : i + 2])
        pose = _between(arc.configurations, i, u)[POSE]
        if problem.reached(pose) and (found is None or distance < found[0]):
            found = distance, i, u
        elif found is not None:
            break
    if found is None:
        return None
    _, i, u = found
    if u in (0.0, 1.0):
        return arc.up_to(max(i + 1 + int(u), 2), 'goal')
    q = _projected(problem, arc, i, u)
    if q is None or not problem.reached(q[POSE]):
        return arc.up_to(i + 2, 'goal') if problem.reached(arc.configurations[i + 1, :3]) else None
    cut = arc.up_to(i + 1, 'goal')
    return replace(
        cut,
        configurations=np.vstack([cut.configurations, q]),
        tangents=np.vstack([cut.tangents, _between(arc.tangents, i, u)]),
        statics=np.concatenate([cut.statics, _between(arc.statics, i, u)[None]]),
    )


def _nearest_on_step(problem: PlanningProblem, poses: np.ndarray) -> tuple[float, float]:
    """(u, distance): the fraction u of the step between two poses (2, 3) at which it is nearest to
    the goal, and its distance there.
    """
    first = problem.goal.error(poses[0]) / problem.goal.tolerance
    if problem.distance(poses[0]) == 0.0:
        return 0.0, 0.0
    way = problem.goal.error(poses[1]) / problem.goal.tolerance - first
    u = float(np.clip(-(first @ way) / max(way @ way, 1e-300), 0.0, 1.0))
    if min(u, 1.0 - u) < SAME_SAMPLE:
        u = float(round(u))
    return u, problem.distance((1.0 - u) * poses[0] + u * poses[1])


def _between(rows: np.ndarray, i: int, u: float) -> np.ndarray:
    """Linear interpolation: row i, and a fraction u of the way to the next one."""
    between: np.ndarray = rows[i] if u == 0.0 else (1.0 - u) * rows[i] + u * rows[i + 1]
    return between


def _projected(problem: PlanningProblem, arc: Arc, i: int, u: float) -> np.ndarray | None:
    """(5,) on the arc, a fraction u of the way from sample i to the next; None when Newton's method
    fails.
    """
    q, codes = _between(arc.configurations, i, u), np.array(arc.pairs, dtype=np.int64)
    hold = _between(arc.tangents, i, u) / problem.world.scale**2
    manifold = arc_tracing.new_manifold(problem.world, codes)
    converged = arc_tracing.project(problem.world, manifold, q, hold)
    return q if converged else None
