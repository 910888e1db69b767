"""Linear complementarity problems 0 ≤ z ⟂ A z + b ≥ 0 with A = N P Nᵀ symmetric and positive semidefinite.

Such a problem is a projection: with w = A z + b = N v + c, the velocity v⁺ = v + P Nᵀ z is nearest to v (in the metric P⁻¹) of
all that satisfy N v⁺ + c ≥ 0. It is solved by the dual active-set method of Goldfarb and Idnani (1983) for strictly convex
quadratic programmes, which needs no care of dependent rows: an object that lies on an edge between two fingers, stuck by
friction everywhere, has many more rows than coordinates.
"""

import numpy as np

from wholearm_ros.kernels import inlined, kernel
from wholearm_ros.kernels.linear import solve_leading

SINGULAR = 1e-10  # smallest over largest pivot of an active set that is worth trying
DEPENDENT = 1e-10  # of a row's own square: less is left of a row that depends on the active ones
TOLERANCE = 1e-12  # of a violated row, relative to the largest |b|, absolute below 1
MOST_ROUNDS = 100


@kernel
def solve_lcp(rows, pushes, b, guess, z, k):
    """Fill z (k,) ≥ 0 ⟂ A z + b ≥ 0 with A = rows pushesᵀ (k, k), pushes = rows P.

    rows, pushes: (≥ k, d); b, z: (≥ k,); guess: (≥ k,) bool, the active set from which to begin (that of the last step).
    Where no z does (the rows ask for what cannot be) the row in question stays violated.
    Returns the residual max |min(z, A z + b)|.
    """
    d = rows.shape[1]
    active, change = np.empty(d + 1, np.int64), np.zeros(d)
    system, answer = np.empty((d, d)), np.empty((d, 1))
    for i in range(k):
        z[i] = 0.0
    m = _begin(rows, pushes, b, guess, z, k, active, system, answer)
    for a in range(m):
        for c in range(d):
            change[c] += pushes[active[a], c] * z[active[a]]
    lost, tolerance = np.zeros(k, np.bool_), TOLERANCE  # lost: rows that no z satisfies
    for i in range(k):
        tolerance = max(tolerance, TOLERANCE * abs(b[i]))
    residual = np.inf
    for _ in range(MOST_ROUNDS):
        p, worst, residual = _look(rows, b, change, z, lost)
        if worst >= -tolerance:
            break
        m, met = _raise(rows, pushes, p, -worst, z, active, m, system, answer, change)
        lost[p] = not met
    return residual


@inlined
def _look(rows, b, change, z, lost):
    """(the row, of those not lost, of which w = rows change + b is least, its w, max |min(z, w)| over all)."""
    p, least, residual = -1, np.inf, 0.0
    for i in range(lost.shape[0]):
        w = b[i]
        for c in range(rows.shape[1]):
            w += rows[i, c] * change[c]
        residual = max(residual, abs(min(z[i], w)))
        if w < least and not lost[i]:
            p, least = i, w
    return p, least, residual


@inlined
def _begin(rows, pushes, b, guess, z, k, active, system, answer):
    """Of the guessed active set what pushes: w = 0 and z ≥ 0 on it. Nothing, when it is singular. Returns its size."""
    m, d = 0, rows.shape[1]
    for i in range(k):
        if guess[i]:
            if m == d:
                return 0
            active[m] = i
            m += 1
    while m > 0:
        if not _solve(rows, pushes, active, m, system, answer, b, -1):
            return 0
        least = 0
        for a in range(m):
            if answer[a, 0] < answer[least, 0]:
                least = a
        if answer[least, 0] >= 0.0:
            break
        m = _without(active, m, least)
    for a in range(m):
        z[active[a]] = answer[a, 0]
    return m


@inlined
def _solve(rows, pushes, active, m, system, answer, b, p):
    """A_aa x = −b_a, or A_aa x = A_ap for p ≥ 0; x is left in `answer`. Whether it was regular."""
    for i in range(m):
        for j in range(m):
            system[i, j] = dot(rows, active[i], pushes, active[j])
        answer[i, 0] = -b[active[i]] if p < 0 else dot(rows, active[i], pushes, p)
    return solve_leading(system, answer, m) > SINGULAR


@kernel
def _raise(rows, pushes, p, missing, z, active, m, system, answer, change):
    """Raise z_p until row p, of which w is −missing, is satisfied, the active rows being kept at w = 0; of those, one that
    would have to pull leaves. Returns (size of the active set, whether row p is satisfied)."""
    d = rows.shape[1]
    direction = np.empty(d)
    while True:
        if m > 0:
            _solve(rows, pushes, active, m, system, answer, z, p)
        for c in range(d):
            direction[c] = pushes[p, c]
            for a in range(m):
                direction[c] -= answer[a, 0] * pushes[active[a], c]
        gain, own = 0.0, dot(rows, p, pushes, p)
        for c in range(d):
            gain += rows[p, c] * direction[c]
        whole = missing / gain if m < d and gain > DEPENDENT * own else np.inf
        leaving, part = -1, np.inf
        for a in range(m):
            if answer[a, 0] > 0.0 and z[active[a]] < part * answer[a, 0]:
                leaving, part = a, z[active[a]] / answer[a, 0]
        step = min(whole, part)
        if step == np.inf:
            return m, False
        for a in range(m):
            z[active[a]] -= step * answer[a, 0]
        z[p] += step
        for c in range(d):
            change[c] += step * direction[c]
        if whole <= part:
            active[m] = p
            return m + 1, True
        missing -= step * gain
        z[active[leaving]] = 0.0
        m = _without(active, m, leaving)


@inlined
def _without(active, m, place):
    for a in range(place, m - 1):
        active[a] = active[a + 1]
    return m - 1


@inlined
def dot(rows, i, pushes, j):
    """(rows pushesᵀ)_ij."""
    s = 0.0
    for c in range(rows.shape[1]):
        s += rows[i, c] * pushes[j, c]
    return s


@kernel
def lcp_residual(rows, pushes, b, z):
    """max_i |min(z_i, (rows pushesᵀ z + b)_i)|."""
    change = np.zeros(rows.shape[1])
    for i in range(b.shape[0]):
        if z[i] != 0.0:
            for c in range(rows.shape[1]):
                change[c] += pushes[i, c] * z[i]
    return _look(rows, b, change, z, np.zeros(b.shape[0], np.bool_))[2]
