"""Planning of probes: places at which what may lie in the hand is told apart, squeezed so gently
that nothing tips.
"""

from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np

from wholearm_ros.errors import SolverError
from wholearm_ros.estimation.feel import Feeler, derivatives_by_zeros, pairs_covariance
from wholearm_ros.estimation.hypotheses import alike
from wholearm_ros.estimation.squeeze import Resting, SqueezeModel
from wholearm_ros.kernels import geometry
from wholearm_ros.mechanics.contacts import gap_table
from wholearm_ros.mechanics.quasistatic import QuasiStatics, build_quasistatics
from wholearm_ros.mechanics.torque_range import build_torque_range, solve_torque_range
from wholearm_ros.model.hand import CLOSING, LEFT, RIGHT
from wholearm_ros.model.probe import Probe
from wholearm_ros.model.scenario import GoalOnEdge
from wholearm_ros.model.trajectory import ManipulationTrajectory

PLACES = 7
# [rad] that the held finger closes beyond where it was, below zero: opens before it closes to where
# it was; the first one that separates the hypotheses enough is used.
AWAY: tuple[float, ...] = (-0.5, -0.7, -0.9, -1.1)
ON: tuple[float, ...] = (0.08, 0.14, 0.2, 0.3, 0.4)
WIDE = 0.08  # [rad] between the first and the last place that is enough
SEPARATED = 60.0  # χ² between what is expected and the next best that is enough
ENOUGH = (True, SEPARATED)
GRID = 0.05  # [rad] between the angles that are looked at
STRONGEST, WEAKEST = 0.08, 0.03  # [N m] of the closing finger
SAFETY = 2.0  # torque that would tip the object over the torque that is used
# [N m] of the closing finger, for each radian that it turns while the held one turns by one: what
# its inertia and its damping add to its torque when it gives way as fast as it is led.
SWING = 0.04
OPENED = 0.12  # [rad] that both fingers open before they close
REACH = 0.35  # [rad] from its closed limit at which the closing finger must have met the object
STOP_MARGIN = 0.01  # [rad] inside of the closed limit at which a finger is stopped
TOUCHING = 1e-6  # [m]


class Doubt(NamedTuple):
    """outline [m]: by which either end of the edge that carries the object may be nearer to the
    centroid than is believed; friction: coefficient of what slides.
    """

    outline: float
    friction: float


NO_DOUBT = Doubt(0.0, 0.0)
DOUBT = Doubt(0.001, 0.10)  # as at perturbation level 2
# [rad] from an edge's rotation within which a planned last pose lies on that edge.
LYING_ANGLE = 0.15


