"""Time stepping of object and fingers under motor torques: one linear complementarity problem a step, impacts included.

    M (v⁺ − v) = h F + Rᵀ λ,   0 ≤ λ ⟂ R v⁺ + gap / h + μ |T v| ≥ 0          (Anitescu 2006, after Stewart–Trinkle)

with M constant in q = (x, y, φ, θ_L, θ_R) and, for every pair that could close in the step, two rows R = N ± μ T: the edges of
its friction cone, N = ∂gap/∂q and T the sliding row; without friction they are one row N. A joint near an end stop is a pair,
too. Eliminating v⁺ leaves a symmetric, positive semidefinite problem: v⁺ is the projection of the free velocity, in the mass
metric, on a convex set that holds v = 0 (unless something penetrates), so a step never adds kinetic energy. An object that friction can hold
does not creep. The term μ |T v| takes back the dilation μ |T v⁺| of the convex cone: what slides stays in contact, up to the
change of its sliding speed in one step.
"""

from typing import NamedTuple

import numpy as np

from wholearm_ros.kernels import inlined, kernel
from wholearm_ros.kernels.geometry import (
    contact_in,
    fill_row,
    frame_of,
    gap_table,
    pair_body,
    table_entry,
    table_size,
)
from wholearm_ros.kernels.lcp import solve_lcp
from wholearm_ros.kernels.world import joint
from wholearm_ros.model.configuration import ROTATION, SIZE, X, Y

NEAR = 0.002  # [m] pairs nearer than this (plus what they may travel in a step) enter the LCP
NEAR_STOP = 0.05  # [rad] a joint nearer than this to its end stop enters the LCP
WATCH = 0.006  # [m] of motion for which the list of pairs that may come near is good
DEEPEST = 0.005  # [m] a deeper penetration is no contact: the feature is beyond the object
PUSHED_OUT = 0.25  # of a penetration, in one step
STOPS = 4  # end stops of both joints: low and high of the left one, low and high of the right one


class Workspace(NamedTuple):
    """What `step` keeps from one step to the next, for one world; of no use with another configuration's steps.

    gaps, codes: (n,) of the gap table's entries; active: (2 n + 4,) rows that pushed in the last step: two of every entry,
    then the end stops; watched: (n,) entries that could close before the object or a finger has moved by ledger[0] [m],
    ledger[1] of them, ledger[2] the longest lever; the rest is room for the problem: place: row → index in `active`.
    """

    gaps: np.ndarray
    codes: np.ndarray
    active: np.ndarray
    watched: np.ndarray
    ledger: np.ndarray
    place: np.ndarray
    rows: np.ndarray
    pushes: np.ndarray
    b: np.ndarray
    z: np.ndarray
    guess: np.ndarray
    vectors: np.ndarray


@kernel
def new_workspace(world):
    n = table_size(world.obj, world.palm, world.corners)
    m = 2 * n + STOPS
    return Workspace(
        np.empty(n),
        np.empty(n, np.int64),
        np.zeros(m, np.bool_),
        np.empty(n, np.int64),
        np.zeros(3),
        np.empty(m, np.int64),
        np.empty((m, SIZE)),
        np.empty((m, SIZE)),
        np.empty(m),
        np.empty(m),
        np.zeros(m, np.bool_),
        np.empty((3, SIZE)),
    )


@kernel
def step(world, friction, efforts, h, q, v, work):
    """One step of h [s] from q, v (5,), both updated in place, under motor torques efforts (2,) [N m].

    work: see `Workspace`. Returns (rows that push, LCP residual [m/s]).
    """
    frame = frame_of(q)
    near = NEAR + 2.0 * h
    _update_gaps(world, q, frame, near, work)
    free, ahead = work.vectors[0], work.vectors[1]
    _free_velocity(world, efforts, h, v, frame, free)
    for j in range(SIZE):
        ahead[j] = q[j] + h * v[j]
    k = _contact_rows(world, friction, h, near, q, v, ahead, frame, work)
    k = _stop_rows(world, h, q, k, work)
    rows, pushes, b, guess = work.rows, work.pushes, work.b, work.guess
    inertias, active, place = world.inertias, work.active, work.place
    for i in range(k):
        for j in range(SIZE):
            pushes[i, j] = rows[i, j] / inertias[j]
            b[i] += rows[i, j] * free[j]
        guess[i] = active[place[i]]
    residual = solve_lcp(rows, pushes, b, guess, work.z, k)
    pushing = _integrate(world, k, h, q, v, work)
    return pushing, residual


