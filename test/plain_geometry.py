"""Slow and obvious geometry of object and hand, the twin of kernels/geometry.py: corners, edges and half planes."""

import numpy as np

from wholearm_ros.mechanics.contacts import pair_name
from wholearm_ros.model.finger_shape import Rectangle
from wholearm_ros.model.hand import SIDES
from wholearm_ros.model.scenario import Scenario

INF = np.inf


def object_outline(scenario: Scenario, q: np.ndarray) -> np.ndarray:
    """(n, 2) corners, counter-clockwise."""
    c, s = np.cos(q[2]), np.sin(q[2])
    return scenario.object.polygon.vertices_about_centroid @ np.array([[c, s], [-s, c]]) + q[:2]


def finger_parts(scenario: Scenario, side: int, angle: float) -> list[np.ndarray]:
    """(n, 2) corners of each convex part, counter-clockwise."""
    f = scenario.hand[side]
    if isinstance(f.shape, Rectangle):
        return [rectangle(f.axis, angle, f.shape.length, f.shape.half_width)]
    c, s = np.cos(angle), np.sin(angle)
    return [f.axis + [[c * x - s * y, s * x + c * y] for x, y in part] for part in f.shape.parts]


def finger_outline(scenario: Scenario, side: int, angle: float) -> np.ndarray:
    """(n, 2) corners of a finger of one part, counter-clockwise."""
    (outline,) = finger_parts(scenario, side, angle)
    return outline


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
    """Edges as (start, end) with the finger on their left, and the corners that an edge of the object can touch, by name."""
    if not isinstance(scenario.hand[side].shape, Rectangle):
        return _numbered_features(scenario, side, angle)
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


def _numbered_features(scenario: Scenario, side: int, angle: float) -> dict:
    """Counted from the inner corner at the base, first towards the tip; corners hidden in another part do not count."""
    parts, own = finger_parts(scenario, side, angle), scenario.hand[side].shape.parts
    features, edges, corners = {}, 0, 0
    for k, (part, at_zero) in enumerate(zip(parts, own)):
        inner_first = at_zero[:, 1] if SIDES[side] == 'left' else -at_zero[:, 1]
        first = np.lexsort([inner_first, at_zero[:, 0]])[0]
        ccw = np.roll(part, -first, axis=0)
        ring = ccw if SIDES[side] == 'left' else np.roll(ccw[::-1], 1, axis=0)
        for here, after in zip(ring, np.roll(ring, -1, axis=0)):
            features[f'e{edges}'] = (here, after) if SIDES[side] == 'left' else (after, here)
            edges += 1
            if all(outside(here, other) > 0.0 for j, other in enumerate(parts) if j != k):
                features[f'c{corners}'] = here
                corners += 1
    return features


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
