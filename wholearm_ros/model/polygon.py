"""A convex polygon: vertices, area, centroid, inertia."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wholearm_ros.model.arrays import readonly

ALIKE = 5e-4  # [m] outlines seen from two edges that differ by less feel the same


@dataclass(frozen=True, eq=False)
class Polygon:
    """A convex polygon with its vertices counter-clockwise.

    vertices: (n, 2) [m], in the frame in which they were given.
    """

    vertices: np.ndarray

    def __post_init__(self) -> None:
        object.__setattr__(self, 'vertices', readonly(self.vertices, (-1, 2)))

    @property
    def edges(self) -> np.ndarray:
        """(n, 2) [m]: edge k runs from vertex k to vertex k + 1."""
        edges: np.ndarray = np.roll(self.vertices, -1, axis=0) - self.vertices
        return edges

    @property
    def area(self) -> float:
        """Area [m²]."""
        return 0.5 * float(cross_with_next(self.vertices).sum())

    @cached_property
    def centroid(self) -> np.ndarray:
        """(2,) centroid [m], in the frame of `vertices`."""
        v, cross = self.vertices, cross_with_next(self.vertices)
        return readonly(
            ((v + np.roll(v, -1, axis=0)) * cross[:, None]).sum(axis=0) / (3.0 * cross.sum()), (2,)
        )

    @property
    def vertices_about_centroid(self) -> np.ndarray:
        """(n, 2) [m] vertices with the centroid as origin: the object frame."""
        about_centroid: np.ndarray = self.vertices - self.centroid
        return about_centroid

    def radius_of_gyration_squared(self) -> float:
        """Second polar moment of area about the centroid over the area [m²]."""
        v = self.vertices_about_centroid
        w, cross = np.roll(v, -1, axis=0), cross_with_next(v)
        return float(
            (cross * ((v * v) + (v * w) + (w * w)).sum(axis=1)).sum() / (6.0 * cross.sum())
        )

    def resting_angle(self, edge: int) -> float:
        """Rotation [rad] in (-π, π] that lays `edge` on a floor along +x, the polygon above."""
        dx, dy = self.edges[edge]
        return float(-np.arctan2(dy, dx))

    def can_rest_on(self, edge: int) -> bool:
        """Whether the centroid projects strictly inside `edge` (III-B.3)."""
        e = self.edges[edge]
        along = float((self.centroid - self.vertices[edge]) @ e / (e @ e))
        return 0.0 < along < 1.0

    @cached_property
    def resting_edges(self) -> tuple[int, ...]:
        """Those on which it can rest, in order: its faces."""
        return tuple(k for k in range(len(self.vertices)) if self.can_rest_on(k))

    def mirrored(self) -> 'Polygon':
        """The mirror image (x → -x), counter-clockwise again: edge k becomes edge n - 1 - k."""
        n = len(self.vertices)
        order = (-np.arange(n)) % n
        return Polygon((self.vertices * [-1.0, 1.0])[order])


def edge_table(vertices: np.ndarray, closed: bool) -> np.ndarray:
    """(n, 5) vertices, and of the edge that starts at each its unit normal and its length: out of a
    closed polygon (counter-clockwise), to the left of an open polyline, whose last vertex has no
    edge.
    """
    d = np.roll(vertices, -1, axis=0) - vertices
    length = np.linalg.norm(d, axis=1, keepdims=True)
    normal = np.column_stack([d[:, 1], -d[:, 0]]) / length * (1.0 if closed else -1.0)
    if not closed:
        normal[-1], length[-1] = 0.0, 0.0
    return np.hstack([vertices, normal, length])


def rotated(vertices: np.ndarray, angle: float) -> np.ndarray:
    """(n, 2) vertices turned about the origin by `angle` [rad], counter-clockwise."""
    # A matrix product, not `frame.turned`: its last bits are in the ids of all plans.
    c, s = np.cos(angle), np.sin(angle)
    turned: np.ndarray = vertices @ np.array([[c, s], [-s, c]])
    return turned


def support(vertices: np.ndarray, angle: float, normal: np.ndarray) -> float:
    """Least extent [m] of the vertices (n, 2), turned by `angle` [rad], along `normal` (2,); below
    the origin it is negative.
    """
    return float((rotated(vertices, angle) @ normal).min())


def pose_on_edge(vertices: np.ndarray, edge: np.ndarray, x: float, angle: float) -> np.ndarray:
    """(3,) pose, turned by `angle` [rad] and with the centroid at x [m], at which the lowest of the
    vertices (n, 2) about the centroid touches the line of an edge (5,), see `edge_table`.
    """
    ax, ay, nx, ny, _ = edge
    reach = support(vertices, angle, np.array([nx, ny]))
    y = ay + (-reach - nx * (x - ax)) / ny
    return np.array([x, y, angle])


def edges_look_alike(polygon: Polygon, tolerance: float) -> bool:
    """Whether the outline looks the same when it is turned, as a regular polygon's does; vertices
    within `tolerance` [m].
    """
    count = len(polygon.vertices)
    return any(same_outlines(polygon, 0, other, tolerance) for other in range(1, count))


def same_outlines(polygon: Polygon, one: int, other: int, tolerance: float) -> bool:
    """Whether the outlines of the object lying on edge `one` and on edge `other` coincide, each
    vertex within `tolerance` [m].
    """
    turned = []
    for edge in (one, other):
        vertices = np.roll(polygon.vertices_about_centroid, -edge, axis=0)
        turned.append(rotated(vertices, polygon.resting_angle(edge)))
    return bool(np.linalg.norm(turned[1] - turned[0], axis=1).max() < tolerance)


def cross_with_next(v: np.ndarray) -> np.ndarray:
    """(n,): twice the area that each vertex of v (n, 2) spans with the next one and the origin."""
    w = np.roll(v, -1, axis=0)
    cross: np.ndarray = v[:, 0] * w[:, 1] - v[:, 1] * w[:, 0]
    return cross
