"""Edges and corners of fingers, numbered: what contact pairs name.

They are counted from the inner corner at the base, first towards the tip and then round, so that
those of a finger and of its mirror image have the same numbers; one part after the other.
"""

from typing import NamedTuple

import numpy as np

from wholearm_ros.kernels.geometry import RECTANGLE_CORNERS, RECTANGLE_EDGES
from wholearm_ros.kernels.world import FingerFeatures
from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.finger_shape import FingerShape, Rectangle
from wholearm_ros.model.frame import Frame
from wholearm_ros.model.hand import LEFT, RIGHT, Hand
from wholearm_ros.model.polygon import edge_table
from wholearm_ros.model.separation import point_clearance

SAME_POINT = 1e-9  # [m] corners that are nearer are one; a point that is deeper in a part is hidden
ASIDE = 1e-6  # [m] from a corner along an edge, where it is asked whether the edge is hidden
HERE = Frame(0.0, 0.0, 1.0, 0.0)


class _Numbered(NamedTuple):
    """Of one finger, see `FingerFeatures`; rows of each part's edges, numbers of this finger."""

    parts: list[list[list[float]]]
    corners: list[np.ndarray]
    ends: list[list[int]]
    meeting: list[list[int]]
    first_edge: int
    first_corner: int


def build_finger_features(hand: Hand) -> FingerFeatures:
    """Those of both fingers."""
    fingers = [_numbered(hand[side].shape, side) for side in (LEFT, RIGHT)]
    parts, edge_rows, corner_rows, row, corner = [], [], [], 0, 0
    for side, finger in enumerate(fingers):
        edge_rows.append(row - finger.first_edge)
        corner_rows.append(corner - finger.first_corner)
        for edges in finger.parts:
            parts.append([side, row, row + len(edges)])
            row += len(edges)
        corner += len(finger.corners)
    return FingerFeatures(
        parts=readonly(parts, dtype=np.int64),
        edges=readonly([e for finger in fingers for edges in finger.parts for e in edges]),
        corners=readonly([c for finger in fingers for c in finger.corners]),
        corner_sides=readonly(
            [side for side, finger in enumerate(fingers) for _ in finger.corners], dtype=np.int64
        ),
        edge_ends=readonly([e for finger in fingers for e in finger.ends], dtype=np.int64),
        edges_at=readonly([c for finger in fingers for c in finger.meeting], dtype=np.int64),
        edge_rows=readonly(edge_rows, dtype=np.int64),
        corner_rows=readonly(corner_rows, dtype=np.int64),
    )


def _numbered(shape: FingerShape, side: int) -> _Numbered:
    inward = -1.0 if side == LEFT else 1.0
    walks = [_walk(part, inward) for part in shape.parts]
    tables = [edge_table(part, closed=True) for part in shape.parts]
    plain = isinstance(shape, Rectangle)
    first_edge, first_corner = (0, 0) if plain else (RECTANGLE_EDGES, RECTANGLE_CORNERS)
    corners: list[np.ndarray] = []
    meeting: list[list[int]] = []
    parts, ends, edge = [], [], first_edge
    for k, (part, table, walk) in enumerate(zip(shape.parts, tables, walks)):
        others = [other for j, other in enumerate(tables) if j != k]
        rows = []
        for before, after in walk:
            # The table has the edges counter-clockwise, by where they start.
            ccw = before if side == LEFT else after
            turned_round = _runs_back(part[after] - part[before], inward)
            start, end = (after, before) if turned_round else (before, after)
            x, y, nx, ny, length = table[ccw]
            along = (part[end] - part[start]) / length
            level = nx * x + ny * y
            rows.append([x, y, nx, ny, length, *part[start], *along, level])
            numbers = {}
            for at in (before, after):
                sense, numbers[at] = 1.0 if at == start else -1.0, -1
                if plain and part[at, 0] == 0.0:
                    continue
                number = _corner_at(part[at], corners, meeting, others)
                if number < 0:
                    continue
                numbers[at] = first_corner + number
                aside = part[at] + sense * ASIDE * along + SAME_POINT * np.array([nx, ny])
                if not _hidden(aside, others):
                    meeting[number].append(edge)
            ends.append([numbers[start], numbers[end]])
            edge += 1
        parts.append(rows)
    pairs = [(edges + [-1, -1])[:2] for edges in meeting]
    return _Numbered(parts, corners, ends, pairs, first_edge, first_corner)


def _walk(part: np.ndarray, inward: float) -> list[tuple[int, int]]:
    """The edges as pairs of vertices, from the inner one at the base towards the tip and round."""
    first = min(range(len(part)), key=lambda k: (part[k, 0], -inward * part[k, 1]))
    step = 1 if inward < 0.0 else -1
    order = [(first + step * k) % len(part) for k in range(len(part) + 1)]
    return list(zip(order[:-1], order[1:]))


def _runs_back(along: np.ndarray, inward: float) -> bool:
    """Positions are counted away from the axis, along an edge across the finger inwards."""
    return bool(along[0] < 0.0 or (along[0] == 0.0 and inward * along[1] < 0.0))


def _corner_at(
    point: np.ndarray,
    corners: list[np.ndarray],
    meeting: list[list[int]],
    others: list[np.ndarray],
) -> int:
    """The number of the corner there, a new one if need be; −1 where another part covers it."""
    for number, corner in enumerate(corners):
        if np.linalg.norm(corner - point) <= SAME_POINT:
            return number
    for other in others:
        apart = np.linalg.norm(other[:, :2] - point, axis=1).min()
        if apart > SAME_POINT and point_clearance(other, HERE, *point)[0] <= SAME_POINT:
            return -1
    corners.append(point)
    meeting.append([])
    return len(corners) - 1


def _hidden(point: np.ndarray, others: list[np.ndarray]) -> bool:
    """Whether a point lies in another part."""
    return any(point_clearance(other, HERE, *point)[0] < 0.0 for other in others)
