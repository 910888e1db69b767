"""Planning of probes: places at which what may lie in the hand is told apart, squeezed so gently
that nothing tips.
"""

import numpy as np

from wholearm_ros.errors import SolverError
from wholearm_ros.estimation.feel import Feeler
from wholearm_ros.estimation.squeeze import Resting, SqueezeModel
from wholearm_ros.kernels import geometry
from wholearm_ros.mechanics.contacts import gap_table
from wholearm_ros.mechanics.quasistatic import QuasiStatics, build_quasistatics
from wholearm_ros.mechanics.torque_range import build_torque_range, solve_torque_range
from wholearm_ros.model.hand import CLOSING
from wholearm_ros.model.probe import Probe
from wholearm_ros.model.trajectory import ManipulationTrajectory

PLACES = 7
WIDEST = 0.50  # [rad] that the held finger opens at most before it closes to where it was
GRID = 0.05  # [rad] between the angles that are looked at
STRONGEST, WEAKEST = 0.08, 0.03  # [N m] of the closing finger
SAFETY = 2.0  # torque that would tip the object over the torque that is used
OPENED = 0.12  # [rad] that both fingers open before they close
REACH = 0.35  # [rad] from its closed limit at which the closing finger must have met the object
STOP_MARGIN = 0.01  # [rad] inside of the closed limit at which a finger is stopped
TOUCHING = 1e-6  # [m]
# [rad] from an edge's rotation within which a planned last pose lies on that edge.
LYING_ANGLE = 0.15


def tipping_torque(
    model: SqueezeModel, resting: Resting, held: int, slide: float, theta: float, angle: float
) -> float:
    """[N m] of the closing finger, beyond its own weight, above which the squeezed object leaves
    the palm with a vertex.

    Zero where no torque at all can press it so.
    """
    q = np.array([*resting.pose_at(slide), 0.0, 0.0])
    q[3 + held], q[4 - held] = theta, angle
    n = len(model.world.obj)
    palm = [
        int(geometry.pair_code(geometry.VERTEX_EDGE, geometry.PALM, resting.segment, k))
        for k in (resting.edge, (resting.edge + 1) % n)
    ]
    gaps, codes = gap_table(model.world, q)
    fingers = [
        [
            int(c)
            for c, gap in zip(codes, gaps)
            if geometry.pair_body(c) == body and abs(gap) < TOUCHING
        ]
        for body in (1, 2)
    ]
    closing = 1 - held
    least = np.inf
    for one in fingers[0]:
        for other in fingers[1]:
            statics = build_quasistatics(model.world, (*palm, one, other), q)
            try:
                answer = solve_torque_range(
                    build_torque_range(statics, closing, model.world.torque_limits)
                )
            except (SolverError, np.linalg.LinAlgError):
                return 0.0
            if answer.empty:
                return 0.0
            weight = float(statics.g_h[closing])
            ends = (
                CLOSING[closing] * (answer.low - weight),
                CLOSING[closing] * (answer.high - weight),
            )
            least = min(least, max(ends), _sliding_torque(statics, 2 + closing, closing, resting))
    return float(least) if np.isfinite(least) else 0.0


def _sliding_torque(statics: QuasiStatics, contact: int, closing: int, resting: Resting) -> float:
    """[N m] of the closing finger above which the object tips while it slides ahead of that finger
    alone, unhindered.

    Newton's law along the palm leaves two equations, across it and of moments, for the two forces
    of the palm.
    """
    across = np.array([-resting.along[1], resting.along[0]])
    rows = np.vstack([across @ statics.G_n[:2], statics.G_n[2]])  # (2, 4)
    load = np.array([across @ statics.g_O[:2], statics.g_O[2]])
    try:
        still = np.linalg.solve(rows[:, :2], -load)
        pushed = np.linalg.solve(rows[:, :2], -rows[:, contact])
    except np.linalg.LinAlgError:
        return 0.0
    lifted = pushed < 0.0
    if not lifted.any():
        return np.inf
    force = float((still[lifted] / -pushed[lifted]).min())
    return force * abs(float(statics.J_n[contact, closing]))


