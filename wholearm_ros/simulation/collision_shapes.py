"""Flat bodies for a 3-D engine: polygons inset by the engine's collision margin."""

import numpy as np

from wholearm_ros.model.hand import Palm
from wholearm_ros.model.polygon import edge_table

PALM_DEPTH = 0.03  # [m] the palm is solid this far below its surface


def inset(polygon: np.ndarray, distance: float) -> np.ndarray:
    """(n, 2) [m]: the convex, counter-clockwise `polygon` (n, 2) with its edges moved inwards.

    Raises ValueError when nothing is left of an edge.
    """
    edges = np.roll(polygon, -1, axis=0) - polygon
    normals = -edge_table(polygon, closed=True)[:, 2:4]
    levels = (normals * polygon).sum(axis=1) + distance
    before = np.roll(normals, 1, axis=0)
    right_sides = np.stack([np.roll(levels, 1), levels], axis=1)  # (n, 2)
    corners = np.linalg.solve(np.stack([before, normals], axis=1), right_sides[..., None])[..., 0]
    if np.any(((np.roll(corners, -1, axis=0) - corners) * edges).sum(axis=1) <= 0.0):
        raise ValueError(f'polygon has an edge too short to be inset by {distance} m')
    return corners


def palm_slabs(palm: Palm) -> list[np.ndarray]:
    """One (4, 2) [m] slab under each segment of the palm, its free side on the segment's left."""
    v = palm.vertices
    down = -PALM_DEPTH * edge_table(v, closed=False)[:, 2:4]
    return [np.array([a + d, b + d, b, a]) for a, b, d in zip(v[:-1], v[1:], down)]
