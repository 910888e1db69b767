"""The union of convex polygons: its moments and its outline.

A polygon is (n, 2) [m], counter-clockwise.
"""

from collections.abc import Sequence

import numpy as np

from wholearm_ros.model.polygon import cross_with_next, edge_table

BESIDE = 1e-9  # [m] to either side of an edge it is asked what is there
SAME_END = 1e-7  # [m] ends of an outline's pieces that are nearer are one


def union_moments(parts: Sequence[np.ndarray]) -> np.ndarray:
    """(4,): area [m²], first moments [m³] and second polar moment [m⁴] about the origin of the
    union; what parts share is counted once, by inclusion and exclusion.
    """
    total = np.zeros(4)
    for k, part in enumerate(parts):
        total += _moments(part) - union_moments(_shared(part, parts[k + 1 :]))
    return total


def _shared(polygon: np.ndarray, others: Sequence[np.ndarray]) -> list[np.ndarray]:
    cut = (clipped(polygon, other) for other in others)
    return [shape for shape in cut if len(shape) > 2]


def _moments(v: np.ndarray) -> np.ndarray:
    w, cross = np.roll(v, -1, axis=0), cross_with_next(v)
    x, y = cross @ (v + w) / 6.0
    return np.array([cross.sum() / 2.0, x, y, cross @ (v * v + v * w + w * w).sum(axis=1) / 12.0])


def clipped(polygon: np.ndarray, other: np.ndarray) -> np.ndarray:
    """What of a polygon lies in another convex one, (k, 2); of no vertices where nothing does."""
    for x, y, nx, ny, _ in edge_table(other, closed=True):
        polygon = below(polygon, np.array([nx, ny]), nx * x + ny * y)
    return polygon


def below(polygon: np.ndarray, normal: np.ndarray, level: float) -> np.ndarray:
    """What of a polygon lies where normal · p ≤ level, (k, 2)."""
    heights, kept = polygon @ normal - level, []
    for k, height in enumerate(heights):
        after = (k + 1) % len(polygon)
        if height <= 0.0:
            kept.append(polygon[k])
        if height * heights[after] < 0.0:
            part = height / (height - heights[after])
            kept.append(polygon[k] + part * (polygon[after] - polygon[k]))
    return np.array(kept).reshape(-1, 2)


def union_outline(parts: Sequence[np.ndarray]) -> np.ndarray:
    """(n, 2) the outer boundary of parts that hang together, counter-clockwise. Of a hole that they
    enclose nothing is told.
    """
    if len(parts) == 1:
        return parts[0]
    pieces = [piece for k in range(len(parts)) for piece in _exposed(parts, k)]
    loops = []
    while pieces:
        loop = [pieces.pop()]
        while np.linalg.norm(loop[-1][1] - loop[0][0]) > SAME_END and pieces:
            away = [float(np.linalg.norm(piece[0] - loop[-1][1])) for piece in pieces]
            loop.append(pieces.pop(int(np.argmin(away))))
        loops.append(np.array([start for start, _ in loop]))
    return max(loops, key=lambda loop: float(_moments(loop)[0]))


def _exposed(parts: Sequence[np.ndarray], k: int) -> list[np.ndarray]:
    """Pieces (2, 2) of a part's edges, start and end, beyond which there is no other part. Where
    two parts have a piece in common, it is the earlier one's.
    """
    found = []
    for x, y, nx, ny, length in edge_table(parts[k], closed=True):
        start, along, normal = np.array([x, y]), np.array([-ny, nx]), np.array([nx, ny])
        free = [(0.0, float(length))]
        for j, other in enumerate(parts):
            if j == k:
                continue
            for side in (1.0, -1.0) if j < k else (1.0,):
                low, high = _inside(start + side * BESIDE * normal, along, other)
                cut = [(a, min(b, low)) for a, b in free] + [(max(a, high), b) for a, b in free]
                free = [(a, b) for a, b in cut if b - a > SAME_END] if low < high else free
        found += [np.array([start + a * along, start + b * along]) for a, b in free]
    return found


def _inside(start: np.ndarray, along: np.ndarray, polygon: np.ndarray) -> tuple[float, float]:
    """The interval [m] of start + t along that lies in a convex polygon; the lower end first unless
    it is empty.
    """
    low, high = -np.inf, np.inf
    for x, y, nx, ny, _ in edge_table(polygon, closed=True):
        height = nx * (start[0] - x) + ny * (start[1] - y)
        slope = nx * along[0] + ny * along[1]
        if abs(slope) < 1e-12:
            if height > 0.0:
                return 0.0, 0.0
        elif slope > 0.0:
            high = min(high, -height / slope)
        else:
            low = max(low, -height / slope)
    return low, high
