"""Plain tests on polygons, for checking input: turns, crossings, separation.

The kernels have a geometry of their own.
"""

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


def signed_area(vertices: np.ndarray) -> float:
    """[m²], positive when counter-clockwise."""
    w = np.roll(vertices, -1, axis=0)
    return 0.5 * float((vertices[:, 0] * w[:, 1] - vertices[:, 1] * w[:, 0]).sum())


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


def separation(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Separation [m] of convex, counter-clockwise polygons (..., n, 2) and (..., m, 2), by the
    separating axis theorem: where they are apart, positive and at most their distance; where they
    overlap, minus the depth of penetration.
    """
    apart: np.ndarray = np.maximum(_apart(a, b), _apart(b, a))
    return apart


def rectangle(axis: np.ndarray, angle: np.ndarray, length: float, half_width: float) -> np.ndarray:
    """(..., 4, 2) [m] counter-clockwise: from `axis` along `angle` (...) [rad]."""
    along = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    across = half_width * np.stack([-along[..., 1], along[..., 0]], axis=-1)
    tip = axis + length * along
    return np.stack([axis - across, tip - across, tip + across, axis + across], axis=-2)


def turned(vertices: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """(n, 2) [m]: vertices about the centroid, at `pose` (3,) x, y, rotation."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    placed: np.ndarray = vertices @ np.array([[c, s], [-s, c]]) + pose[:2]
    return placed


def _apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Largest distance of b from a line through an edge of a, outwards."""
    edges = np.roll(a, -1, axis=-2) - a
    outward = (
        np.stack([edges[..., 1], -edges[..., 0]], axis=-1)
        / np.linalg.norm(edges, axis=-1)[..., None]
    )
    heights = outward @ np.swapaxes(b, -1, -2) - (outward * a).sum(axis=-1)[..., None]
    apart: np.ndarray = heights.min(axis=-1).max(axis=-1)
    return apart


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
