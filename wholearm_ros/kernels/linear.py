"""Tiny dense linear algebra without allocation."""

import numpy as np

from wholearm_ros.kernels import allocating, kernel
from wholearm_ros.model.configuration import SIZE


@kernel
def solve_in_place(a, b):
    """Gaussian elimination with row pivoting: b ← a⁻¹ b, a is destroyed. b: (n, m). Returns the
    smallest over the largest pivot.
    """
    return solve_leading(a, b, b.shape[0])


@kernel
def solve_leading(a, b, n):
    """The same of the first n rows and columns of a, and rows of b, only."""
    m = b.shape[1]
    smallest, largest = np.inf, 0.0
    for k in range(n):
        p = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[p, k]):
                p = i
        pivot = abs(a[p, k])
        smallest, largest = min(smallest, pivot), max(largest, pivot)
        if pivot < 1e-300:
            return 0.0
        if p != k:
            for j in range(n):
                a[k, j], a[p, j] = a[p, j], a[k, j]
            for j in range(m):
                b[k, j], b[p, j] = b[p, j], b[k, j]
        for i in range(k + 1, n):
            f = a[i, k] / a[k, k]
            if f != 0.0:
                for j in range(k + 1, n):
                    a[i, j] -= f * a[k, j]
                for j in range(m):
                    b[i, j] -= f * b[k, j]
    for k in range(n - 1, -1, -1):
        for j in range(m):
            v = b[k, j]
            for i in range(k + 1, n):
                v -= a[k, i] * b[i, j]
            b[k, j] = v / a[k, k]
    return smallest / largest


@allocating
def null_vector(rows, scale, t):
    """Fill t (5,) with the unit vector (in coordinates q / scale) that spans the kernel of rows
    (4, 5).

    By cofactors: t_j = (−1)^j det(rows without column j). Returns the norm before scaling to one, 0
    when rank < 4.
    """
    minor = np.empty((4, 4))
    for j in range(SIZE):
        for i in range(4):
            c = 0
            for k in range(SIZE):
                if k != j:
                    minor[i, c] = rows[i, k] * scale[k]
                    c += 1
        t[j] = determinant4(minor) * (1.0 if j % 2 == 0 else -1.0)
    norm = np.sqrt((t * t).sum())
    if norm > 0.0:
        for j in range(SIZE):
            t[j] = t[j] / norm * scale[j]
    return norm


@kernel
def determinant4(a):
    """det of a 4 × 4 matrix by 2 × 2 minors."""
    s0 = a[0, 0] * a[1, 1] - a[1, 0] * a[0, 1]
    s1 = a[0, 0] * a[1, 2] - a[1, 0] * a[0, 2]
    s2 = a[0, 0] * a[1, 3] - a[1, 0] * a[0, 3]
    s3 = a[0, 1] * a[1, 2] - a[1, 1] * a[0, 2]
    s4 = a[0, 1] * a[1, 3] - a[1, 1] * a[0, 3]
    s5 = a[0, 2] * a[1, 3] - a[1, 2] * a[0, 3]
    c5 = a[2, 2] * a[3, 3] - a[3, 2] * a[2, 3]
    c4 = a[2, 1] * a[3, 3] - a[3, 1] * a[2, 3]
    c3 = a[2, 1] * a[3, 2] - a[3, 1] * a[2, 2]
    c2 = a[2, 0] * a[3, 3] - a[3, 0] * a[2, 3]
    c1 = a[2, 0] * a[3, 2] - a[3, 0] * a[2, 2]
    c0 = a[2, 0] * a[3, 1] - a[3, 0] * a[2, 1]
    return s0 * c5 - s1 * c4 + s2 * c3 + s3 * c2 - s4 * c1 + s5 * c0
