"""One-dimensional arcs of configurations on which four contacts stay closed: predictor–corrector,
ended by the first event.
"""

from typing import NamedTuple

import numpy as np

from wholearm_ros.kernels import allocating, inlined, kernel
from wholearm_ros.kernels.geometry import (
    EDGE_CORNER,
    LEFT_FINGER,
    PALM,
    VERTEX_EDGE,
    contact_at,
    entry_of,
    frames_of,
    gap_table,
    hand_edge,
    normal_rows,
    object_edge,
    pair_body,
    pair_code,
    pair_hand_feature,
    pair_kind,
    pair_object_feature,
    table_size,
    tangent_rows,
)
from wholearm_ros.kernels.linear import null_vector, solve_in_place
from wholearm_ros.kernels.statics import equilibrium_forces, load_at, tilt_rows, torque_interval
from wholearm_ros.kernels.world import joint
from wholearm_ros.model.configuration import ROTATION, SIZE

# why an arc ended
CLOSED, EDGE_END, JOINT_LIMIT, SINGULAR, NO_EQUILIBRIUM, CAGED, BLOCKED, TOO_LONG = range(1, 9)

FIRST_STEP = 0.01  # of the scaled arc length, in which two thirds of a finger count as 1 rad
LARGEST_STEP = 0.06
SMALLEST_STEP = 1e-7
LARGEST_TURN = 0.15  # of the unit tangent in one step
GAP_TOLERANCE = 1e-10  # [m] residual of the projection
LARGEST_GAP = 0.05  # [m] beyond which the projection gives up
EVENT_TOLERANCE = 1e-9  # [m] overshoot left at an event
START_TOLERANCE = 1e-7  # [m] penetration at the start, and gap of what is closed there
SAME_POINT = 1e-6  # [m] a contact this near the end of its edge is at the end
PARALLEL = 1e-6  # [rad] normals this near are the same: an edge lies on an edge
RANK_FOUR = 1e-9  # least norm of the tangent by cofactors
PROBE = 1e-6  # of the scaled arc length, by which it is seen what a motion does to what is closed


class ArcTask(NamedTuple):
    """Which arc: codes: (4,) pairs that stay closed; start: (5,); toward: (5,), to the side of
    which it goes; driver: 0 or 1, the velocity-controlled finger, whose direction must not
    reverse, or −1 for either; friction: coefficient for the robust range; cages: (c, 2)
    intervals of φ [rad] in which gravity alone turns the object on to rest, and equilibrium may
    be lost.
    """

    codes: np.ndarray
    start: np.ndarray
    toward: np.ndarray
    driver: int
    friction: float
    cages: np.ndarray


class ArcSamples(NamedTuple):
    """What is filled in along an arc: configurations, tangents: (m, 5); statics: (m, 2, 4), see
    `statics_at`.
    """

    configurations: np.ndarray
    tangents: np.ndarray
    statics: np.ndarray


class Place(NamedTuple):
    """A configuration q (5,) on an arc and the unit tangent t (5,) there."""

    q: np.ndarray
    t: np.ndarray


class Event(NamedTuple):
    """The most violated inequality: amount > 0 when violated [m or rad], its kind, and its pair or
    joint.
    """

    amount: float
    kind: int
    which: int


class Manifold(NamedTuple):
    """The configurations on which the pairs codes (4,) are closed. member: (n,) entries of the gap
    table that they are.

    Of the configuration that was looked at last: rows: (4, 5) and pair_gaps: (4,) of the pairs,
    gaps and table_codes: (n,) of the gap table. The rest is room: newton: (5, 5), update: (5, 1),
    hold, load: (5,), slides, tilted: (4, 5), forces: (4, 2).
    """

    codes: np.ndarray
    member: np.ndarray
    rows: np.ndarray
    pair_gaps: np.ndarray
    gaps: np.ndarray
    table_codes: np.ndarray
    newton: np.ndarray
    update: np.ndarray
    hold: np.ndarray
    load: np.ndarray
    slides: np.ndarray
    tilted: np.ndarray
    forces: np.ndarray


