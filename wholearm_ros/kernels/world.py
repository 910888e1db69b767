"""The world of the kernels: a hand and an object as arrays, handed whole to every kernel that
needs any of it.
"""

from typing import NamedTuple

import numpy as np

from wholearm_ros.kernels import kernel
from wholearm_ros.model import configuration

joint = kernel(configuration.joint_index)


class World(NamedTuple):
    """obj: (n, 5), palm: (p, 5) [m], vertices with the unit normal and the length of the edge that
    starts at each: out of the object, to the free side of the palm; object vertices are about
    the centroid. fingers: (2, 4) [m], axis x, y, length and half width; corners: (c,) palm
    vertices that can touch an object edge; scale: (5,) of the coordinates, by which
    configurations are compared; limits: (2, 2) of the joints [rad]; load: (5,) = (−g_O, ·) [N,
    N, N m], the finger entries of which depend on the angles (`statics.load_at`);
    finger_moment: (2,) = m g L / 2 [N m]; inertias: (5,) [kg, kg, kg m², …]; torque_limits:
    (2,) [N m]; joint_friction: (2,) [N m]; leaning: tangent of the angle by which gravity is
    turned from -y.
    """

    obj: np.ndarray
    palm: np.ndarray
    fingers: np.ndarray
    corners: np.ndarray
    scale: np.ndarray
    limits: np.ndarray
    load: np.ndarray
    finger_moment: np.ndarray
    inertias: np.ndarray
    torque_limits: np.ndarray
    joint_friction: np.ndarray
    leaning: float
