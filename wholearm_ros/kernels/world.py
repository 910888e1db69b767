"""The world of the kernels: a hand and an object as arrays, handed whole to every kernel that
needs any of it.
"""

from typing import NamedTuple

import numpy as np

from wholearm_ros.kernels import kernel
from wholearm_ros.model import configuration
from wholearm_ros.model.weight import bearing_torques

joint = kernel(configuration.joint_index)


class FingerFeatures(NamedTuple):
    """Edges and corners of both fingers in their frames, the left one's first.

    parts: (p, 3), the convex parts: whose it is, LEFT or RIGHT, its first row of `edges`, the row
    after its last one. edges: (e, 10) [m], as `polygon.edge_table` has them: vertex, unit normal
    out of the part, length; then the start x, y from which positions are counted, the unit
    direction, and the level of the edge's line along the normal. corners: (c, 2) [m], those that an
    edge of the object can touch; corner_sides: (c,) whose. edge_ends: (e, 2) numbers of the corners
    at the start and the end; edges_at: (c, 2) of the edges that meet in a corner; −1 where there is
    none. edge_rows, corner_rows: (2,) the row of each finger's feature 0.
    """

    parts: np.ndarray
    edges: np.ndarray
    corners: np.ndarray
    corner_sides: np.ndarray
    edge_ends: np.ndarray
    edges_at: np.ndarray
    edge_rows: np.ndarray
    corner_rows: np.ndarray


class World(NamedTuple):
    """obj: (n, 5), palm: (p, 5) [m], vertices with the unit normal and the length of the edge that
    starts at each: out of the object, to the free side of the palm; object vertices are about
    the centroid. fingers: (2, 4) [m], axis x, y, length, and a bound of how far from the axis any
    point is; features: their edges and corners; rectangles: (2, 2) [m], length and half width of a
    finger that is one, else 0; corners: (c,) palm vertices that can touch an object edge; scale:
    (5,) of the coordinates, by which configurations are compared; limits: (2, 2) of the joints
    [rad]; load: (5,) = (−g_O, ·) [N, N, N m], the finger entries of which depend on the angles
    (`statics.load_at`); finger_weights: (2, 2) [N m], see `weight.bearing_torques`; inertias: (5,)
    [kg, kg, kg m², …]; torque_limits: (2,) [N m]; joint_friction: (2,) [N m]; leaning: tangent of
    the angle by which gravity is turned from -y.
    """

    obj: np.ndarray
    palm: np.ndarray
    fingers: np.ndarray
    features: FingerFeatures
    rectangles: np.ndarray
    corners: np.ndarray
    scale: np.ndarray
    limits: np.ndarray
    load: np.ndarray
    finger_weights: np.ndarray
    inertias: np.ndarray
    torque_limits: np.ndarray
    joint_friction: np.ndarray
    leaning: float

    def bearing(self, q: np.ndarray) -> np.ndarray:
        """(…, 2) [N m] that hold the fingers at q (…, 5) against gravity along -y."""
        return bearing_torques(self.finger_weights, q[..., configuration.JOINTS])
