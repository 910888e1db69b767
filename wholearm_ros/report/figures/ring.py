"""The faces of an object in a ring, in the order in which it is turned over them."""

import numpy as np

from wholearm_ros.model.polygon import Polygon, rotated

SHAPE = 0.26  # size of an object on a ring of radius 1


def ring_of_faces(polygon: Polygon) -> dict[int, np.ndarray]:
    """By face, (2,) where it is on a ring of radius 1 about the origin."""
    order = sorted(polygon.resting_edges, key=polygon.resting_angle)
    angles = 2 * np.pi * np.arange(len(order)) / len(order) + np.pi / 2
    return {face: np.array([np.cos(a), np.sin(a)]) for face, a in zip(order, angles)}


def outline_on_ring(polygon: Polygon, face: int) -> np.ndarray:
    """(n, 2): the object as it lies on that face, about its place on the ring."""
    vertices = polygon.vertices_about_centroid
    scale = SHAPE / np.linalg.norm(vertices, axis=1).max()
    return np.asarray(scale * rotated(vertices, polygon.resting_angle(face)))
