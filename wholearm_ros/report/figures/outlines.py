"""Outlines of the hand and the object at a configuration, and where they touch. Lengths [m], palm
frame.
"""

from collections.abc import Sequence

import numpy as np

from wholearm_ros.kernels import geometry
from wholearm_ros.mechanics.contacts import closed_pairs, pair_from_name, pair_name
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.frame import frame_at, placed
from wholearm_ros.model.hand import SIDES, Finger
from wholearm_ros.model.polygon import edge_table
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.separation import point_clearance

MARGIN = 0.012  # [m] left free around what is shown
TOUCH = 6e-4  # [m] gap below which a contact is drawn; PyBullet's own gaps are about half of it
# [m] along a normal: whoever pushes the object is outside of it, what is pushed is inside.
PROBE = 2e-3


def finger_outline(finger: Finger, theta: float) -> np.ndarray:
    """(n, 2) boundary of a finger whose joint is at `theta` [rad]."""
    return placed(finger.shape.outline, np.array([*finger.axis, theta]))


def object_outline(scenario: Scenario, pose: np.ndarray) -> np.ndarray:
    """(n, 2) vertices of the object at `pose` (3,)."""
    return placed(scenario.object.polygon.vertices_about_centroid, pose)


def hand_outlines(scenario: Scenario, angles: np.ndarray) -> list[np.ndarray]:
    """Both fingers at `angles` (2,) [rad], (n, 2) each, left then right."""
    return [finger_outline(scenario.hand[side], angles[side]) for side in range(len(SIDES))]


def contact_marks(
    scenario: Scenario, configuration: np.ndarray, contacts: Sequence[str]
) -> tuple[np.ndarray, np.ndarray]:
    """(points (k, 2) [m], unit normals towards the object (k, 2)) of named pairs at a configuration
    (5,).
    """
    world = build_world(scenario)
    rows = [geometry.contact(world, pair_from_name(name), configuration)[:4] for name in contacts]
    table = np.array(rows, dtype=float).reshape(-1, 4)
    return table[:, :2], table[:, 2:]


def touching(scenario: Scenario, configuration: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same of whatever is closed to within TOUCH at a configuration; nothing when the object's
    pose is not known.
    """
    if not np.isfinite(configuration).all():
        return np.empty((0, 2)), np.empty((0, 2))
    closed = closed_pairs(build_world(scenario), configuration, TOUCH)
    points, normals = contact_marks(scenario, configuration, [pair_name(c) for c in closed])
    # A vertex at a finger's corner is near two edges of the finger, of which it may lie beside one.
    pushing = [
        _inside(object_outline(scenario, configuration[:3]), p + PROBE * n)
        for p, n in zip(points, normals)
    ]
    return points[pushing], normals[pushing]


def _inside(outline: np.ndarray, point: np.ndarray) -> bool:
    """Whether a point lies in a counter-clockwise outline (n, 2), TOUCH beyond its edges too."""
    edges = edge_table(outline, closed=True)
    return point_clearance(edges, frame_at(0.0, 0.0, 0.0), *point)[0] <= TOUCH


def view_box(
    scenario: Scenario, poses: np.ndarray, angles: np.ndarray
) -> tuple[float, float, float, float]:
    """(left, right, bottom, top) [m] that holds the object at `poses` (m, 3) and the fingers at
    `angles` (m, 2).

    Of a fallen object only what is near the hand is kept.
    """
    step = max(1, len(poses) // 40)
    outlines = [object_outline(scenario, pose) for pose in poses[::step] if np.isfinite(pose).all()]
    for pair in angles[:: max(1, len(angles) // 40)]:
        outlines += hand_outlines(scenario, pair)
    points = np.vstack(outlines)
    reach = max(f.shape.length for f in (scenario.hand.left, scenario.hand.right))
    axes = np.array([scenario.hand.left.axis, scenario.hand.right.axis])
    low = np.maximum(points.min(axis=0), axes.min(axis=0) - reach) - MARGIN
    high = np.minimum(points.max(axis=0), axes.max(axis=0) + 1.5 * reach) + MARGIN
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])
