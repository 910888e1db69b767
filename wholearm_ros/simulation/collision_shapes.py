"""Flat bodies for a 3-D engine: polygons inset by the engine's collision margin."""

import numpy as np

from wholearm_ros.model.hand import Finger, Palm

PALM_DEPTH = 0.03  # [m] the palm is solid this far below its surface


def inset(polygon: np.ndarray, distance: float) -> np.ndarray:
    """(n, 2) [m]: the convex, counter-clockwise `polygon` (n, 2) with its edges moved inwards.

    Raises ValueError when nothing is left of an edge.
    """
    edges = np.roll(polygon, -1, axis=0) - polygon
    tangents = edges / np.linalg.norm(edges, axis=1)[:, None]
    normals = np.stack([-tangents[:, 1], tangents[:, 0]], axis=1)
    levels = (normals * polygon).sum(axis=1) + distance
    before = np.roll(normals, 1, axis=0)
    right_sides = np.stack([np.roll(levels, 1), levels], axis=1)  # (n, 2)
    corners = np.linalg.solve(np.stack([before, normals], axis=1), right_sides[..., None])[..., 0]
    if np.any(((np.roll(corners, -1, axis=0) - corners) * edges).sum(axis=1) <= 0.0):
        raise ValueError(f'polygon has an edge too short to be inset by {distance} m')
    return corners


def finger_rectangle(finger: Finger) -> np.ndarray:
    """(4, 2) [m] in the finger's frame: from the axis along +x."""
    length, half = finger.length, finger.half_width
    return np.array([[0.0, -half], [length, -half], [length, half], [0.0, half]])


def palm_slabs(palm: Palm) -> list[np.ndarray]:
    """One (4, 2) [m] slab under each segment of the palm, its free side on the segment's left."""
    slabs = []
    for a, b in zip(palm.vertices[:-1], palm.vertices[1:]):
        tangent = (b - a) / np.linalg.norm(b - a)
        down = PALM_DEPTH * np.array([tangent[1], -tangent[0]])
        slabs.append(np.array([a + down, b + down, b, a]))
    return slabs
