"""How far a convex body is from a point and from a finger, as plain formulas: `kernels/` compiles
these very functions.

obj: (n, 5), the edges of the body in its frame, see `polygon.edge_table`. Separations are those of
the separating axis theorem: positive apart, negative where bodies overlap.
"""

import numpy as np
from numpy import maximum, minimum

from wholearm_ros.model.frame import Frame, Value, in_body, in_world, seen_from, turned


def point_clearance(obj: np.ndarray, frame: Frame, x: float, y: float) -> tuple[float, int]:
    """(signed distance [m] of a point from the farthest of the lines through the body's edges,
    that edge): negative inside.
    """
    px, py = in_body(frame, x, y)
    best, edge = -np.inf, -1
    for j in range(obj.shape[0]):
        gap = obj[j, 2] * (px - obj[j, 0]) + obj[j, 3] * (py - obj[j, 1])
        if gap > best:
            best, edge = gap, j
    return best, edge


def rectangle_clearance(
    obj: np.ndarray, frame: Frame, finger: Frame, length: float, half_width: float
) -> Value:
    """Separation [m] of the body and a rectangular finger.

    finger: its frame, or frames as arrays; it reaches from there along x for `length`.
    """
    near_along, far_along, near_across, far_across = np.inf, -np.inf, np.inf, -np.inf
    greatest = -np.inf
    for j in range(obj.shape[0]):
        x, y = in_world(frame, obj[j, 0], obj[j, 1])
        nx, ny = turned(frame, obj[j, 2], obj[j, 3])
        along, across = in_body(finger, x, y)
        near_along, far_along = minimum(near_along, along), maximum(far_along, along)
        near_across, far_across = minimum(near_across, across), maximum(far_across, across)
        axis = nx * (finger.x - x) + ny * (finger.y - y)
        side = half_width * np.abs(ny * finger.cos - nx * finger.sin)
        tip = minimum(0.0, length * (nx * finger.cos + ny * finger.sin))
        greatest = maximum(greatest, axis - side + tip)
    beside = maximum(near_across - half_width, -far_across - half_width)
    beyond = maximum(near_along - length, -far_along)
    return maximum(greatest, maximum(beside, beyond))


def part_clearance(obj: np.ndarray, frame: Frame, part: np.ndarray, finger: Frame) -> Value:
    """Separation [m] of the body and a convex part (m, 5 or more), its edges as those of `obj`.

    finger: the part's frame, or frames as arrays.
    """
    here, there = seen_from(finger, frame), seen_from(frame, finger)
    over_the_body = _height_over(obj, part, there)
    return maximum(over_the_body, _height_over(part, obj, here))


def _height_over(edges: np.ndarray, points: np.ndarray, frame: Frame) -> Value:
    """The greatest height [m] over one of the edges (n, 5) of the lowest of the points (m, 2 or
    more), which have the frame `frame` in that of the edges.
    """
    greatest = -np.inf
    for j in range(edges.shape[0]):
        nx, ny = edges[j, 2], edges[j, 3]
        along = nx * frame.cos + ny * frame.sin
        across = ny * frame.cos - nx * frame.sin
        lowest = np.inf
        for k in range(points.shape[0]):
            lowest = minimum(lowest, along * points[k, 0] + across * points[k, 1])
        height = nx * (frame.x - edges[j, 0]) + ny * (frame.y - edges[j, 1])
        greatest = maximum(greatest, height + lowest)
    return greatest
