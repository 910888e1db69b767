"""Linear complementarity problems 0 ≤ z ⟂ R Rᵀ z + b ≥ 0.

Such a problem is a projection: x = Rᵀ z is the shortest of all vectors for which R x + b ≥ 0. It is
solved by the dual active-set method of Goldfarb and Idnani (1983) for strictly convex quadratic
programmes, which needs no care of dependent rows: an object that lies on an edge between two
fingers, stuck by friction everywhere, has many more rows than coordinates. The rows of the active
set are kept orthogonalised (Gram–Schmidt), R_active = L U with L unit lower triangular.
"""

from typing import NamedTuple

import numpy as np

from wholearm_ros.kernels import allocating, inlined, kernel
from wholearm_ros.model.configuration import SIZE

DEPENDENT = 1e-10  # of a row's own square: less is left of a row that depends on the active ones
CLEAN = 1e-6  # of a row's own square: where less is left of it, it is orthogonalised again
TOLERANCE = 1e-12  # of a violated row, relative to the largest |b|, absolute below 1
MOST_ROUNDS = 100


class Lcp(NamedTuple):
    """A problem, its solution, and the active set: for up to n rows, of which the first k are
    used.

    rows: (n, 5) = R; b, z: (n,); guess: (n,) bool, the active set from which to begin; x: (5,) = Rᵀ
    z. lost: (n,) bool, rows that no z satisfies. Of the active set: members: (6,) rows; basis: (6,
    5) = U and triangle: (6, 6) = L, in their order; squares: (6,) of the rows of U; weights: (6,),
    a right-hand side and its solution.
    """

    rows: np.ndarray
    b: np.ndarray
    z: np.ndarray
    guess: np.ndarray
    x: np.ndarray
    lost: np.ndarray
    members: np.ndarray
    basis: np.ndarray
    triangle: np.ndarray
    squares: np.ndarray
    weights: np.ndarray


@allocating
def new_lcp(n):
    """Room for a problem of up to n rows; nothing is guessed."""
    return Lcp(
        np.zeros((n, SIZE)),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n, np.bool_),
        np.zeros(SIZE),
        np.zeros(n, np.bool_),
        np.zeros(SIZE + 1, np.int64),
        np.zeros((SIZE + 1, SIZE)),
        np.zeros((SIZE + 1, SIZE + 1)),
        np.zeros(SIZE + 1),
        np.zeros(SIZE + 1),
    )


@kernel
def solve_lcp(lcp, k):
    """Fill z (k,) and x (5,) from the first k rows, b and guess.

    Where no z does (the rows ask for what cannot be) the row in question stays violated.
    Returns the residual max |min(z, R x + b)|.
    """
    z, lost, tolerance = lcp.z, lcp.lost, TOLERANCE
    for i in range(k):
        z[i], lost[i] = 0.0, False
        tolerance = max(tolerance, TOLERANCE * abs(lcp.b[i]))
    m, residual = _begin(lcp, k), np.inf
    for _ in range(MOST_ROUNDS):
        p, worst, residual = _most_violated(lcp, k)
        if worst >= -tolerance:
            break
        m, satisfied = _raise(lcp, p, -worst, m)
        lost[p] = not satisfied
    return residual


@inlined
def _most_violated(lcp, k):
    """(the row, of those not lost, of which w = R x + b is least, its w, max |min(z, w)| over
    all).
    """
    rows, b, z, x, lost = lcp.rows, lcp.b, lcp.z, lcp.x, lcp.lost
    p, least, residual = -1, np.inf, 0.0
    for i in range(k):
        w = b[i]
        for c in range(SIZE):
            w += rows[i, c] * x[c]
        residual = max(residual, abs(min(z[i], w)))
        if w < least and not lost[i]:
            p, least = i, w
    return p, least, residual


@inlined
def _begin(lcp, k):
    """x, z of the guessed active set, without what depends on the rest of it or would have to
    pull. Returns its size.
    """
    m, weights = 0, lcp.weights
    for i in range(k):
        if lcp.guess[i] and m < SIZE:
            m += _append(lcp, i, m)
    while True:
        _solve_active(lcp, m)
        least = 0
        for a in range(m):
            if weights[a] < weights[least]:
                least = a
        if m == 0 or weights[least] >= 0.0:
            break
        m = _without(lcp, m, least)
    for a in range(m):
        lcp.z[lcp.members[a]] = weights[a]
    return m


