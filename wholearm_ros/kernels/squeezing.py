"""Where an object that lies on the palm comes to rest when one finger is held and the other one
closes on it.

The object slides without friction along the palm, so the held finger's angle says where it lies,
and that says where the closing finger meets it.
"""

from typing import NamedTuple

import numpy as np

from wholearm_ros.kernels import inlined, kernel
from wholearm_ros.kernels.geometry import closing_angle, finger_clearance, frame_of_object
from wholearm_ros.model.configuration import ROTATION, X, Y
from wholearm_ros.model.hand import LEFT

SLIDE_STEPS, HALVINGS = 100, 36


class Slideway(NamedTuple):
    """Where an object may lie: pose (3,): x, y [m], rotation [rad] at slide 0; along (2,):
    direction of the palm; reach [m]: slides from −reach to reach are searched.
    """

    pose: np.ndarray
    along: np.ndarray
    reach: float


@kernel
def resting_slide(world, way, held, theta):
    """Slide [m] along the palm at which the object first touches the finger held at `theta` [rad],
    coming from its other side.

    NaN when it touches at the far end already, or never.
    """
    free = way.reach if held == LEFT else -way.reach
    step = (2.0 * way.reach / SLIDE_STEPS) * (-1.0 if held == LEFT else 1.0)
    if _clearance(world, way, held, theta, free) <= 0.0:
        return np.nan
    for _ in range(SLIDE_STEPS):
        touching = free + step
        if _clearance(world, way, held, theta, touching) <= 0.0:
            for _ in range(HALVINGS):
                middle = 0.5 * (free + touching)
                if _clearance(world, way, held, theta, middle) > 0.0:
                    free = middle
                else:
                    touching = middle
            return free
        free = touching
    return np.nan


@inlined
def pose_at(way, slide):
    """x, y [m], rotation [rad] after a slide [m]."""
    x, y = way.pose[X] + slide * way.along[X], way.pose[Y] + slide * way.along[Y]
    return x, y, way.pose[ROTATION]


@inlined
def _clearance(world, way, side, theta, slide):
    return finger_clearance(world, side, theta, frame_of_object(pose_at(way, slide)))


@kernel
def squeeze(world, way, held, thetas, slides, angles):
    """Fill slides (k,) [m] and angles (k,) [rad] of the closing finger for the held finger's
    angles thetas (k,).
    """
    for i in range(thetas.shape[0]):
        slides[i] = resting_slide(world, way, held, thetas[i])
        angles[i] = np.nan
        if not np.isnan(slides[i]):
            angles[i] = closing_angle(world, 1 - held, pose_at(way, slides[i]))
