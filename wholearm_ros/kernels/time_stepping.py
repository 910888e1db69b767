"""Time stepping of object and fingers under motor torques: one linear complementarity problem a step, impacts included.

M (v⁺ − v) = h F + (N − μ S T)ᵀ λ,   0 ≤ λ ⟂ N v⁺ + gap / h ≥ 0        (Stewart–Trinkle, Anitescu–Potra)
with M constant in q = (x, y, φ, θ_L, θ_R), N the rows ∂gap/∂q of every pair that could close in the step, T the sliding rows
and S the regularised signs of sliding. Without friction the matrix N M⁻¹ Nᵀ is symmetric and the step dissipates.
"""

import numpy as np
from numba.extending import overload

from wholearm_ros.kernels import kernel
from wholearm_ros.kernels.geometry import (
    contact_in,
    fill_row,
    frame_of,
    gap_table,
    left_the_hand,
    pair_body,
    table_entry,
    table_size,
)
from wholearm_ros.kernels.linear import solve_in_place

LARGEST_GUESS = 6  # active contacts that are solved for at once
SINGULAR = 1e-10  # smallest over largest pivot of an active set that is worth trying
NEAR = 0.002  # [m] pairs nearer than this (plus what they may travel in a step) enter the LCP
SLIP_SPEED = 1e-3  # [m/s] sliding slower than this has less than full friction
WATCH = 0.006  # [m] of motion for which the list of pairs that may come near is good
DEEPEST = 0.005  # [m] a deeper penetration is no contact: the feature is beyond the object
PUSHED_OUT = 0.25  # of a penetration, in one step


def lemke(a, b):
    """z ≥ 0 ⟂ a z + b ≥ 0 by Lemke's algorithm, a (k, k), b (k,). Its package takes a second to import, and is needed to
    compile a kernel only: a process that finds all kernels compiled does without."""
    from quantecon.optimize.lcp_lemke import lcp_lemke

    return lcp_lemke(a, b).z


@overload(lemke)
def _compiled_lemke(a, b):
    from quantecon.optimize.lcp_lemke import lcp_lemke

    return lambda a, b: lcp_lemke(a, b).z


@kernel
def solve_lcp(rows, pushes, b, guess, z):
    """z ≥ 0 ⟂ A z + b ≥ 0 with A = rows pushesᵀ (k, k), z (k,). First the active set `guess` (k,) bool (kept from the last
    step), then Lemke.

    Returns the residual max |min(z, A z + b)|.
    """
    k, m = b.shape[0], 0
    for i in range(k):
        m += guess[i]
    z[:] = 0.0
    if m <= LARGEST_GUESS:
        active, sub, rhs = np.empty(m, np.int64), np.empty((m, m)), np.empty((m, 1))
        m = 0
        for i in range(k):
            if guess[i]:
                active[m] = i
                rhs[m, 0] = -b[i]
                m += 1
        for i in range(m):
            for j in range(m):
                sub[i, j] = _product(rows, active[i], pushes, active[j])
        if m == 0 or solve_in_place(sub, rhs) > SINGULAR:
            for i in range(m):
                z[active[i]] = rhs[i, 0]
            residual = lcp_residual(rows, pushes, b, z)
            if residual < 1e-11:
                return residual
    a = np.empty((k, k))
    for i in range(k):
        for j in range(k):
            a[i, j] = _product(rows, i, pushes, j)
    z[:] = lemke(a, b)
    return lcp_residual(rows, pushes, b, z)


@kernel
def _product(rows, i, pushes, j):
    s = 0.0
    for c in range(rows.shape[1]):
        s += rows[i, c] * pushes[j, c]
    return s


@kernel
def lcp_residual(rows, pushes, b, z):
    """max_i |min(z_i, (rows pushesᵀ z + b)_i)|."""
    moved = np.zeros(rows.shape[1])
    for i in range(b.shape[0]):
        if z[i] != 0.0:
            for c in range(rows.shape[1]):
                moved[c] += pushes[i, c] * z[i]
    worst = 0.0
    for i in range(b.shape[0]):
        w = b[i]
        for c in range(rows.shape[1]):
            w += rows[i, c] * moved[c]
        worst = max(worst, abs(min(z[i], w)))
    return worst


@kernel
def new_work(obj, palm, corners):
    """What `step` keeps from one step to the next, for one body of arrays; of no use with another configuration's steps.

    (gaps, codes, active) of the gap table; (watched, ledger): entries that could close before the object or a finger has
    moved by ledger[0] [m], ledger[1] of them, ledger[2] the longest lever; then room for the problem itself.
    """
    n = table_size(obj, palm, corners)
    return (
        np.empty(n),
        np.empty(n, np.int64),
        np.zeros(n, np.bool_),
        np.empty(n, np.int64),
        np.zeros(3),
        np.empty(n, np.int64),
        np.empty((n, 5)),
        np.empty((n, 5)),
        np.empty(n),
        np.empty(n),
        np.zeros(n, np.bool_),
        np.empty((3, 5)),
    )


