"""Whether an outline is that of a convex polygon: turns and crossings, for checking input."""

import numpy as np


def turns(vertices: np.ndarray) -> np.ndarray:
    """(n,) sine of the turn at each vertex (n, 2), positive to the left; 0 where an edge has no
    length.
    """
    after = np.roll(vertices, -1, axis=0) - vertices
    before = np.roll(after, 1, axis=0)
    lengths = np.linalg.norm(after, axis=1)
    scale = lengths * np.roll(lengths, 1)
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    sines: np.ndarray = np.divide(cross, scale, out=np.zeros(len(vertices)), where=scale > 0.0)
    return sines


def crossing_edges(vertices: np.ndarray) -> tuple[int, int] | None:
    """The first two edges (i, j), not neighbours, that meet; None when the outline is simple."""
    n = len(vertices)
    for i in range(n):
        for j in range(i + 2, n):
            if (j + 1) % n != i and _meet(
                vertices[i], vertices[(i + 1) % n], vertices[j], vertices[(j + 1) % n]
            ):
                return i, j
    return None


def _side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> float:
    return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))


def _meet(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> bool:
    """Whether the segments ab and cd have a point in common."""
    s1, s2, s3, s4 = _side(a, b, c), _side(a, b, d), _side(c, d, a), _side(c, d, b)
    if s1 * s2 < 0.0 and s3 * s4 < 0.0:
        return True
    on = ((s1, a, b, c), (s2, a, b, d), (s3, c, d, a), (s4, c, d, b))
    return any(
        s == 0.0
        and min(p[0], q[0]) <= r[0] <= max(p[0], q[0])
        and min(p[1], q[1]) <= r[1] <= max(p[1], q[1])
        for s, p, q, r in on
    )
