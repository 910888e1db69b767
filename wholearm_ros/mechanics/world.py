"""A scenario as the arrays that the kernels work on."""

import numpy as np

from wholearm_ros.kernels.world import World
from wholearm_ros.mechanics.finger_features import build_finger_features
from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.finger_shape import FingerShape, Rectangle
from wholearm_ros.model.polygon import edge_table
from wholearm_ros.model.scenario import Scenario

__all__ = ['World', 'build_world']

LENGTH_PER_RADIAN = (
    2.0 / 3.0
)  # of a finger: the length that counts as much as 1 rad where configurations are compared


def build_world(scenario: Scenario) -> World:
    """The arrays of a scenario."""
    body, hand, pull = scenario.object, scenario.hand, scenario.gravity.pull
    both = (hand.left, hand.right)
    length = round(LENGTH_PER_RADIAN * 0.5 * sum(f.shape.length for f in both), 12)
    return World(
        obj=readonly(edge_table(body.polygon.vertices_about_centroid, closed=True)),
        palm=readonly(edge_table(scenario.palm.vertices, closed=False)),
        fingers=readonly([(*f.axis, f.shape.length, _reach(f.shape)) for f in both]),
        features=build_finger_features(hand),
        rectangles=readonly([_sides(f.shape) for f in both]),
        corners=readonly(_touchable_corners(scenario.palm.vertices), dtype=np.int64),
        scale=readonly([length, length, 1.0, 1.0, 1.0]),
        limits=readonly([f.angle_limits for f in both]),
        load=readonly([*(0.0 - body.mass * pull), 0.0, 0.0, 0.0]),
        finger_weights=scenario.finger_weights,
        inertias=readonly([body.mass, body.mass, body.inertia, both[0].inertia, both[1].inertia]),
        torque_limits=readonly([f.torque_limit for f in both]),
        joint_friction=readonly([f.joint_friction for f in both]),
        leaning=float(np.tan(scenario.gravity.turn)),
    )


def _reach(shape: FingerShape) -> float:
    """How far from the axis it is at most, and a little more [m]."""
    return max(float(np.abs(part).sum(axis=1).max()) for part in shape.parts)


def _sides(shape: FingerShape) -> tuple[float, float]:
    """Length and half width of a rectangle [m]."""
    return (shape.length, shape.half_width) if isinstance(shape, Rectangle) else (0.0, 0.0)


def _touchable_corners(palm: np.ndarray) -> list[int]:
    """Both ends, and the vertices that bulge to the free side."""
    d = np.diff(palm, axis=0)
    turn = d[:-1, 0] * d[1:, 1] - d[:-1, 1] * d[1:, 0]
    return [0, *(int(k) + 1 for k in np.flatnonzero(turn < -1e-12)), len(palm) - 1]