@allocating
def new_manifold(world, codes):
    """The manifold of the pairs codes (4,)."""
    n = table_size(world)
    member = np.zeros(n, np.bool_)
    for i in range(codes.shape[0]):
        member[entry_of(world, codes[i])] = True
    return Manifold(
        codes,
        member,
        np.empty((4, SIZE)),
        np.empty(4),
        np.empty(n),
        np.empty(n, np.int64),
        np.empty((SIZE, SIZE)),
        np.empty((SIZE, 1)),
        np.empty(SIZE),
        np.empty(SIZE),
        np.empty((4, SIZE)),
        np.empty((4, SIZE)),
        np.empty((4, 2)),
    )


@allocating
def trace_arc(world, task, samples):
    """Follow the arc that an `ArcTask` names, until the first event, and fill samples.

    Returns (number of samples, event, its pair or index).
    """
    on = new_manifold(world, task.codes)
    here, ahead = Place(task.start.copy(), np.empty(SIZE)), Place(np.empty(SIZE), np.empty(SIZE))
    event = _begin(world, on, task, here)
    if event:
        return 0, event, 0
    count, length, sense = 0, FIRST_STEP, _sense(task, here.t)
    while True:
        count = _keep(world, on, task, here, samples, count)
        event = _not_in_equilibrium(on, task, here, samples.statics[count - 1])
        if event:
            return count, event, 0
        if count == samples.configurations.shape[0]:
            return count, TOO_LONG, 0
        length = _predict_and_correct(world, on, here, length, ahead)
        if length == 0.0 or _sense(task, ahead.t) != sense:
            return count, SINGULAR, 0
        past = overshoot(world, on, ahead.q)
        if past.amount > EVENT_TOLERANCE:
            past = _locate(world, on, here, length, past, ahead.q)
            _tangent(world, on, here.t, ahead.t)
            return _keep(world, on, task, ahead, samples, count), past.kind, past.which
        for j in range(SIZE):
            here.q[j], here.t[j] = ahead.q[j], ahead.t[j]
        length = min(1.7 * length, LARGEST_STEP)


@kernel
def _begin(world, on, task, here):
    """Bring here.q onto the manifold and find the tangent there. Returns why there is no arc from
    there, or 0.
    """
    q, t = here.q, here.t
    normal_rows(world, on.codes, q, on.rows, on.pair_gaps)
    null_vector(on.rows, world.scale, t)
    _covector(world, t, on.hold)
    if not project(world, on, q, on.hold):
        return BLOCKED
    if not _tangent(world, on, task.toward, t):
        return SINGULAR
    if overshoot(world, on, q).amount > START_TOLERANCE or _blocked_at_start(world, on, here):
        return BLOCKED
    if task.driver >= 0 and abs(t[joint(task.driver)]) < 1e-6:
        return SINGULAR
    return 0


@kernel
def project(world, on, q, hold):
    """Newton on gap = 0 of the four pairs, moving q orthogonally to `hold` (5,). Returns True when
    it converged.
    """
    rows, gaps, newton, update = on.rows, on.pair_gaps, on.newton, on.update
    for _ in range(12):
        normal_rows(world, on.codes, q, rows, gaps)
        worst = 0.0
        for i in range(4):
            worst = max(worst, abs(gaps[i]))
        if worst < GAP_TOLERANCE:
            return True
        if worst > LARGEST_GAP:
            return False
        for j in range(SIZE):
            for i in range(4):
                newton[i, j] = rows[i, j]
            newton[4, j] = hold[j]
        for i in range(4):
            update[i, 0] = -gaps[i]
        update[4, 0] = 0.0
        if solve_in_place(newton, update) < 1e-12:
            return False
        for j in range(SIZE):
            q[j] += update[j, 0]
    return False


@kernel
def _predict_and_correct(world, on, here, length, ahead):
    """A step of at most `length` from `here`, brought back onto the manifold: `ahead`. Shorter
    where Newton fails or the tangent turns too much. Returns the length of the step, 0 when even
    the smallest one fails.
    """
    while True:
        _covector(world, here.t, on.hold)
        if _projected(world, on, here, length, ahead.q) and _tangent(world, on, here.t, ahead.t):
            turn = 0.0
            for j in range(SIZE):
                turn += ((ahead.t[j] - here.t[j]) / world.scale[j]) ** 2
            if turn < LARGEST_TURN**2:
                return length
        length *= 0.4
        if length < SMALLEST_STEP:
            return 0.0