@kernel
def _update_gaps(
    obj, palm, fingers, corners, q, frame, within, gaps, codes, active, watched, ledger
):
    """Gaps of the watched entries at q; of all of them, and which to watch, when enough has moved since that was done."""
    if ledger[0] > 0.0:
        for k in range(int(ledger[1])):
            e = watched[k]
            gaps[e], codes[e] = table_entry(obj, palm, fingers, corners, e, q, frame)
        return
    count = 0
    gap_table(obj, palm, fingers, corners, q, gaps, codes)
    for e in range(gaps.shape[0]):
        if gaps[e] < within + WATCH or gaps[e] == np.inf:
            watched[count] = e
            count += 1
        else:
            active[e] = False
    ledger[0], ledger[1], ledger[2] = WATCH, count, _reach(obj, palm, fingers, q) + WATCH


@kernel
def _reach(obj, palm, fingers, q):
    """The longest lever [m] with which a rotation of the object or of a finger moves a contact."""
    size = 0.0
    for i in range(obj.shape[0]):
        size = max(size, np.hypot(obj[i, 0], obj[i, 1]))
    reach = size
    for side in range(2):
        away = np.hypot(q[0] - fingers[side, 0], q[1] - fingers[side, 1])
        reach = max(reach, away + max(size, fingers[side, 2] + fingers[side, 3]))
    for k in range(palm.shape[0]):
        reach = max(reach, np.hypot(q[0] - palm[k, 0], q[1] - palm[k, 1]))
    return reach


@kernel
def step(
    obj, palm, fingers, corners, inertias, load, finger_moment, friction, efforts, h, q, v, work
):
    """One step of h [s] from q, v (5,), both updated in place, under motor torques efforts (2,) [N m].

    work: see `new_work`. Returns (closed pairs, LCP residual [m/s]).
    """
    gaps, codes, active, watched, ledger, near, rows, pushes, b, z, guess, vectors = work
    frame = frame_of(q)
    within = NEAR + 2.0 * h
    _update_gaps(
        obj, palm, fingers, corners, q, frame, within, gaps, codes, active, watched, ledger
    )
    free, slide = vectors[0], vectors[1]
    free[0] = v[0] - h * load[0] / inertias[0]
    free[1] = v[1] - h * load[1] / inertias[1]
    free[2] = v[2] - h * load[2] / inertias[2]
    for i in range(2):
        free[3 + i] = (
            v[3 + i] + h * (efforts[i] - finger_moment[i] * frame[2 + 2 * i]) / inertias[3 + i]
        )
    k = 0
    for i in range(int(ledger[1])):
        e = watched[i]
        if -DEEPEST < gaps[e] < within:
            near[k] = e
            k += 1
        else:
            active[e] = False
    ahead = vectors[2]
    ahead[:] = q + h * v
    frame_ahead = frame_of(ahead)
    for i in range(k):
        e = near[i]
        # A feature is outside a convex body when it is outside one of its edges. Which one, is asked of where it will be: a
        # vertex that slides off a finger's tip is held by what comes after the tip, not by the edge that it leaves.
        codes[e] = table_entry(obj, palm, fingers, corners, e, ahead, frame_ahead)[1]
        px, py, nx, ny, gap, _, _ = contact_in(obj, palm, fingers, codes[e], q, frame)
        body = pair_body(codes[e])
        fill_row(rows[i], px, py, nx, ny, body, fingers, q)
        b[i] = max(gap, 0.0) / h if gaps[e] > 0.0 else PUSHED_OUT * gaps[e] / h
        for j in range(5):
            b[i] += rows[i, j] * free[j]
        sign = 0.0
        if friction > 0.0:
            fill_row(slide, px, py, -ny, nx, body, fingers, q)
            speed = 0.0
            for j in range(5):
                speed += slide[j] * v[j]
            sign = friction * min(max(speed / SLIP_SPEED, -1.0), 1.0)
        for j in range(5):
            pushes[i, j] = (rows[i, j] - (sign * slide[j] if sign != 0.0 else 0.0)) / inertias[j]
        guess[i] = active[e]
    residual = solve_lcp(rows[:k], pushes[:k], b[:k], guess[:k], z[:k])
    closed = 0
    for i in range(k):
        active[near[i]] = z[i] > 0.0
        if z[i] > 0.0:
            closed += 1
            for j in range(5):
                free[j] += pushes[i, j] * z[i]
    v[:] = free
    q += h * v
    ledger[0] -= h * (np.hypot(v[0], v[1]) + ledger[2] * (abs(v[2]) + max(abs(v[3]), abs(v[4]))))
    return closed, residual


