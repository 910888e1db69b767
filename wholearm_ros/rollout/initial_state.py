"""Where an object that is not quite the one in the scenario comes to lie when it is set down."""

import numpy as np

from wholearm_ros.mechanics.contacts import close_finger, pose_on_palm, start_configuration
from wholearm_ros.mechanics.world import World, build_world
from wholearm_ros.model.configuration import POSE, ROTATION, joint_index
from wholearm_ros.model.hand import LEFT, RIGHT
from wholearm_ros.model.orientation import palm_segment_under
from wholearm_ros.model.scenario import Scenario, StartAtPose

TOUCHING = 1e-3  # [m] an object told to be nearer to the palm than this is meant to lie on it
TOUCHING_ANGLE = 0.01  # [rad] a finger told to be nearer to touching than this is meant to touch


def perturbed_start(told: Scenario, truth: Scenario, true_world: World | None = None) -> np.ndarray:
    """q (5,): centroid x, y [m], rotation [rad], finger angles [rad] at the start of the true
    scenario.

    What lies on the palm lies on it in truth, and a finger that touches touches in truth; nothing
    penetrates.
    """
    true_world = true_world or build_world(truth)
    if not isinstance(truth.start, StartAtPose):
        return start_configuration(truth, true_world, in_truth=True)
    q = start_configuration(told).copy()
    told_world = build_world(told)
    segment = palm_segment_under(truth.palm, q[0])
    told_y, true_y = (
        pose_on_palm(w, q[0], q[ROTATION], segment)[1] for w in (told_world, true_world)
    )
    told_pose = q[POSE].copy()
    q[1] = true_y if q[1] - told_y < TOUCHING else max(q[1], true_y)
    for side, outwards in ((LEFT, 1.0), (RIGHT, -1.0)):
        told_touch, true_touch = (
            close_finger(told_world, told_pose, side),
            close_finger(true_world, q[POSE], side),
        )
        j = joint_index(side)
        opened = outwards * (q[j] - told_touch) > TOUCHING_ANGLE
        q[j] = outwards * max(outwards * q[j], outwards * true_touch) if opened else true_touch
    return q