@inlined
def _projected(world, on, here, length, q):
    """q (5,): `length` along the tangent from `here`, brought back onto the manifold. Whether it
    converged.
    """
    for j in range(SIZE):
        q[j] = here.q[j] + length * here.t[j]
    return project(world, on, q, on.hold)


@kernel
def _tangent(world, on, toward, t):
    """Fill t (5,) with the unit tangent to the side of `toward`. Whether there is one: the rows
    have rank four.
    """
    regular, along = null_vector(on.rows, world.scale, t) >= RANK_FOUR, 0.0
    for j in range(SIZE):
        along += t[j] * toward[j] / world.scale[j] ** 2
    if along < 0.0:
        for j in range(SIZE):
            t[j] = -t[j]
    return regular


@inlined
def _covector(world, t, hold):
    """The covector that measures arc length along t."""
    for j in range(SIZE):
        hold[j] = t[j] / world.scale[j] ** 2


@inlined
def _sense(task, t):
    """The sense in which the velocity finger turns along t; 0 when either finger may drive."""
    return 0.0 if task.driver < 0 else np.sign(t[joint(task.driver)])


@kernel
def _keep(world, on, task, here, samples, count):
    """Make `here` and its statics a sample. Returns how many there are now."""
    statics_at(world, on, here, task.friction, samples.statics[count])
    for j in range(SIZE):
        samples.configurations[count, j], samples.tangents[count, j] = here.q[j], here.t[j]
    return count + 1


@kernel
def statics_at(world, on, here, friction, out):
    """Fill out (2, 4): per torque-controlled finger (τ_min, τ_max) frictionless and (τ_min, τ_max)
    with and without friction.

    Moving along the tangent, friction acts against the sliding of each contact. on.rows are those
    at here.q.
    """
    limits = world.torque_limits
    load_at(world.load, world.finger_weights, here.q, on.load)
    tangent_rows(world, on.codes, here.q, on.slides)
    tilt_rows(on.rows, on.slides, here.t, friction, on.tilted)
    for side in range(2):
        low, high, _ = torque_interval(on.rows, on.load, limits, side, on.forces)
        out[side, 0], out[side, 1] = low, high
        low2, high2, _ = torque_interval(on.tilted, on.load, limits, side, on.forces)
        out[side, 2], out[side, 3] = max(low, low2), min(high, high2)


@inlined
def _not_in_equilibrium(on, task, here, statics):
    """CAGED or NO_EQUILIBRIUM where no torque of either finger holds the object, else 0."""
    if statics[0, 0] <= statics[0, 1] or statics[1, 0] <= statics[1, 1]:
        return 0
    caged = touches_palm(on.codes) and in_cage(task.cages, here.q[ROTATION])
    if caged and here.t[ROTATION] > 0.0:
        return CAGED
    return NO_EQUILIBRIUM


@kernel
def touches_palm(codes):
    """Whether a vertex of the object is on the palm."""
    for i in range(codes.shape[0]):
        if pair_body(codes[i]) == PALM and pair_kind(codes[i]) == VERTEX_EDGE:
            return True
    return False


@kernel
def in_cage(cages, angle):
    """Whether one of the intervals (c, 2) holds an angle [rad]."""
    for k in range(cages.shape[0]):
        if cages[k, 0] <= angle <= cages[k, 1]:
            return True
    return False


@kernel
def overshoot(world, on, q):
    """The `Event` of the most violated inequality at q."""
    worst, kind, which = -np.inf, 0, 0
    gaps, limits = on.gaps, world.limits
    gap_table(world, q, gaps, on.table_codes)
    for e in range(gaps.shape[0]):
        if not on.member[e] and -gaps[e] > worst:
            worst, kind, which = -gaps[e], CLOSED, on.table_codes[e]
    frames = frames_of(world, q)
    for i in range(on.codes.shape[0]):
        contact = contact_at(world, on.codes[i], frames)
        past = max(-contact.along, contact.along - contact.length)
        if past > worst:
            worst, kind, which = past, EDGE_END, on.codes[i]
    for side in range(2):
        past = max(limits[side, 0] - q[joint(side)], q[joint(side)] - limits[side, 1])
        if past > worst:
            worst, kind, which = past, JOINT_LIMIT, side
    return Event(worst, kind, which)


