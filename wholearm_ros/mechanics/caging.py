"""Caging: where gravity alone turns the object on until it rests on an edge (III-B.3).

On a level palm the frictionless object at rotation φ has least energy m g h(φ) with h(φ) the height
of its centroid when its lowest vertex touches. Where h falls all the way from φ to a stable edge,
and the kinetic energy is below the rise of h at the far end of that edge, the object cannot come to
rest anywhere else: fingers can only take energy from it.
"""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.model.frame import frame_at, turned
from wholearm_ros.model.polygon import Polygon

PAST_THE_TOP = 0.05  # [rad] how far the centroid must be past the pivot before the object is free


@dataclass(frozen=True)
class Cage:
    """The object turns counter-clockwise by gravity alone from `top` to `landing` [rad], to rest
    on `edge`.

    top: where the centroid is right above the pivot. beyond: the next such rotation past the edge.
    drop, barrier: fall of the centroid from top to landing, and rise from landing to beyond [m].
    """

    edge: int
    top: float
    landing: float
    beyond: float
    drop: float
    barrier: float


def cages_between(
    polygon: Polygon, start: float, goal: float, floor: float = 0.0
) -> tuple[Cage, ...]:
    """The cages that end on a stable edge in (start, goal], in the order in which a
    counter-clockwise turn meets them.

    start, goal, floor: rotations [rad] of the object and direction of the palm.
    """
    cages = []
    for edge in range(len(polygon.vertices)):
        if not polygon.can_rest_on(edge):
            continue
        landing = floor + polygon.resting_angle(edge)
        landing = start + np.mod(landing - start - 1e-9, 2 * np.pi) + 1e-9
        while landing <= goal + 1e-6:
            cages.append(_cage(polygon, edge, landing, floor))
            landing += 2 * np.pi
    return tuple(sorted(cages, key=lambda c: c.landing))


def _cage(polygon: Polygon, edge: int, landing: float, floor: float) -> Cage:
    v = polygon.vertices_about_centroid
    n = len(v)
    top, k = -np.inf, edge + 1
    # back over edges too steep to rest on, to the pivot that the centroid last stood above
    while True:
        top = _above(v[k % n], landing, floor)
        if polygon.can_rest_on(k % n) or k == edge + n:
            break
        if top >= _resting_before(polygon, k % n, landing, floor):
            break
        k += 1
    beyond = _above(v[edge], landing + 2 * np.pi, floor)
    while beyond - 2 * np.pi > landing:
        beyond -= 2 * np.pi
    rest = _height(v, landing, floor)
    return Cage(
        edge, top, landing, beyond, _height(v, top, floor) - rest, _height(v, beyond, floor) - rest
    )


def _above(vertex: np.ndarray, before: float, floor: float) -> float:
    """Largest rotation ≤ before at which the centroid stands above the vertex."""
    angle = floor - np.pi / 2 - np.arctan2(vertex[1], vertex[0])
    return float(before - np.mod(before - angle, 2 * np.pi))


def _resting_before(polygon: Polygon, edge: int, before: float, floor: float) -> float:
    return float(before - np.mod(before - floor - polygon.resting_angle(edge), 2 * np.pi))


def _height(v: np.ndarray, angle: float, floor: float) -> float:
    _, heights = turned(frame_at(0.0, 0.0, angle - floor), v[:, 0], v[:, 1])
    return float(-heights.min())