def tipping_torque(
    model: SqueezeModel,
    resting: Resting,
    held: int,
    slide: float,
    theta: float,
    angle: float,
    doubt: Doubt = NO_DOUBT,
    alone: bool = True,
) -> float:
    """[N m] of the closing finger, beyond its own weight, above which the squeezed object leaves
    the palm with a vertex.

    doubt: how far object and hand may be from what is believed; alone: whether the closing finger
    pushes the object to the held one by itself, which then stops it. Zero where no torque at all
    can press it so.
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
    closing, least = 1 - held, np.inf
    pushing = (LEFT, RIGHT) if alone else (held,)
    for pair in product(*fingers):
        statics = _narrowed(build_quasistatics(model.world, (*palm, *pair), q), doubt.outline)
        if not all(_slides(statics, 2 + side, resting, doubt.friction) for side in pushing):
            return 0.0
        try:
            answer = solve_torque_range(
                build_torque_range(statics, closing, model.world.torque_limits)
            )
        except (SolverError, np.linalg.LinAlgError):
            return 0.0
        weight = float(statics.g_h[closing])
        ends = [CLOSING[closing] * (end - weight) for end in (answer.low, answer.high)]
        if answer.empty or min(ends) > WEAKEST / SAFETY:
            return 0.0
        least = min(least, max(ends))
        if alone:
            least = min(least, _sliding_torque(statics, 2 + closing, closing, resting))
    return float(least) if np.isfinite(least) else 0.0


def _narrowed(statics: QuasiStatics, outline: float) -> QuasiStatics:
    """With both palm contacts (the first two) nearer to each other by `outline` [m] each."""
    wrenches = statics.G_n.copy()
    wrenches[2, :2] -= outline * np.sign(wrenches[2, :2] - wrenches[2, :2].mean())
    return replace(statics, G_n=wrenches)


def _slides(statics: QuasiStatics, contact: int, resting: Resting, friction: float) -> bool:
    """Whether an object slides along the palm, and does not tip, when that finger alone pushes it
    slowly.
    """
    along = resting.along
    axes = np.vstack([along, [-along[1], along[0]]])
    rows = np.vstack([axes @ statics.G_n[:2], statics.G_n[2]])[:, [0, 1, contact]]
    load = np.array([*(axes @ statics.g_O[:2]), statics.g_O[2]])
    drag = -friction * np.sign(rows[0, 2])
    rows[0, :2] += drag
    rows[2, :2] += drag * resting.height
    try:
        forces = np.linalg.solve(rows, -load)
    except np.linalg.LinAlgError:
        return False
    return bool((forces[:2] >= 0.0).all())


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
    model: SqueezeModel,
    hypotheses: tuple[Resting, ...],
    expected: int,
    held: int,
    ends: np.ndarray,
    shifts: bool = True,
    again: bool = False,
) -> Probe:
    """The probe for what may lie in the hand.

    expected: the place in `hypotheses` of the one believed in, −1 for none; held: the finger that
    is led, unless only the other one can be without tipping what is expected; ends (2,) [rad]:
    where the fingers stand before; shifts: whether the object may end elsewhere on its edge; again:
    whether another probe has just left it open.

    The held finger leads the object away and back to where it lay. Where that might tip what is
    expected, both fingers stay on it and the held one leads it on; where that might, too, the only
    place is where it lies. Friction may keep the object from being led away, but not on: the second
    time that is tried first.
    """
    world = model.world
    margins = np.array([STOP_MARGIN, -STOP_MARGIN])
    stops = world.limits[[0, 1], [0, 1]] + margins
    ends = np.clip(ends, *(world.limits + margins).T)
    sides = (held, 1 - held) if shifts else (held,)
    away = [(side, AWAY, OPENED) for side in sides]
    on = [(side, ON, 0.0) for side in sides if shifts]
    best, side, opened = Squeezing(ends[[held]], WEAKEST, 0.0), held, 0.0
    for finger, stretches, opening in on + away if again else away + on:
        found = _squeezing(model, hypotheses, expected, finger, ends[finger], stretches)
        if found.worth > best.worth:
            best, side, opened = found, finger, opening
        if best.worth == ENOUGH:
            break
    weights = world.finger_weights
    return Probe(side, best.places, np.full(2, opened), best.torque, weights, stops)


class Squeezing(NamedTuple):
    """places (k,) [rad] of the held finger; torque [N m] of the other one; separation: see
    `_separation`.
    """

    places: np.ndarray
    torque: float
    separation: float

    @property
    def worth(self) -> tuple[bool, float]:
        """Whether the places are wide apart; the separation, as far as it counts."""
        return bool(np.ptp(self.places) > WIDE), min(self.separation, SEPARATED)


def _squeezing(
    model: SqueezeModel,
    hypotheses: tuple[Resting, ...],
    expected: int,
    held: int,
    end: float,
    stretches: tuple[float, ...],
) -> Squeezing:
    """At places where nothing tips: over the first of the stretches [rad] that separates enough,
    else the one that separates most. Only at `end` without two such places.
    """
    low, high = model.world.limits[held] + [STOP_MARGIN / 2, -STOP_MARGIN / 2]
    offsets = np.sign(stretches[0]) * np.arange(0.0, abs(stretches[-1]) + GRID / 2, GRID)
    thetas = end + CLOSING[held] * offsets
    offsets = offsets[(thetas > low) & (thetas < high)]
    best = Squeezing(np.array([end]), WEAKEST, 0.0)
    if len(offsets) < 2:
        return best
    thetas = end + CLOSING[held] * offsets
    alone = stretches[0] < 0.0
    tipping = np.array(
        [
            _tipping_along(model, one, held, thetas, DOUBT if k == expected else NO_DOUBT, alone)
            for k, one in enumerate(hypotheses)
        ]
    )
    if expected >= 0:
        angles = model.squeeze(hypotheses[expected], held, thetas)[1]
        tipping[expected] -= SWING * np.abs(np.gradient(angles, GRID))
    safe = np.flatnonzero(_safe_stretch(tipping, expected))
    for stretch in stretches:
        used = safe[np.abs(offsets[safe]) < abs(stretch) + GRID / 2]
        if len(used) < 2:
            break
        first, last = CLOSING[held] * np.sort(CLOSING[held] * thetas[used])[[0, -1]]
        places = np.linspace(first, last, PLACES)
        separation = _separation(model, hypotheses, expected, held, places)
        if separation > best.separation:
            torque = float(np.nanmin(tipping[:, used])) / SAFETY
            best = Squeezing(places, float(np.clip(torque, WEAKEST, STRONGEST)), separation)
        if best.separation >= SEPARATED:
            break
    return best


def _separation(
    model: SqueezeModel,
    hypotheses: tuple[Resting, ...],
    expected: int,
    held: int,
    places: np.ndarray,
) -> float:
    """χ² by which squeezes at `places` (k,) [rad] of the object as expected miss those of the next
    best hypothesis that does not feel the same; without an expected one, the least over all of
    them.
    """
    classes = alike(model, hypotheses)
    told = {m: model.predict(hypotheses[m[0]], held, places) for m in classes}
    least = np.inf
    for members in classes:
        true = told[members].angles
        if (expected >= 0 and expected not in members) or not np.isfinite(true).all():
            continue
        for others in classes:
            one = told[others]
            rows = np.isfinite(one.angles) & np.isfinite(one.by_vertices).all(axis=1)
            if others == members and not rows.all():
                return 0.0
            if others == members or not rows.any():
                continue
            by_held, innovation = one.by_held[rows], (true - one.angles)[rows]
            covariance = pairs_covariance(
                one.by_vertices[rows], derivatives_by_zeros(held, by_held), by_held
            )
            least = min(least, float(innovation @ np.linalg.solve(covariance, innovation)))
    return least


def _tipping_along(
    model: SqueezeModel,
    resting: Resting,
    held: int,
    thetas: np.ndarray,
    doubt: Doubt,
    alone: bool,
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
        found[k] = tipping_torque(
            model, resting, held, slides[k], thetas[k], angles[k], doubt, alone
        )
    return found


def _safe_stretch(tipping: np.ndarray, expected: int) -> np.ndarray:
    """(k,) bool: the first stretch of places in which the expected object, and others that are met,
    do not tip; on the way there the expected one does not, either.
    """
    others, firm = tipping, np.ones(tipping.shape[1], bool)
    good = np.isfinite(tipping).any(axis=0)
    if expected >= 0:
        firm = good = np.nan_to_num(tipping[expected]) > SAFETY * WEAKEST
        others = np.delete(tipping, expected, axis=0)
    good = good & ~(np.isfinite(others) & (others < WEAKEST)).any(axis=0)
    keep = np.zeros(tipping.shape[1], bool)
    for k in range(len(keep)):
        if not firm[k] or (keep.any() and not good[k]):
            break
        keep[k] = good[k]
    return keep


def probe_after(feeler: Feeler, trajectory: ManipulationTrajectory, again: bool = False) -> Probe:
    """The probe after a trajectory: what is expected is the edge on which its last pose lies, if it
    lies on one; again: see `plan_probe`.
    """
    held = trajectory.segments[-1].velocity_finger
    expected = nearest_resting(feeler.hypotheses, trajectory.poses[-1])
    goal = feeler.model.scenario.goal
    shifts = isinstance(goal, GoalOnEdge) and goal.x is None
    ends = trajectory.angles[-1]
    return plan_probe(feeler.model, feeler.hypotheses, expected, held, ends, shifts, again)


def probe_of_the_unknown(feeler: Feeler, held: int, angles: np.ndarray) -> Probe:
    """The probe of whatever lies in the hand; angles (2,) [rad]: where the fingers stand."""
    return plan_probe(feeler.model, feeler.hypotheses, -1, held, angles)


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