@allocating
def _blocked_at_start(world, on, here):
    """Whether a feature that is closed here, but not one of the pairs, would penetrate when moving
    along the tangent.
    """
    q, t, gaps, codes = here.q, here.t, on.gaps, on.table_codes
    probe = q + PROBE * t
    gap_table(world, q, gaps, codes)
    before = gaps.copy()
    gap_table(world, probe, gaps, codes)
    for e in range(gaps.shape[0]):
        closing = gaps[e] - before[e] < -1e-4 * PROBE
        if not on.member[e] and before[e] < START_TOLERANCE and closing:
            return True
    for side in range(2):
        j, low, high = joint(side), world.limits[side, 0], world.limits[side, 1]
        if (q[j] <= low + 1e-9 and t[j] < 0.0) or (q[j] >= high - 1e-9 and t[j] > 0.0):
            return True
    frames, frames_ahead = frames_of(world, q), frames_of(world, probe)
    for i in range(4):
        now = contact_at(world, on.codes[i], frames)
        later = contact_at(world, on.codes[i], frames_ahead).along
        if (now.along < 1e-8 and later < now.along) or (
            now.along > now.length - 1e-8 and later > now.along
        ):
            return True
    return False


@kernel
def _locate(world, on, here, length, past, q):
    """Shrink [0, length] around the first instant at which the worst inequality is violated, by
    regula falsi and every third time by halving; q receives the configuration. past: the event
    at `length`. Returns the event.
    """
    low, high = 0.0, length
    value_low, value_high = overshoot(world, on, here.q).amount, past.amount
    _covector(world, here.t, on.hold)
    for k in range(60):
        middle = 0.5 * (low + high)
        if k % 3 != 2 and value_low < 0.0 and value_high > value_low:
            middle = low + (high - low) * (-value_low) / (value_high - value_low)
            middle = min(max(middle, low + 0.01 * (high - low)), high - 0.01 * (high - low))
        if not _projected(world, on, here, middle, q):
            high = middle
            continue
        found = overshoot(world, on, q)
        if found.amount > 0.0:
            high, value_high, past = middle, found.amount, found
            if found.amount < EVENT_TOLERANCE:
                break
        else:
            low, value_low = middle, found.amount
        if high - low < 1e-13:
            break
    _projected(world, on, here, high, q)
    return _named(world, on, q, past)


@inlined
def _named(world, on, q, event):
    """The event at q; a vertex that meets a vertex seems to close a pair, but it is the end of an
    edge.
    """
    if event.kind == CLOSED:
        frames = frames_of(world, q)
        for i in range(on.codes.shape[0]):
            found = contact_at(world, on.codes[i], frames)
            at_end = found.along < SAME_POINT or found.along > found.length - SAME_POINT
            if at_end and pair_body(on.codes[i]) == pair_body(event.which):
                return Event(event.amount, EDGE_END, on.codes[i])
    return event


@kernel
def next_pair_at_end(world, code, q):
    """The pair that replaces `code` when its contact point has come to the end of its edge
    (X_through).

    At the vertex–vertex instant the boundary of the contact's C-obstacle turns from one patch to
    the next: the next one is that whose normal comes first when the present normal turns towards
    the direction in which the object leaves the edge. Returns −1 when there is none (a finger's
    base, the palm's end with nothing beyond).
    """
    body, frames, n = pair_body(code), frames_of(world, q), world.obj.shape[0]
    contact = contact_at(world, code, frames)
    vertex, corner, dx, dy = _meeting(world, code, contact, frames)
    best, angle = -1, np.pi
    if corner < 0:
        return best
    for k in range(4):
        if k < 2:
            j = vertex if k == 0 else (vertex - 1) % n
            candidate = pair_code(EDGE_CORNER, body, corner, j)
            next_edge = object_edge(world, j, frames.object)
            mx, my = -next_edge.nx, -next_edge.ny
        else:
            edge = _hand_edge_at(world, body, corner, k - 2)
            if edge < 0:
                continue
            candidate = pair_code(VERTEX_EDGE, body, edge, vertex)
            next_edge = hand_edge(world, body, edge, frames)
            mx, my = next_edge.nx, next_edge.ny
        turned = np.arctan2(dx * mx + dy * my, contact.nx * mx + contact.ny * my)
        if candidate != code and -PARALLEL < turned < angle:
            best, angle = candidate, turned
    return best


