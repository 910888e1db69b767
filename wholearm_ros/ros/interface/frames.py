"""Where the object and the fingers are, as transforms from the palm: on /tf where tf2_msgs can be imported."""

from math import cos, sin

from geometry_msgs.msg import TransformStamped

from wholearm_ros.model.scenario import Scenario
from wholearm_ros.ros.interface.channels import FINGER_FRAMES, OBJECT_FRAME, PALM_FRAME, TRANSFORMS
from wholearm_ros.ros.interface.messages import set_stamp

try:
    from tf2_msgs.msg import TFMessage
except ImportError:  # there is no wheel of it
    TFMessage = None


class Frames:
    """Publishes the three transforms, together on /tf or one by one on `transforms`."""

    def __init__(self, node, scenario: Scenario):
        self._axes = [scenario.hand.left.axis, scenario.hand.right.axis]
        self._transforms = [_transform(frame) for frame in (OBJECT_FRAME, *FINGER_FRAMES)]
        self._publisher = (
            node.publisher(TRANSFORMS)
            if TFMessage is None
            else node.create_publisher(TFMessage, '/tf', 100)
        )

    def publish(self, stamp: int, pose, angles):
        """stamp [ns]; pose (3,) of the object [m, m, rad]; angles (2,) of the joints [rad]."""
        for transform, (x, y, turn) in zip(
            self._transforms, (pose, *((*axis, angle) for axis, angle in zip(self._axes, angles)))
        ):
            set_stamp(transform.header.stamp, stamp)
            transform.transform.translation.x, transform.transform.translation.y = (
                float(x),
                float(y),
            )
            transform.transform.rotation.z, transform.transform.rotation.w = (
                sin(turn / 2),
                cos(turn / 2),
            )
        if TFMessage is not None:
            self._publisher.publish(TFMessage(transforms=self._transforms))
        else:
            for transform in self._transforms:
                self._publisher.publish(transform)


def _transform(child: str) -> TransformStamped:
    transform = TransformStamped(child_frame_id=child)
    transform.header.frame_id = PALM_FRAME
    return transform
