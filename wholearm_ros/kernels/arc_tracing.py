"""One-dimensional arcs of configurations on which four contacts stay closed: predictor–corrector, ended by the first event."""

import numpy as np

from wholearm_ros.kernels import allocating, kernel
from wholearm_ros.kernels.geometry import (
    contact,
    contact_in,
    entry_of,
    frame_of,
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

# why an arc ended
CLOSED, EDGE_END, JOINT_LIMIT, SINGULAR, NO_EQUILIBRIUM, CAGED, BLOCKED, TOO_LONG, LANDED = (
    1,
    2,
    3,
    4,
    5,
    6,
    7,
    8,
    9,
)

FIRST_STEP = 0.01  # of the scaled arc length, in which two thirds of a finger count as 1 rad
LARGEST_STEP = 0.06
SMALLEST_STEP = 1e-7
LARGEST_TURN = 0.15  # of the unit tangent in one step
GAP_TOLERANCE = 1e-10  # [m] residual of the projection
EVENT_TOLERANCE = 1e-9  # [m] overshoot left at an event
SAME_POINT = 1e-6  # [m] a contact this near the end of its edge is at the end
PARALLEL = 1e-6  # [rad] normals this near are the same: an edge lies on an edge


@allocating
def project(obj, palm, fingers, codes, q, hold, rows, gaps):
    """Newton on gap = 0 of the four pairs, moving q orthogonally to `hold` (5,). Returns True when it converged."""
    m = np.empty((5, 5))
    b = np.empty((5, 1))
    for _ in range(12):
        normal_rows(obj, palm, fingers, codes, q, rows, gaps)
        worst = 0.0
        for i in range(4):
            worst = max(worst, abs(gaps[i]))
        if worst < GAP_TOLERANCE:
            return True
        if worst > 0.05:
            return False
        for i in range(4):
            for j in range(5):
                m[i, j] = rows[i, j]
            b[i, 0] = -gaps[i]
        for j in range(5):
            m[4, j] = hold[j]
        b[4, 0] = 0.0
        if solve_in_place(m, b) < 1e-12:
            return False
        for j in range(5):
            q[j] += b[j, 0]
    return False


@kernel
def overshoot(obj, palm, fingers, corners, codes, limits, q, skip, gaps, table_codes):
    """The most violated inequality at q: (amount > 0 when violated [m or rad], event, its pair or index).

    skip: (m,) entries of the gap table that are active contacts.
    """
    worst, event, which = -np.inf, 0, 0
    gap_table(obj, palm, fingers, corners, q, gaps, table_codes)
    for e in range(gaps.shape[0]):
        if not skip[e] and -gaps[e] > worst:
            worst, event, which = -gaps[e], CLOSED, table_codes[e]
    frame = frame_of(q)
    for i in range(codes.shape[0]):
        _, _, _, _, _, along, length = contact_in(obj, palm, fingers, codes[i], q, frame)
        past = max(-along, along - length)
        if past > worst:
            worst, event, which = past, EDGE_END, codes[i]
    for side in range(2):
        past = max(limits[side, 0] - q[3 + side], q[3 + side] - limits[side, 1])
        if past > worst:
            worst, event, which = past, JOINT_LIMIT, side
    return worst, event, which


@allocating
def statics_at(
    obj, palm, fingers, codes, q, tangent, load, finger_moment, torque_limits, friction, rows, out
):
    """Fill out (2, 4): per torque-controlled finger (τ_min, τ_max) frictionless and (τ_min, τ_max) good with and without friction.

    Moving along `tangent`, friction acts against the sliding of each contact.
    """
    here = np.empty(5)
    load_at(load, finger_moment, q, here)
    forces = np.empty((4, 2))
    slides = np.empty((4, 5))
    tilted = np.empty((4, 5))
    tangent_rows(obj, palm, fingers, codes, q, slides)
    tilt_rows(rows, slides, tangent, friction, tilted)
    for side in range(2):
        low, high, _ = torque_interval(rows, here, torque_limits, 3 + side, forces)
        out[side, 0], out[side, 1] = low, high
        low2, high2, _ = torque_interval(tilted, here, torque_limits, 3 + side, forces)
        out[side, 2], out[side, 3] = max(low, low2), min(high, high2)


@kernel
def touches_palm(codes):
    for i in range(codes.shape[0]):
        if pair_body(codes[i]) == 0 and pair_kind(codes[i]) == 0:
            return True
    return False


@allocating
def trace_arc(
    obj,
    palm,
    fingers,
    corners,
    scale,
    limits,
    load,
    finger_moment,
    torque_limits,
    friction,
    cages,
    codes,
    q0,
    toward,
    driver,
    qs,
    tangents,
    statics,
):
    """Follow the arc on which the pairs `codes` (4,) stay closed from q0 (5,) towards the side of `toward` (5,).

    scale: (5,) coordinates per unit of arc length; limits: (2, 2) joint limits; load, finger_moment, torque_limits: see statics;
    friction: coefficient for the robust range; cages: (c, 2) intervals of φ in which gravity alone turns the object on to rest, and equilibrium may be lost;
    driver: 0 or 1, the velocity-controlled finger, whose direction must not reverse, or −1 for either.
    Fills qs (m, 5), tangents (m, 5), statics (m, 2, 4). Returns (samples, event, pair or index).
    """
    size = table_size(obj, palm, corners)
    gaps, table_codes, skip = np.empty(size), np.empty(size, np.int64), np.zeros(size, np.bool_)
    for i in range(4):
        skip[entry_of(obj, palm, corners, codes[i])] = True
    rows, pair_gaps = np.empty((4, 5)), np.empty(4)
    q, t, tn, qn = q0.copy(), np.empty(5), np.empty(5), np.empty(5)
    touching = touches_palm(codes)
    reference = toward.copy()

    if not project(
        obj,
        palm,
        fingers,
        codes,
        q,
        _hold(obj, palm, fingers, codes, q, scale, rows, pair_gaps, t),
        rows,
        pair_gaps,
    ):
        return 0, BLOCKED, 0
    if null_vector(rows, scale, t) < 1e-9:
        return 0, SINGULAR, 0
    _orient(t, reference, scale)
    first = overshoot(obj, palm, fingers, corners, codes, limits, q, skip, gaps, table_codes)[0]
    if first > 1e-7:
        return 0, BLOCKED, 0
    if _blocked_at_start(obj, palm, fingers, corners, codes, limits, q, t, skip, gaps, table_codes):
        return 0, BLOCKED, 0
    count, step = 0, FIRST_STEP
    start_sign = 0.0 if driver < 0 else np.sign(t[3 + driver])
    if driver >= 0 and abs(t[3 + driver]) < 1e-6:
        return 0, SINGULAR, 0
    while True:
        statics_at(
            obj,
            palm,
            fingers,
            codes,
            q,
            t,
            load,
            finger_moment,
            torque_limits,
            friction,
            rows,
            statics[count],
        )
        qs[count], tangents[count] = q, t
        count += 1
        if (
            statics[count - 1, 0, 0] > statics[count - 1, 0, 1]
            and statics[count - 1, 1, 0] > statics[count - 1, 1, 1]
        ):
            if touching and in_cage(cages, q[2]) and t[2] > 0.0:
                return count, CAGED, 0
            return count, NO_EQUILIBRIUM, 0
        if count == qs.shape[0]:
            return count, TOO_LONG, 0
        while True:
            for j in range(5):
                qn[j] = q[j] + step * t[j]
            good = project(obj, palm, fingers, codes, qn, _scaled(t, scale), rows, pair_gaps)
            if good:
                good = null_vector(rows, scale, tn) > 1e-9
            if good:
                _orient(tn, t, scale)
                turn = 0.0
                for j in range(5):
                    turn += ((tn[j] - t[j]) / scale[j]) ** 2
                good = turn < LARGEST_TURN**2
            if good:
                break
            step *= 0.4
            if step < SMALLEST_STEP:
                return count, SINGULAR, 0
        if driver >= 0 and np.sign(tn[3 + driver]) != start_sign:
            return count, SINGULAR, 0
        past, event, which = overshoot(
            obj, palm, fingers, corners, codes, limits, qn, skip, gaps, table_codes
        )
        if past > EVENT_TOLERANCE:
            event, which = _locate(
                obj,
                palm,
                fingers,
                corners,
                codes,
                limits,
                scale,
                q,
                t,
                step,
                past,
                event,
                which,
                qn,
                skip,
                gaps,
                table_codes,
                rows,
                pair_gaps,
            )
            null_vector(rows, scale, tn)
            _orient(tn, t, scale)
            if count == qs.shape[0]:
                return count, TOO_LONG, 0
            statics_at(
                obj,
                palm,
                fingers,
                codes,
                qn,
                tn,
                load,
                finger_moment,
                torque_limits,
                friction,
                rows,
                statics[count],
            )
            qs[count], tangents[count] = qn, tn
            count += 1
            return count, event, which
        q[:], t[:] = qn, tn
        step = min(1.7 * step, LARGEST_STEP)


@kernel
def in_cage(cages, angle):
    for k in range(cages.shape[0]):
        if cages[k, 0] <= angle <= cages[k, 1]:
            return True
    return False


@allocating
def _scaled(t, scale):
    """The covector that measures arc length along t."""
    out = np.empty(5)
    for j in range(5):
        out[j] = t[j] / scale[j] ** 2
    return out


@allocating
def _hold(obj, palm, fingers, codes, q, scale, rows, gaps, t):
    normal_rows(obj, palm, fingers, codes, q, rows, gaps)
    null_vector(rows, scale, t)
    return _scaled(t, scale)


@kernel
def _orient(t, reference, scale):
    dot = 0.0
    for j in range(5):
        dot += t[j] * reference[j] / scale[j] ** 2
    if dot < 0.0:
        for j in range(5):
            t[j] = -t[j]


@allocating
def _blocked_at_start(obj, palm, fingers, corners, codes, limits, q, t, skip, gaps, table_codes):
    """Whether a feature that is closed at q, but not one of the pairs, would penetrate when moving along t."""
    probe = q + 1e-6 * t
    rate_limit = 1e-6 * 1e-4
    gap_table(obj, palm, fingers, corners, q, gaps, table_codes)
    before = gaps.copy()
    gap_table(obj, palm, fingers, corners, probe, gaps, table_codes)
    for e in range(gaps.shape[0]):
        if not skip[e] and before[e] < 1e-7 and gaps[e] - before[e] < -rate_limit:
            return True
    for side in range(2):
        if q[3 + side] <= limits[side, 0] + 1e-9 and t[3 + side] < 0.0:
            return True
        if q[3 + side] >= limits[side, 1] - 1e-9 and t[3 + side] > 0.0:
            return True
    for i in range(4):
        _, _, _, _, _, along, length = contact(obj, palm, fingers, codes[i], q)
        _, _, _, _, _, later, _ = contact(obj, palm, fingers, codes[i], probe)
        if (along < 1e-8 and later < along) or (along > length - 1e-8 and later > along):
            return True
    return False


@allocating
def _locate(
    obj,
    palm,
    fingers,
    corners,
    codes,
    limits,
    scale,
    q,
    t,
    step,
    past,
    event,
    which,
    qn,
    skip,
    gaps,
    table_codes,
    rows,
    pair_gaps,
):
    """Shrink [0, step] around the first instant at which the worst inequality is violated; qn receives the configuration."""
    low, high = 0.0, step
    value_low = overshoot(obj, palm, fingers, corners, codes, limits, q, skip, gaps, table_codes)[0]
    value_high = past
    hold = _scaled(t, scale)
    for k in range(60):
        middle = 0.5 * (low + high)
        if k % 3 != 2 and value_low < 0.0 and value_high > value_low:
            middle = low + (high - low) * (-value_low) / (value_high - value_low)
            middle = min(max(middle, low + 0.01 * (high - low)), high - 0.01 * (high - low))
        for j in range(5):
            qn[j] = q[j] + middle * t[j]
        if not project(obj, palm, fingers, codes, qn, hold, rows, pair_gaps):
            high = middle
            continue
        value, e, w = overshoot(
            obj, palm, fingers, corners, codes, limits, qn, skip, gaps, table_codes
        )
        if value > 0.0:
            high, value_high, event, which = middle, value, e, w
            if value < EVENT_TOLERANCE:
                break
        else:
            low, value_low = middle, value
        if high - low < 1e-13:
            break
    for j in range(5):
        qn[j] = q[j] + high * t[j]
    project(obj, palm, fingers, codes, qn, hold, rows, pair_gaps)
    if event == CLOSED:  # a vertex that meets a vertex seems to close a pair, too
        for i in range(codes.shape[0]):
            _, _, _, _, _, along, length = contact(obj, palm, fingers, codes[i], qn)
            if (along < SAME_POINT or along > length - SAME_POINT) and pair_body(
                codes[i]
            ) == pair_body(which):
                return EDGE_END, codes[i]
    return event, which


@kernel
def next_pair_at_end(obj, palm, fingers, code, q):
    """The pair that replaces `code` when its contact point has come to the end of its edge (X_through).

    At the vertex–vertex instant the boundary of the contact's C-obstacle turns from one patch to the next: the next one is
    that whose normal comes first when the present normal turns towards the direction in which the object leaves the edge.
    Returns −1 when there is none (a finger's base, the palm's end with nothing beyond).
    """
    body, hf, of = pair_body(code), pair_hand_feature(code), pair_object_feature(code)
    n = obj.shape[0]
    frame = frame_of(q)
    _, _, nx, ny, _, along, length = contact_in(obj, palm, fingers, code, q, frame)
    at_end = along > 0.5 * length
    if pair_kind(code) == 0:
        vertex = of
        _, _, dx, dy, _, _, _ = hand_edge(palm, fingers, body, hf, frame)
        corner = _hand_corner_at(body, hf, at_end)
        if not at_end:
            dx, dy = -dx, -dy
    else:
        vertex = (of + 1) % n if at_end else of
        _, _, dx, dy, _, _, _ = object_edge(obj, of, q, frame)
        if at_end:
            dx, dy = -dx, -dy
        corner = hf
    if corner < 0:
        return -1
    best, angle = -1, np.pi
    for k in range(4):
        if k < 2:
            j = vertex if k == 0 else (vertex - 1) % n
            candidate = pair_code(1, body, corner, j)
            _, _, _, _, mx, my, _ = object_edge(obj, j, q, frame)
            mx, my = -mx, -my
        else:
            edge = _hand_edge_at(palm, body, corner, k - 2)
            if edge < 0:
                continue
            candidate = pair_code(0, body, edge, vertex)
            _, _, _, _, mx, my, _ = hand_edge(palm, fingers, body, edge, frame)
        if candidate == code:
            continue
        turned = np.arctan2(dx * mx + dy * my, nx * mx + ny * my)
        if -PARALLEL < turned < angle:
            best, angle = candidate, turned
    return best


@kernel
def _hand_corner_at(body, edge, at_end):
    """The corner at that end of a hand edge, or −1."""
    if body == 0:
        return edge + 1 if at_end else edge
    if edge == 0:
        return 0 if at_end else -1
    if edge == 1:
        return 0 if at_end else 1
    return 1 if at_end else -1


@kernel
def _hand_edge_at(palm, body, corner, k):
    """The two hand edges that meet in a corner."""
    if body == 0:
        edge = corner - 1 + k
        return edge if 0 <= edge < palm.shape[0] - 1 else -1
    if k == 1:
        return 1
    return 0 if corner == 0 else 2


@allocating
def follow(
    obj,
    palm,
    fingers,
    codes,
    samples,
    driver,
    thetas,
    load,
    finger_moment,
    torque_limits,
    friction,
    out,
    statics,
    gains,
):
    """Configurations on an arc at given angles of the velocity-controlled finger (forward kinematics, MAIN_TRAJECTORY step 6).

    samples: (m, 5) along the arc, θ_V monotone; thetas: (k,) in the same order. Fills out (k, 5), statics (k, 2, 4) as
    `statics_at`, gains (k, 2): the velocity finger's equilibrium torque is gains[:, 0] + gains[:, 1] τ_T.
    Returns the number of configurations found; fewer than k when Newton fails.
    """
    rows, gaps, t, hold, forces = (
        np.empty((4, 5)),
        np.empty(4),
        np.empty(5),
        np.zeros(5),
        np.empty((4, 2)),
    )
    here = np.empty(5)
    hold[3 + driver] = 1.0
    column = 3 + driver
    rising = samples[samples.shape[0] - 1, column] > samples[0, column]
    i = 0
    one = np.ones(5)
    for k in range(thetas.shape[0]):
        while i < samples.shape[0] - 2 and (samples[i + 1, column] < thetas[k]) == rising:
            i += 1
        span = samples[i + 1, column] - samples[i, column]
        u = (thetas[k] - samples[i, column]) / span if abs(span) > 1e-12 else 0.0
        for j in range(5):
            out[k, j] = (1.0 - u) * samples[i, j] + u * samples[i + 1, j]
        out[k, column] = thetas[k]
        if not project(obj, palm, fingers, codes, out[k], hold, rows, gaps):
            return k
        normal_rows(obj, palm, fingers, codes, out[k], rows, gaps)
        null_vector(rows, one, t)
        if (t[column] > 0.0) != rising:
            for j in range(5):
                t[j] = -t[j]
        statics_at(
            obj,
            palm,
            fingers,
            codes,
            out[k],
            t,
            load,
            finger_moment,
            torque_limits,
            friction,
            rows,
            statics[k],
        )
        load_at(load, finger_moment, out[k], here)
        equilibrium_forces(rows, here, 4 - driver, forces)
        gains[k, 0], gains[k, 1] = here[column], 0.0
        for c in range(4):
            gains[k, 0] -= rows[c, column] * forces[c, 0]
            gains[k, 1] -= rows[c, column] * forces[c, 1]
    return thetas.shape[0]
