"""Where the object and the fingers are: transforms from the palm, on /tf where it can be."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from geometry_msgs.msg import TransformStamped

from wholearm_ros.model.scenario import Scenario
from wholearm_ros.ros.interface.channels import FINGER_FRAMES, OBJECT_FRAME, PALM_FRAME, TRANSFORMS
from wholearm_ros.ros.interface.messages import fill_rotation, set_stamp

if TYPE_CHECKING:
    from wholearm_ros.ros.node.node import WholeArmNode

try:
    from tf2_msgs.msg import TFMessage
except ImportError:  # there is no wheel of it
    TFMessage = None


class Frames:
    """Publishes the three transforms, together on /tf or one by one on `transforms`."""

    def __init__(self, node: WholeArmNode, scenario: Scenario) -> None:
        self._axes = [scenario.hand.left.axis, scenario.hand.right.axis]
        palm = node.frame(PALM_FRAME)
        self._transforms = [
            _transform(palm, node.frame(frame)) for frame in (OBJECT_FRAME, *FINGER_FRAMES)
        ]
        self._publisher = (
            node.publisher(TRANSFORMS)
            if TFMessage is None
            else node.create_publisher(TFMessage, '/tf', 100)
        )

    def publish(self, stamp: int, pose: np.ndarray, angles: np.ndarray) -> None:
        """stamp [ns]; pose (3,) of the object [m, m, rad]; angles (2,) of the joints [rad]."""
        fingers = [np.array([*axis, angle]) for axis, angle in zip(self._axes, angles)]
        for transform, (x, y, turn) in zip(self._transforms, [pose, *fingers]):
            set_stamp(transform.header.stamp, stamp)
            place = transform.transform.translation
            place.x, place.y = float(x), float(y)
            fill_rotation(transform.transform.rotation, turn)
        if TFMessage is not None:
            self._publisher.publish(TFMessage(transforms=self._transforms))
        else:
            for transform in self._transforms:
                self._publisher.publish(transform)


def _transform(parent: str, child: str) -> TransformStamped:
    transform = TransformStamped(child_frame_id=child)
    transform.header.frame_id = parent
    return transform