@inlined
def _free_velocity(world, efforts, h, v, frame, free):
    """v + h M⁻¹ F: what would be without contacts."""
    load, inertias = world.load, world.inertias
    free[X] = v[X] - h * load[X] / inertias[X]
    free[Y] = v[Y] - h * load[Y] / inertias[Y]
    free[ROTATION] = v[ROTATION] - h * load[ROTATION] / inertias[ROTATION]
    for side in range(2):
        j = joint(side)
        held = world.finger_moment[side] * frame[2 + 2 * side]
        free[j] = v[j] + h * (efforts[side] - held) / inertias[j]


@inlined
def _contact_rows(world, friction, h, near, q, v, ahead, frame, work):
    """The rows of all pairs nearer than `near` [m], and of b the gap and the dilation. Returns how many."""
    obj, palm, fingers, corners = world.obj, world.palm, world.fingers, world.corners
    gaps, codes, active, watched = work.gaps, work.codes, work.active, work.watched
    rows, b, place, slide = work.rows, work.b, work.place, work.vectors[2]
    frame_ahead, k = frame_of(ahead), 0
    for i in range(int(work.ledger[1])):
        e = watched[i]
        if not -DEEPEST < gaps[e] < near:
            active[2 * e] = active[2 * e + 1] = False
            continue
        # A feature is outside a convex body when it is outside one of its edges. Which one, is asked of where it will be: a
        # vertex that slides off a finger's tip is held by what comes after the tip, not by the edge that it leaves.
        code = table_entry(obj, palm, fingers, corners, e, ahead, frame_ahead)[1]
        codes[e] = code
        px, py, nx, ny, gap, _, _ = contact_in(obj, palm, fingers, code, q, frame)
        body = pair_body(code)
        fill_row(rows[k], px, py, nx, ny, body, fingers, q)
        b[k] = max(gap, 0.0) / h if gaps[e] > 0.0 else PUSHED_OUT * gaps[e] / h
        place[k] = 2 * e
        k += 1
        if friction > 0.0:
            fill_row(slide, px, py, -ny, nx, body, fingers, q)
            place[k] = 2 * e + 1
            b[k] = b[k - 1]
            _open_cone(rows, b, k, friction, slide, v)
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
def _stop_rows(world, h, q, k, work):
    """The end stops of both joints, unilateral constraints like any other, after the first k rows. Returns how many in all."""
    limits, active, rows = world.limits, work.active, work.rows
    first = active.shape[0] - STOPS
    for s in range(STOPS):
        j, sign = joint(s // 2), 1.0 - 2.0 * (s % 2)
        gap = sign * (q[j] - limits[s // 2, s % 2])
        if gap > NEAR_STOP:
            active[first + s] = False
            continue
        for c in range(SIZE):
            rows[k, c] = sign if c == j else 0.0
        work.b[k] = gap / h if gap > 0.0 else PUSHED_OUT * gap / h
        work.place[k] = first + s
        k += 1
    return k


@inlined
def _integrate(world, k, h, q, v, work):
    """v⁺ and q⁺ = q + h v⁺, in place. Returns how many of the k rows push."""
    free, z, pushes, active, place = work.vectors[0], work.z, work.pushes, work.active, work.place
    pushing = 0
    for i in range(k):
        active[place[i]] = z[i] > 0.0
        if z[i] > 0.0:
            pushing += 1
            for j in range(SIZE):
                free[j] += pushes[i, j] * z[i]
    for j in range(SIZE):
        v[j] = free[j]
        q[j] += h * free[j]
    ledger, turning = work.ledger, max(abs(v[joint(0)]), abs(v[joint(1)]))
    ledger[0] -= h * (np.hypot(v[X], v[Y]) + ledger[2] * (abs(v[ROTATION]) + turning))
    return pushing


@inlined
def _update_gaps(world, q, frame, near, work):
    """Gaps of the watched entries at q; of all of them, and which to watch, when enough has moved since that was done."""
    obj, palm, fingers, corners = world.obj, world.palm, world.fingers, world.corners
    gaps, codes, watched, ledger = work.gaps, work.codes, work.watched, work.ledger
    if ledger[0] > 0.0:
        for k in range(int(ledger[1])):
            e = watched[k]
            gaps[e], codes[e] = table_entry(obj, palm, fingers, corners, e, q, frame)
        return
    count, active = 0, work.active
    gap_table(obj, palm, fingers, corners, q, gaps, codes)
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
        reach = max(reach, away + max(size, fingers[side, 2] + fingers[side, 3]))
    for k in range(palm.shape[0]):
        reach = max(reach, np.hypot(q[X] - palm[k, 0], q[Y] - palm[k, 1]))
    return reach


@kernel
def stops_bearing(work):
    """(2, 2) bool view: whether each joint (left, right) pressed on its (low, high) end stop in the last step."""
    return work.active[work.active.shape[0] - STOPS :].reshape((2, 2))
