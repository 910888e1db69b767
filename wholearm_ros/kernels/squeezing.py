"""Where an object that lies on the palm comes to rest when one finger is held and the other one
closes on it.

The object slides without friction along the palm, so the held finger's angle says where it lies,
and that says where the closing finger meets it. Geometry arrays are those of `kernels/geometry.py`.
"""

import numpy as np

from wholearm_ros.kernels import kernel
from wholearm_ros.kernels.geometry import closing_angle, finger_clearance

SLIDE_STEPS, HALVINGS = 100, 36


@kernel
def resting_slide(obj, fingers, held, theta, start, along, reach, c, s):
    """Slide [m] along the palm at which the object first touches the held finger, coming from its
    other side.

    start (2,): the centroid at slide 0; along (2,): direction of the palm; reach [m]: slides from
    −reach to reach are searched; c, s: of the object's rotation. NaN when it touches at the far end
    already, or never.
    """
    step = (2.0 * reach / SLIDE_STEPS) * (-1.0 if held == 0 else 1.0)
    free = reach if held == 0 else -reach
    if (
        finger_clearance(
            obj, fingers, held, theta, start[0] + free * along[0], start[1] + free * along[1], c, s
        )
        <= 0.0
    ):
        return np.nan
    for _ in range(SLIDE_STEPS):
        touching = free + step
        x, y = start[0] + touching * along[0], start[1] + touching * along[1]
        if finger_clearance(obj, fingers, held, theta, x, y, c, s) <= 0.0:
            for _ in range(HALVINGS):
                middle = 0.5 * (free + touching)
                x, y = start[0] + middle * along[0], start[1] + middle * along[1]
                if finger_clearance(obj, fingers, held, theta, x, y, c, s) > 0.0:
                    free = middle
                else:
                    touching = middle
            return free
        free = touching
    return np.nan


@kernel
def squeeze(obj, fingers, limits, held, thetas, start, along, reach, c, s, slides, angles):
    """Fill slides (k,) [m] and angles (k,) [rad] of the closing finger for the held finger's
    angles thetas (k,).
    """
    for i in range(thetas.shape[0]):
        slides[i] = resting_slide(obj, fingers, held, thetas[i], start, along, reach, c, s)
        angles[i] = np.nan
        if not np.isnan(slides[i]):
            x, y = start[0] + slides[i] * along[0], start[1] + slides[i] * along[1]
            angles[i] = closing_angle(obj, fingers, limits, 1 - held, x, y, np.arctan2(s, c))
