"""Time stepping of object and fingers under motor torques: one linear complementarity problem a
step, impacts included.

    M (v⁺ − v) = h F + Rᵀ λ,   0 ≤ λ ⟂ R v⁺ + gap / h + μ |T v| ≥ 0

(Anitescu 2006, after Stewart–Trinkle)
with M constant in q = (x, y, φ, θ_L, θ_R) and, for every pair that could close in the step, two
rows R = N ± μ T: the edges of its friction cone, N = ∂gap/∂q and T the sliding row; without
friction they are one row N. A joint near an end stop is a pair, too. Eliminating v⁺ leaves a
symmetric, positive semidefinite problem: v⁺ is the projection of the free velocity, in the mass
metric, on a convex set that holds v = 0 (unless something penetrates), so a step never adds kinetic
energy. An object that friction can hold does not creep. The term μ |T v| takes back the dilation μ
|T v⁺| of the convex cone: what slides stays in contact, up to the change of its sliding speed in
one step. Coulomb friction of a joint acts on its free velocity: as much of it as would hold the
joint against the contact forces of the step before.
"""

from typing import NamedTuple

import numpy as np

from wholearm_ros.kernels import allocating, inlined, kernel
from wholearm_ros.kernels.geometry import (
    contact_at,
    fill_row,
    frame_of_finger,
    frames_of,
    gap_table,
    pair_body,
    sliding,
    table_entry,
    table_size,
)
from wholearm_ros.kernels.lcp import Lcp, new_lcp, solve_lcp
from wholearm_ros.kernels.statics import bearing
from wholearm_ros.kernels.world import joint
from wholearm_ros.model.configuration import ROTATION, SIZE, X, Y

NEAR = 0.002  # [m] pairs nearer than this (plus what they may travel in a step) enter the LCP
NEAR_STOP = 0.05  # [rad] a joint nearer than this to its end stop enters the LCP
WATCH = 0.006  # [m] of motion for which the list of pairs that may come near is good
DEEPEST = 0.005  # [m] a deeper penetration is no contact: the feature is beyond the object
PUSHED_OUT = 0.25  # of a penetration, in one step
STOPS = 4  # end stops of both joints: low and high of the left one, low and high of the right one


class Workspace(NamedTuple):
    """What `step` keeps from one step to the next, of one motion of one world.

    friction: coefficient; h: [s] of a step; gaps, codes: (n,) of the gap table's entries; active:
    (2 n + 4,) rows that pushed in the last step: two of every entry, then the end stops; stops_met:
    (2, 2) bool, which joint (left, right) has pressed on its (low, high) end stop in any step;
    watched: (n,) entries that could close before the object or a finger has moved by ledger[0] [m],
    ledger[1] of them, ledger[2] the longest lever [m]. The rest is room for the problem: place: row
    → index in `active`; scale: (5,) M^−½, the mass metric's unit lengths, in which the rows of
    `lcp` are given; vectors: (3, 5).
    """

    friction: float
    h: float
    gaps: np.ndarray
    codes: np.ndarray
    active: np.ndarray
    stops_met: np.ndarray
    watched: np.ndarray
    ledger: np.ndarray
    place: np.ndarray
    scale: np.ndarray
    vectors: np.ndarray
    lcp: Lcp


@allocating
def new_workspace(world, friction, h):
    """For steps of h [s] with a coefficient of friction."""
    n = table_size(world)
    m = 2 * n + STOPS
    return Workspace(
        friction,
        h,
        np.empty(n),
        np.empty(n, np.int64),
        np.zeros(m, np.bool_),
        np.zeros((2, 2), np.bool_),
        np.empty(n, np.int64),
        np.zeros(3),
        np.empty(m, np.int64),
        1.0 / np.sqrt(world.inertias),
        np.empty((3, SIZE)),
        new_lcp(m),
    )


@kernel
def step(world, work, efforts, q, v):
    """One step from q, v (5,), both updated in place, under motor torques efforts (2,) [N m].

    Returns (rows that push, LCP residual [m/s]).
    """
    frames, free, ahead = frames_of(world, q), work.vectors[0], work.vectors[1]
    _update_gaps(world, q, frames, work)
    _free_velocity(world, work, efforts, v, frames, free)
    for j in range(SIZE):
        ahead[j] = q[j] + work.h * v[j]
    k = _contact_rows(world, work, v, frames, frames_of(world, ahead))
    k = _stop_rows(world, work, q, k)
    _pose_problem(work, free, k)
    residual = solve_lcp(work.lcp, k)
    return _integrate(work, free, k, q, v), residual


@inlined
def _free_velocity(world, work, efforts, v, frames, free):
    """v + h M⁻¹ F: what would be without contacts."""
    h, load, inertias = work.h, world.load, world.inertias
    free[X] = v[X] - h * load[X] / inertias[X]
    free[Y] = v[Y] - h * load[Y] / inertias[Y]
    free[ROTATION] = v[ROTATION] - h * load[ROTATION] / inertias[ROTATION]
    for side in range(2):
        j = joint(side)
        frame = frame_of_finger(frames, side)
        # Of a finger in the frame in which gravity pulls along -y, but for the cosine of its turn.
        cos = frame.cos + world.leaning * frame.sin
        sin = frame.sin - world.leaning * frame.cos
        held = bearing(world.finger_weights[side, 0], world.finger_weights[side, 1], cos, sin)
        free[j] = v[j] + h * (efforts[side] - held) / inertias[j]
        if world.joint_friction[side] > 0.0:
            # What would bring the joint to rest, had it the contact forces of the step before.
            most = h * world.joint_friction[side] / inertias[j]
            free[j] -= min(max(free[j] + work.scale[j] * work.lcp.x[j], -most), most)


