"""Slow and obvious geometry of object and hand, the twin of kernels/geometry.py: corners, edges and half planes."""

import numpy as np

from wholearm_ros.mechanics.contacts import pair_name
from wholearm_ros.model.hand import SIDES
from wholearm_ros.model.scenario import Scenario

INF = np.inf


def object_outline(scenario: Scenario, q: np.ndarray) -> np.ndarray:
    """(n, 2) corners, counter-clockwise."""
    c, s = np.cos(q[2]), np.sin(q[2])
    return scenario.object.polygon.vertices_about_centroid @ np.array([[c, s], [-s, c]]) + q[:2]


def finger_outline(scenario: Scenario, side: int, angle: float) -> np.ndarray:
    """(4, 2) corners, counter-clockwise."""
    f = scenario.hand[side]
    return rectangle(f.axis, angle, f.length, f.half_width)


def rectangle(axis, angle: float, length: float, half_width: float) -> np.ndarray:
    """(4, 2) corners, counter-clockwise: from `axis` along `angle`."""
    along = np.array([np.cos(angle), np.sin(angle)])
    across = half_width * np.array([-along[1], along[0]])
    tip = axis + length * along
    return np.array([axis - across, tip - across, tip + across, axis + across])


def separation(a: np.ndarray, b: np.ndarray) -> float:
    """Separation [m] of two convex outlines by the separating axis theorem; minus the depth where they overlap."""
    return max(_apart(a, b), _apart(b, a))


def _apart(a, b) -> float:
    """Largest distance of b from a line through an edge of a, outwards."""
    edges = zip(a, np.roll(a, -1, axis=0))
    return max(min(height(point, start, end) for point in b) for start, end in edges)


def finger_features(scenario: Scenario, side: int, angle: float) -> dict:
    """Edges as (start, end) with the finger on their left, and the two corners at the tip, by name."""
    base_right, tip_right, tip_left, base_left = finger_outline(scenario, side, angle)
    right, left = (base_right, tip_right), (tip_left, base_left)
    inner, outer = (right, left) if SIDES[side] == 'left' else (left, right)
    inner_corner, outer_corner = (
        (tip_right, tip_left) if SIDES[side] == 'left' else (tip_left, tip_right)
    )
    return {
        'inner': inner,
        'outer': outer,
        'tip': (tip_right, tip_left),
        'base': (base_left, base_right),
        'inner_corner': inner_corner,
        'outer_corner': outer_corner,
    }


def height(point, start, end) -> float:
    """Distance of a point from the line start → end, positive on its right (outside of a counter-clockwise outline)."""
    d = (end - start) / np.linalg.norm(end - start)
    return float(d[1] * (point - start)[0] - d[0] * (point - start)[1])


def outside(point, outline) -> float:
    """Largest height of a point over the edges of a convex outline: negative inside."""
    return max(height(point, a, b) for a, b in zip(outline, np.roll(outline, -1, axis=0)))


def gap_of(scenario: Scenario, code: int, q: np.ndarray) -> float:
    """Signed gap [m] of a contact pair, by its name."""
    mine, hand = pair_name(code).split(':')
    body, feature = hand.split('.')
    outline = object_outline(scenario, q)
    k = int(mine[1:])
    if body == 'palm':
        v, j = scenario.palm.vertices, int(feature[1:])
        other = (
            (v[j + 1], v[j]) if feature[0] == 'e' else v[j]
        )  # turned round: its free side is on the left
    else:
        other = finger_features(scenario, SIDES.index(body), q[3 + SIDES.index(body)])[feature]
    if mine[0] == 'v':
        return height(outline[k], *other)
    return height(other, outline[k], outline[(k + 1) % len(outline)])