@inlined
def _solve_active(lcp, m):
    """Leave in x, and in `weights` z of the active set, what R x + b = 0 asks for there: L D Lᵀ z
    = −b, D being the squares.
    """
    triangle, weights, x = lcp.triangle, lcp.weights, lcp.x
    for c in range(SIZE):
        x[c] = 0.0
    for a in range(m):
        v = -lcp.b[lcp.members[a]]
        for j in range(a):
            v -= triangle[a, j] * weights[j]
        weights[a] = v
    for a in range(m):
        weights[a] /= lcp.squares[a]
        for c in range(SIZE):
            x[c] += weights[a] * lcp.basis[a, c]
    _back_substitute(triangle, weights, m)


@inlined
def _back_substitute(triangle, weights, m):
    """weights ← L⁻ᵀ weights."""
    for a in range(m - 1, -1, -1):
        v = weights[a]
        for j in range(a + 1, m):
            v -= triangle[j, a] * weights[j]
        weights[a] = v


@inlined
def _append(lcp, p, m):
    """Make row p the last one of an active set of m. Whether it does not depend on the others."""
    rows, own = lcp.rows, 0.0
    left = _orthogonalise(lcp, p, m)
    for c in range(SIZE):
        own += rows[p, c] * rows[p, c]
    lcp.members[m], lcp.squares[m] = p, left
    return left > DEPENDENT * own


@kernel
def _orthogonalise(lcp, p, m):
    """Row p less its part along the first m of the basis, as row m of `basis`; that part's
    coordinates as row m of `triangle`. Returns the square of what is left.
    """
    basis, triangle, squares, own, left = lcp.basis, lcp.triangle, lcp.squares, 0.0, 0.0
    for c in range(SIZE):
        basis[m, c] = lcp.rows[p, c]
        own += basis[m, c] * basis[m, c]
    for j in range(m):
        triangle[m, j] = 0.0
    for _ in range(2):
        for j in range(m):
            part = 0.0
            for c in range(SIZE):
                part += basis[j, c] * basis[m, c]
            part /= squares[j]
            triangle[m, j] += part
            for c in range(SIZE):
                basis[m, c] -= part * basis[j, c]
        left = 0.0
        for c in range(SIZE):
            left += basis[m, c] * basis[m, c]
        if left > CLEAN * own:
            break
    return left


@kernel
def _raise(lcp, p, missing, m):
    """Raise z_p until row p, of which w is −missing, is satisfied, the m active rows being kept at
    w = 0; of those, one that would have to pull leaves. Returns (size of the active set,
    whether row p is satisfied).
    """
    z, x, members, weights, direction = lcp.z, lcp.x, lcp.members, lcp.weights, lcp.basis
    while True:
        independent = _append(lcp, p, m)
        gain = lcp.squares[m]
        for a in range(m):
            weights[a] = lcp.triangle[m, a]
        _back_substitute(lcp.triangle, weights, m)
        whole = missing / gain if m < SIZE and independent else np.inf
        leaving, part = -1, np.inf
        for a in range(m):
            if weights[a] > 0.0 and z[members[a]] < part * weights[a]:
                leaving, part = a, z[members[a]] / weights[a]
        step = min(whole, part)
        if step == np.inf:
            return m, False
        for a in range(m):
            z[members[a]] -= step * weights[a]
        z[p] += step
        for c in range(SIZE):
            x[c] += step * direction[m, c]
        if whole <= part:
            return m + 1, True
        missing -= step * gain
        z[members[leaving]] = 0.0
        m = _without(lcp, m, leaving)


@kernel
def _without(lcp, m, place):
    """Take the member at a place out of an active set of m. Returns the size of what remains."""
    members = lcp.members
    for a in range(place, m - 1):
        _append(lcp, members[a + 1], a)
    return m - 1


@kernel
def lcp_residual(lcp, k):
    """max |min(z, R Rᵀ z + b)| of the first k rows, for any z; x becomes Rᵀ z."""
    lcp.x[:] = 0.0
    for i in range(k):
        lcp.lost[i] = False
        for c in range(SIZE):
            lcp.x[c] += lcp.rows[i, c] * lcp.z[i]
    return _most_violated(lcp, k)[2]