@inlined
def _contact_rows(world, work, v, frames, ahead):
    """The rows of all pairs that are near, and of b the gap and the dilation. Returns how many.

    frames, ahead: now, and at the end of the step.
    """
    gaps, codes, active, watched = work.gaps, work.codes, work.active, work.watched
    rows, b, place, slide, h = work.lcp.rows, work.lcp.b, work.place, work.vectors[2], work.h
    near, k = NEAR + 2.0 * h, 0
    for i in range(int(work.ledger[1])):
        e = watched[i]
        if not -DEEPEST < gaps[e] < near:
            active[2 * e] = active[2 * e + 1] = False
            continue
        # A feature is outside a convex body when it is outside one of its edges. Which one, is
        # asked of where it will be: a vertex that slides off a finger's tip is held by what comes
        # after the tip, not by the edge that it leaves.
        code = table_entry(world, e, ahead)[1]
        codes[e] = code
        contact, body = contact_at(world, code, frames), pair_body(code)
        fill_row(contact, body, frames, rows[k])
        b[k] = max(contact.gap, 0.0) / h if gaps[e] > 0.0 else PUSHED_OUT * gaps[e] / h
        place[k] = 2 * e
        k += 1
        if work.friction > 0.0:
            fill_row(sliding(contact), body, frames, slide)
            place[k] = 2 * e + 1
            b[k] = b[k - 1]
            _open_cone(rows, b, k, work.friction, slide, v)
            k += 1
    return k


@inlined
def _open_cone(rows, b, k, friction, slide, v):
    """Of the row k − 1 = N make the two rows N ± μ T of the friction cone's edges."""
    speed = 0.0
    for j in range(SIZE):
        speed += slide[j] * v[j]
        rows[k, j] = rows[k - 1, j] - friction * slide[j]
        rows[k - 1, j] += friction * slide[j]
    b[k - 1] += friction * abs(speed)
    b[k] += friction * abs(speed)


@inlined
def _stop_rows(world, work, q, k):
    """The end stops of both joints, unilateral constraints like any other, after the first k rows.
    Returns how many in all.
    """
    limits, active, rows, h = world.limits, work.active, work.lcp.rows, work.h
    first = active.shape[0] - STOPS
    for s in range(STOPS):
        j, sign = joint(s // 2), 1.0 - 2.0 * (s % 2)
        gap = sign * (q[j] - limits[s // 2, s % 2])
        if gap > NEAR_STOP:
            active[first + s] = False
            continue
        for c in range(SIZE):
            rows[k, c] = sign if c == j else 0.0
        work.lcp.b[k] = gap / h if gap > 0.0 else PUSHED_OUT * gap / h
        work.place[k] = first + s
        k += 1
    return k


@inlined
def _pose_problem(work, free, k):
    """R = rows M^−½, b = rows v_free + what is there of it; the guess is what pushed in the last
    step.
    """
    rows, b, scale = work.lcp.rows, work.lcp.b, work.scale
    for i in range(k):
        for j in range(SIZE):
            b[i] += rows[i, j] * free[j]
            rows[i, j] *= scale[j]
        work.lcp.guess[i] = work.active[work.place[i]]


@inlined
def _integrate(work, free, k, q, v):
    """v⁺ = v_free + M^−½ x and q⁺ = q + h v⁺, in place. Returns how many of the k rows push."""
    z, active, place, stops, h = work.lcp.z, work.active, work.place, work.stops_met, work.h
    first, pushing = active.shape[0] - STOPS, 0
    for i in range(k):
        active[place[i]] = z[i] > 0.0
        if z[i] > 0.0:
            pushing += 1
            if place[i] >= first:
                stops[(place[i] - first) // 2, (place[i] - first) % 2] = True
    for j in range(SIZE):
        v[j] = free[j] + work.scale[j] * work.lcp.x[j]
        q[j] += h * v[j]
    ledger, turning = work.ledger, max(abs(v[joint(0)]), abs(v[joint(1)]))
    ledger[0] -= h * (np.hypot(v[X], v[Y]) + ledger[2] * (abs(v[ROTATION]) + turning))
    return pushing


@inlined
def _update_gaps(world, q, frames, work):
    """Gaps of the watched entries at q; of all of them, and which to watch, when enough has moved
    since that was done.
    """
    gaps, codes, watched, ledger = work.gaps, work.codes, work.watched, work.ledger
    if ledger[0] > 0.0:
        for k in range(int(ledger[1])):
            e = watched[k]
            gaps[e], codes[e] = table_entry(world, e, frames)
        return
    count, active, near = 0, work.active, NEAR + 2.0 * work.h
    gap_table(world, q, gaps, codes)
    for e in range(gaps.shape[0]):
        if gaps[e] < near + WATCH or gaps[e] == np.inf:
            watched[count] = e
            count += 1
        else:
            active[2 * e] = active[2 * e + 1] = False
    ledger[0], ledger[1], ledger[2] = WATCH, count, _reach(world, q) + WATCH


@kernel
def _reach(world, q):
    """The longest lever [m] with which a rotation of the object or of a finger moves a contact."""
    obj, palm, fingers, size = world.obj, world.palm, world.fingers, 0.0
    for i in range(obj.shape[0]):
        size = max(size, np.hypot(obj[i, 0], obj[i, 1]))
    reach = size
    for side in range(2):
        away = np.hypot(q[X] - fingers[side, 0], q[Y] - fingers[side, 1])
        reach = max(reach, away + max(size, fingers[side, 3]))
    for k in range(palm.shape[0]):
        reach = max(reach, np.hypot(q[X] - palm[k, 0], q[Y] - palm[k, 1]))
    return reach