@inlined
def _meeting(world, code, contact, frames):
    """(object vertex, hand corner or −1, direction x, y in which the object leaves the edge) of a
    contact at its edge's end.
    """
    body, hand, mine = pair_body(code), pair_hand_feature(code), pair_object_feature(code)
    at_end = contact.along > 0.5 * contact.length
    if pair_kind(code) == VERTEX_EDGE:
        edge = hand_edge(world, body, hand, frames)
        vertex, corner, outwards = mine, _hand_corner_at(world, body, hand, at_end), at_end
    else:
        edge = object_edge(world, mine, frames.object)
        vertex = (mine + 1) % world.obj.shape[0] if at_end else mine
        corner, outwards = hand, not at_end
    return vertex, corner, edge.dx if outwards else -edge.dx, edge.dy if outwards else -edge.dy


@kernel
def _hand_corner_at(world, body, edge, at_end):
    """The corner at that end of a hand edge, or −1."""
    if body == PALM:
        return edge + 1 if at_end else edge
    row = world.features.edge_rows[body - LEFT_FINGER] + edge
    return world.features.edge_ends[row, 1 if at_end else 0]


@inlined
def _hand_edge_at(world, body, corner, k):
    """The two hand edges that meet in a corner."""
    if body == PALM:
        edge = corner - 1 + k
        return edge if 0 <= edge < world.palm.shape[0] - 1 else -1
    row = world.features.corner_rows[body - LEFT_FINGER] + corner
    return world.features.edges_at[row, k]


class FollowedCourse(NamedTuple):
    """What is filled in at angles of the velocity finger: configurations: (k, 5); statics: (k, 2,
    4), see `statics_at`; gains: (k, 2): the velocity finger's equilibrium torque is gains[:, 0]
    + gains[:, 1] τ_T [N m].
    """

    configurations: np.ndarray
    statics: np.ndarray
    gains: np.ndarray


class Following(NamedTuple):
    """What is followed: codes: (4,) pairs that stay closed; samples: (m, 5) along their arc, θ_V
    monotone; driver: 0 or 1, the velocity-controlled finger; friction: coefficient for the
    robust range.
    """

    codes: np.ndarray
    samples: np.ndarray
    driver: int
    friction: float


@allocating
def follow(world, following, thetas, course):
    """Configurations on an arc at given angles of the velocity-controlled finger (forward
    kinematics, MAIN_TRAJECTORY step 6).

    thetas: (k,) [rad] in the order of the samples; course: see `FollowedCourse`. Returns the number
    of configurations found; fewer than k when Newton fails.
    """
    on, one, t = new_manifold(world, following.codes), np.ones(SIZE), np.empty(SIZE)
    samples, column, i = following.samples, joint(following.driver), 0
    on.hold[:] = 0.0
    on.hold[column] = 1.0
    rising = samples[samples.shape[0] - 1, column] > samples[0, column]
    for k in range(thetas.shape[0]):
        while i < samples.shape[0] - 2 and (samples[i + 1, column] < thetas[k]) == rising:
            i += 1
        span = samples[i + 1, column] - samples[i, column]
        u = (thetas[k] - samples[i, column]) / span if abs(span) > 1e-12 else 0.0
        q = course.configurations[k]
        for j in range(SIZE):
            q[j] = (1.0 - u) * samples[i, j] + u * samples[i + 1, j]
        q[column] = thetas[k]
        if not project(world, on, q, on.hold):
            return k
        null_vector(on.rows, one, t)
        if (t[column] > 0.0) != rising:
            for j in range(SIZE):
                t[j] = -t[j]
        statics_at(world, on, Place(q, t), following.friction, course.statics[k])
        _velocity_torque(on, following.driver, course.gains[k])
    return thetas.shape[0]


@kernel
def _velocity_torque(on, driver, gains):
    """gains (2,): the velocity finger's equilibrium torque is gains[0] + gains[1] τ_T, from the
    rows and load looked at last.
    """
    column = joint(driver)
    equilibrium_forces(on.rows, on.load, 1 - driver, on.forces)
    gains[0], gains[1] = on.load[column], 0.0
    for c in range(4):
        gains[0] -= on.rows[c, column] * on.forces[c, 0]
        gains[1] -= on.rows[c, column] * on.forces[c, 1]
