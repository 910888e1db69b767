"""The hand: two one-joint fingers and the fixed palm between them."""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.finger_shape import FingerShape

LEFT, RIGHT = 0, 1
SIDES = ('left', 'right')
JOINT_NAMES = ('left_finger_joint', 'right_finger_joint')
CLOSING = -1.0, 1.0  # sign of a joint velocity or torque that moves a finger towards the other one


@dataclass(frozen=True, eq=False)
class Finger:
    """A finger that turns about a fixed axis.

    Its joint angle θ is its direction, counter-clockwise from +x.

    axis: (2,) [m]; shape: in its frame, x along the finger from the axis; mass [kg], uniform;
    rotor_inertia [kg m²] seen at the joint; angle_limits: (2,) [rad]; torque_limit [N m];
    joint_friction [N m]: Coulomb friction about the axis, of which plans know nothing.
    """

    axis: np.ndarray
    shape: FingerShape
    mass: float
    rotor_inertia: float
    angle_limits: np.ndarray
    torque_limit: float
    joint_friction: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, 'axis', readonly(self.axis, (2,)))
        object.__setattr__(self, 'angle_limits', readonly(self.angle_limits, (2,)))

    @property
    def inertia(self) -> float:
        """About the joint axis [kg m²]: uniform shape plus rotor."""
        return self.shape.inertia(self.mass) + self.rotor_inertia

    @property
    def inertia_about_centre(self) -> float:
        """About the centre of mass, rotor included [kg m²]: for engines of free bodies."""
        x, y = self.shape.centre
        return float(self.inertia - self.mass * (x**2 + y**2))

    def mirrored(self) -> 'Finger':
        """The mirror image (x → -x, θ → π - θ)."""
        low, high = self.angle_limits
        return Finger(
            self.axis * [-1.0, 1.0],
            self.shape.mirrored(),
            self.mass,
            self.rotor_inertia,
            np.array([np.pi - high, np.pi - low]),
            self.torque_limit,
            self.joint_friction,
        )


@dataclass(frozen=True)
class Hand:
    """Both fingers; index with LEFT and RIGHT."""

    left: Finger
    right: Finger

    def __getitem__(self, side: int) -> Finger:
        return (self.left, self.right)[side]

    def mirrored(self) -> 'Hand':
        """The mirror image (x → -x): left and right change places."""
        return Hand(self.right.mirrored(), self.left.mirrored())


@dataclass(frozen=True, eq=False)
class Palm:
    """The fixed palm: a polyline whose free side is on its left. vertices: (p, 2) [m]."""

    vertices: np.ndarray

    def __post_init__(self) -> None:
        object.__setattr__(self, 'vertices', readonly(self.vertices, (-1, 2)))

    def mirrored(self) -> 'Palm':
        """The mirror image (x → -x), its free side on its left again."""
        return Palm((self.vertices * [-1.0, 1.0])[::-1])
