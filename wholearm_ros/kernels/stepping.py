"""Time stepping of object and fingers under motor torques: one linear complementarity problem a step, impacts included.

M (v⁺ − v) = h F + (N − μ S T)ᵀ λ,   0 ≤ λ ⟂ N v⁺ + gap / h ≥ 0        (Stewart–Trinkle, Anitescu–Potra)
with M constant in q = (x, y, φ, θ_L, θ_R), N the rows ∂gap/∂q of every pair that could close in the step, T the sliding rows
and S the regularised signs of sliding. Without friction the matrix N M⁻¹ Nᵀ is symmetric and the step dissipates.
"""
import numpy as np
from quantecon.optimize.lcp_lemke import lcp_lemke

from . import kernel
from .geometry import contact, fill_row, gap_table, pair_body, table_size

NEAR = 0.002           # [m] pairs nearer than this (plus what they may travel in a step) enter the LCP
SLIP_SPEED = 1e-3      # [m/s] sliding slower than this has less than full friction
STICKS_OUT = -0.25     # of a penetration, corrected in one step


@kernel
def solve_lcp(a, b, guess, z):
    """z ≥ 0 ⟂ a z + b ≥ 0, z (k,). First the active set `guess` (k,) bool (kept from the last step), then Lemke.

    Returns the residual max |min(z, a z + b)|.
    """
    k = b.shape[0]
    active = np.flatnonzero(guess[:k])
    m = active.shape[0]
    if m < 7:
        z[:k] = 0.0
        if m > 0:
            sub, rhs = np.empty((m, m)), np.empty(m)
            for i in range(m):
                rhs[i] = -b[active[i]]
                for j in range(m):
                    sub[i, j] = a[active[i], active[j]]
            good = _solve_small(sub, rhs)
        else:
            good, rhs = True, np.empty(0)
        if good:
            for i in range(m):
                z[active[i]] = rhs[i]
            if lcp_residual(a, b, z) < 1e-11:
                return lcp_residual(a, b, z)
    answer = lcp_lemke(a, b)
    z[:k] = answer.z
    return lcp_residual(a, b, z)


@kernel
def lcp_residual(a, b, z):
    """max_i |min(z_i, (a z + b)_i)|."""
    worst = 0.0
    for i in range(b.shape[0]):
        w = b[i]
        for j in range(b.shape[0]):
            w += a[i, j] * z[j]
        worst = max(worst, abs(min(z[i], w)))
    return worst


@kernel
def _solve_small(a, b):
    """Gaussian elimination in place, b (m,) receives the solution; False when nearly singular."""
    n = b.shape[0]
    for k in range(n):
        p = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[p, k]):
                p = i
        if abs(a[p, k]) < 1e-10:
            return False
        if p != k:
            for j in range(k, n):
                a[k, j], a[p, j] = a[p, j], a[k, j]
            b[k], b[p] = b[p], b[k]
        for i in range(k + 1, n):
            f = a[i, k] / a[k, k]
            for j in range(k + 1, n):
                a[i, j] -= f * a[k, j]
            b[i] -= f * b[k]
    for k in range(n - 1, -1, -1):
        v = b[k]
        for j in range(k + 1, n):
            v -= a[k, j] * b[j]
        b[k] = v / a[k, k]
    return True


@kernel
def step(obj, palm, fingers, corners, inertias, load, finger_moment, friction, efforts, h, q, v, work):
    """One step of h [s] from q, v (5,), both updated in place, under motor torques efforts (2,) [N m].

    work: (gaps, codes, active) of the table's size, kept between steps. Returns (closed pairs, LCP residual [m/s]).
    """
    gaps, codes, active = work
    gap_table(obj, palm, fingers, corners, q, gaps, codes)
    free = np.empty(5)
    free[0] = v[0] - h * load[0] / inertias[0]
    free[1] = v[1] - h * load[1] / inertias[1]
    free[2] = v[2] - h * load[2] / inertias[2]
    for i in range(2):
        free[3 + i] = v[3 + i] + h * (efforts[i] - finger_moment[i] * np.cos(q[3 + i])) / inertias[3 + i]
    near = np.empty(gaps.shape[0], np.int64)
    k = 0
    for e in range(gaps.shape[0]):
        if gaps[e] < NEAR + 2.0 * h and gaps[e] > -0.005:
            near[k] = e
            k += 1
    if k == 0:
        v[:] = free
        q += h * v
        active[:] = False
        return 0, 0.0
    rows, pushes, b = np.empty((k, 5)), np.empty((k, 5)), np.empty(k)
    slide = np.empty(5)
    guess, z = np.zeros(k, np.bool_), np.zeros(k)
    for i in range(k):
        e = near[i]
        px, py, nx, ny, gap, _, _ = contact(obj, palm, fingers, codes[e], q)
        body = pair_body(codes[e])
        fill_row(rows[i], px, py, nx, ny, body, fingers, q)
        gap = gaps[e] / h if gaps[e] > 0.0 else -STICKS_OUT * gaps[e] / h
        b[i] = gap
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
    a = np.empty((k, k))
    for i in range(k):
        for j in range(k):
            s = 0.0
            for c in range(5):
                s += rows[i, c] * pushes[j, c]
            a[i, j] = s
    residual = solve_lcp(a, b, guess, z)
    active[:] = False
    closed = 0
    for i in range(k):
        if z[i] > 0.0:
            active[near[i]] = True
            closed += 1
            for j in range(5):
                free[j] += pushes[i, j] * z[i]
    v[:] = free
    q += h * v
    return closed, residual