def plan_probe(
    model: SqueezeModel, hypotheses: tuple[Resting, ...], expected: int, held: int, end: float
) -> Probe:
    """The probe for what may lie in the hand.

    expected: the place in `hypotheses` of the one believed in, −1 for none; held: the finger that
    is led; end [rad]: the angle at which that finger stands before and after: nothing moves after
    the last pair has been read, and the object lies where it lay.
    """
    end = float(np.clip(end, *(model.world.limits[held] + [STOP_MARGIN, -STOP_MARGIN])))
    low, high = model.world.limits[held]
    offsets = np.arange(-WIDEST, GRID / 2, GRID)
    thetas = end + CLOSING[held] * offsets
    inside = (thetas > low + STOP_MARGIN) & (thetas < high - STOP_MARGIN)
    thetas, offsets = thetas[inside], offsets[inside]
    tipping = np.array([_tipping_along(model, resting, held, thetas) for resting in hypotheses])
    safe = _safe_stretch(tipping, expected, offsets)
    least = np.nanmin(tipping[:, safe]) / SAFETY if safe.any() else 0.0
    torque = float(np.clip(least, WEAKEST, STRONGEST))
    if safe.any():
        first, last = thetas[safe][0], thetas[safe][-1]
        places = np.linspace(first, last, PLACES)
    else:
        places = np.array([end])
    limits, weights = model.world.limits, model.world.finger_moment
    stops = np.array([limits[0, 0] + STOP_MARGIN, limits[1, 1] - STOP_MARGIN])
    return Probe(held, places, np.full(2, OPENED), torque, weights, stops)


def _tipping_along(
    model: SqueezeModel, resting: Resting, held: int, thetas: np.ndarray
) -> np.ndarray:
    """(k,) [N m] with the held finger at thetas (k,) [rad], NaN where such an object is not met."""
    slides, angles = model.squeeze(resting, held, thetas)
    by_shorter = model.shortened.squeeze(resting, held, thetas)[1]
    found = np.full(len(thetas), np.nan)
    shut = model.world.limits[1 - held, 0 if held else 1]
    for k in np.flatnonzero(np.isfinite(angles)):
        if abs(angles[k] - shut) < REACH or np.isnan(by_shorter[k]):
            found[k] = 0.0  # there the closing finger may pass over the object
            continue
        found[k] = tipping_torque(model, resting, held, slides[k], thetas[k], angles[k])
    return found


def _safe_stretch(tipping: np.ndarray, expected: int, offsets: np.ndarray) -> np.ndarray:
    """(k,) bool: the stretch round offset 0 in which the expected object, and others that are met,
    do not tip.
    """
    enough = SAFETY * WEAKEST
    others, good = tipping, np.isfinite(tipping).any(axis=0)
    if expected >= 0:
        good = np.isfinite(tipping[expected]) & (tipping[expected] > enough)
        others = np.delete(tipping, expected, axis=0)
    good &= ~(np.isfinite(others) & (others < WEAKEST)).any(axis=0)
    keep = np.zeros(len(offsets), bool)
    if not good.any():
        return keep
    middle = int(np.argmin(np.where(good, np.abs(offsets), np.inf)))
    for step in (-1, 1):
        k = middle
        while 0 <= k < len(good) and good[k]:
            keep[k] = True
            k += step
    return keep


def probe_after(feeler: Feeler, trajectory: ManipulationTrajectory) -> Probe:
    """The probe after a trajectory: what is expected is the edge on which its last pose lies, if it
    lies on one.
    """
    held = trajectory.segments[-1].velocity_finger
    expected = nearest_resting(feeler.hypotheses, trajectory.poses[-1])
    end = float(trajectory.angles[-1, held])
    return plan_probe(feeler.model, feeler.hypotheses, expected, held, end)


def probe_of_the_unknown(feeler: Feeler, held: int, end: float) -> Probe:
    """The probe of whatever lies in the hand; end [rad]: where the held finger stands."""
    return plan_probe(feeler.model, feeler.hypotheses, -1, held, end)


def nearest_resting(hypotheses: tuple[Resting, ...], pose: np.ndarray) -> int:
    """The place in `hypotheses` of the one in which an object at `pose` (3,) lies, −1 when it lies
    in none.
    """
    off = [
        abs((float(pose[2] - h.pose[2]) + np.pi) % (2.0 * np.pi) - np.pi)
        + (abs(pose[0] - h.pose[0]) > h.reach)
        for h in hypotheses
    ]
    best = int(np.argmin(off))
    return best if off[best] < LYING_ANGLE else -1