@kernel
def run_trajectory(
    obj,
    palm,
    fingers,
    corners,
    inertias,
    load,
    finger_moment,
    torque_limits,
    friction,
    motor_gain,
    delay_steps,
    kp,
    kd,
    h,
    period,
    angles,
    velocities,
    efforts,
    velocity_finger,
    settle_steps,
    q_kept,
    v_kept,
    every,
    record_q,
    record_v,
):
    """The closed loop: PD on the velocity-controlled finger, open-loop torque on the other, for the whole trajectory.

    angles, velocities, efforts: (m, 2) every `period` [s]; velocity_finger: (m,) of 0 or 1, for the
    period from each sample on; motor_gain: (2,); delay_steps of actuation; q_kept, v_kept (5,): of the start, then of the end.
    (They are worked on in arrays of this thread's own: small ones of two threads may share a cache line.)
    Records q and v every `every` steps into (r, 5) arrays. Returns (records, largest LCP residual).
    """
    work, q, v = new_work(obj, palm, corners), q_kept.copy(), v_kept.copy()
    total = int(round(period * (angles.shape[0] - 1) / h)) + settle_steps
    pipe = np.zeros((delay_steps + 1, 2))
    torque, applied = np.empty(2), np.empty(2)
    worst, count = 0.0, 0
    for n in range(total):
        if n % every == 0 and count < record_q.shape[0]:
            record_q[count], record_v[count] = q, v
            count += 1
        s = n * h / period
        held = s >= angles.shape[0] - 1
        i = min(int(s), angles.shape[0] - 2)
        u = min(s - i, 1.0)
        side_v = (
            velocity_finger[min(i + 1, angles.shape[0] - 1)] if u > 0.999999 else velocity_finger[i]
        )
        for side in range(2):
            torque[side] = (1 - u) * efforts[i, side] + u * efforts[i + 1, side]
        p0, p1, d0, d1 = (
            angles[i, side_v],
            angles[i + 1, side_v],
            velocities[i, side_v],
            velocities[i + 1, side_v],
        )
        wanted = (
            p0 * ((1 + 2 * u) * (1 - u) ** 2)
            + p1 * (u * u * (3 - 2 * u))
            + period * d0 * (u * (1 - u) ** 2)
            + period * d1 * (u * u * (u - 1))
        )
        speed = 0.0 if held else (1 - u) * d0 + u * d1
        torque[side_v] += kp * (wanted - q[3 + side_v]) + kd * (speed - v[3 + side_v])
        slot = n % (delay_steps + 1)
        for side in range(2):
            pipe[slot, side] = min(max(torque[side], -torque_limits[side]), torque_limits[side])
        slot = (n + 1) % (delay_steps + 1)
        if n < delay_steps:
            slot = 0
        for side in range(2):
            applied[side] = motor_gain[side] * pipe[slot, side]
        _, residual = step(
            obj,
            palm,
            fingers,
            corners,
            inertias,
            load,
            finger_moment,
            friction,
            applied,
            h,
            q,
            v,
            work,
        )
        worst = max(worst, residual)
    if count < record_q.shape[0]:
        record_q[count], record_v[count] = q, v
        count += 1
    q_kept[:], v_kept[:] = q, v
    return count, worst


@kernel
def run_move(
    obj,
    palm,
    fingers,
    corners,
    inertias,
    load,
    finger_moment,
    torque_limits,
    side,
    turn,
    torque,
    efforts,
    ramp_steps,
    turn_steps,
    settle_steps,
    kp,
    kd,
    h,
    every,
    q_kept,
    v_kept,
    record_q,
    record_v,
    record_efforts,
    record_angle,
):
    """One finger turns by `turn` [rad] from rest to rest under stiff PD while the other holds `torque` [N m].

    efforts (2,): at the start, from which the torque finger's ramps to `torque`; q_kept, v_kept as for `run_trajectory`.
    Every `every` steps records q, v (r, 5), the efforts (r, 2) (the velocity finger's averaged) and its wanted angle (r,).
    Returns (records, largest LCP residual). Stops early when the object leaves the hand.
    """
    work, q, v = new_work(obj, palm, corners), q_kept.copy(), v_kept.copy()
    first = q[3 + side]
    before = efforts[1 - side]
    feed = efforts[side]
    applied = np.empty(2)
    total = ramp_steps + turn_steps + settle_steps
    mean, count, worst = 0.0, 0, 0.0
    for n in range(total):
        u = min(max((n - ramp_steps) / max(turn_steps, 1), 0.0), 1.0)
        wanted = first + turn * u**3 * (10.0 - 15.0 * u + 6.0 * u * u)
        speed = 30.0 * turn * (u * (1.0 - u)) ** 2 / (turn_steps * h) if turn_steps > 0 else 0.0
        applied[1 - side] = before + (torque - before) * min(1.0, (n + 1) / max(ramp_steps, 1))
        applied[side] = feed + kp * (wanted - q[3 + side]) + kd * (speed - v[3 + side])
        for i in range(2):
            applied[i] = min(max(applied[i], -torque_limits[i]), torque_limits[i])
        mean += applied[side]
        _, residual = step(
            obj, palm, fingers, corners, inertias, load, finger_moment, 0.0, applied, h, q, v, work
        )
        worst = max(worst, residual)
        if (n + 1) % every == 0:
            record_q[count], record_v[count] = q, v
            record_efforts[count, side], record_efforts[count, 1 - side] = (
                mean / every,
                applied[1 - side],
            )
            record_angle[count] = wanted
            mean = 0.0
            count += 1
        if left_the_hand(palm, fingers, q):
            break
    q_kept[:], v_kept[:] = q, v
    return count, worst