@kernel
def run_trajectory(obj, palm, fingers, corners, inertias, load, finger_moment, torque_limits, friction, motor_gain,
                   delay_steps, kp, kd, h, period, angles, velocities, efforts, velocity_finger, settle_steps,
                   q, v, every, record_q, record_v):
    """The closed loop: PD on the velocity-controlled finger, open-loop torque on the other, for the whole trajectory.

    angles, velocities, efforts: (m, 2) every `period` [s]; velocity_finger: (m,) of 0 or 1, for the
    period from each sample on; motor_gain: (2,); delay_steps of actuation.
    Records q and v every `every` steps into (r, 5) arrays. Returns (records, largest LCP residual).
    """
    size = table_size(obj, palm, corners)
    gaps, codes, active = np.empty(size), np.empty(size, np.int64), np.zeros(size, np.bool_)
    work = (gaps, codes, active)
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
        side_v = velocity_finger[min(i + 1, angles.shape[0] - 1)] if u > 0.999999 else velocity_finger[i]
        for side in range(2):
            torque[side] = (1 - u) * efforts[i, side] + u * efforts[i + 1, side]
        p0, p1, d0, d1 = angles[i, side_v], angles[i + 1, side_v], velocities[i, side_v], velocities[i + 1, side_v]
        wanted = (p0 * ((1 + 2 * u) * (1 - u) ** 2) + p1 * (u * u * (3 - 2 * u))
                  + period * d0 * (u * (1 - u) ** 2) + period * d1 * (u * u * (u - 1)))
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
        _, residual = step(obj, palm, fingers, corners, inertias, load, finger_moment, friction, applied, h, q, v, work)
        worst = max(worst, residual)
    if count < record_q.shape[0]:
        record_q[count], record_v[count] = q, v
        count += 1
    return count, worst


@kernel
def run_move(obj, palm, fingers, corners, inertias, load, finger_moment, torque_limits, side, turn, torque, efforts,
             ramp_steps, turn_steps, settle_steps, kp, kd, h, every, q, v, record_q, record_v, record_efforts, record_angle):
    """One finger turns by `turn` [rad] from rest to rest under stiff PD while the other holds `torque` [N m].

    efforts (2,): at the start, from which the torque finger's ramps to `torque`; q, v (5,) are updated in place.
    Every `every` steps records q, v (r, 5), the efforts (r, 2) (the velocity finger's averaged) and its wanted angle (r,).
    Returns (records, largest LCP residual). Stops early when the object leaves the hand.
    """
    size = table_size(obj, palm, corners)
    gaps, codes, active = np.empty(size), np.empty(size, np.int64), np.zeros(size, np.bool_)
    work = (gaps, codes, active)
    first = q[3 + side]
    before = efforts[1 - side]
    feed = efforts[side]
    applied = np.empty(2)
    total = ramp_steps + turn_steps + settle_steps
    mean, count, worst = 0.0, 0, 0.0
    for n in range(total):
        u = min(max((n - ramp_steps) / max(turn_steps, 1), 0.0), 1.0)
        wanted = first + turn * u ** 3 * (10.0 - 15.0 * u + 6.0 * u * u)
        speed = 30.0 * turn * (u * (1.0 - u)) ** 2 / (turn_steps * h) if turn_steps > 0 else 0.0
        applied[1 - side] = before + (torque - before) * min(1.0, (n + 1) / max(ramp_steps, 1))
        applied[side] = feed + kp * (wanted - q[3 + side]) + kd * (speed - v[3 + side])
        for i in range(2):
            applied[i] = min(max(applied[i], -torque_limits[i]), torque_limits[i])
        mean += applied[side]
        _, residual = step(obj, palm, fingers, corners, inertias, load, finger_moment, 0.0, applied, h, q, v, work)
        worst = max(worst, residual)
        if (n + 1) % every == 0:
            record_q[count], record_v[count] = q, v
            record_efforts[count, side], record_efforts[count, 1 - side] = mean / every, applied[1 - side]
            record_angle[count] = wanted
            mean = 0.0
            count += 1
        if abs(q[0]) > 0.2 or q[1] > 0.25 or q[1] < -0.02:
            break
    return count, worst
