"""A scenario: the object, the hand, gravity, the start and the goal."""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.hand import Hand, Palm
from wholearm_ros.model.polygon import Polygon

CCW, CW = 'ccw', 'cw'


@dataclass(frozen=True)
class ManipulatedObject:
    """A uniform, frictionless, rigid polygon. mass [kg]."""

    polygon: Polygon
    mass: float

    @property
    def inertia(self) -> float:
        """About the centroid [kg m²]."""
        return self.mass * self.polygon.radius_of_gyration_squared()


@dataclass(frozen=True)
class Gravity:
    """acceleration [m/s²], tilt [rad] of the support plane from the vertical; turn [rad]: of its
    direction in the plane from -y, counter-clockwise.
    """

    acceleration: float
    tilt: float
    turn: float = 0.0

    @property
    def in_plane(self) -> float:
        """Acceleration along the support plane [m/s²]."""
        return self.acceleration * float(np.cos(self.tilt))

    @property
    def pull(self) -> np.ndarray:
        """(2,) [m/s²], the acceleration in the plane."""
        return self.in_plane * np.array([np.sin(self.turn), -np.cos(self.turn)])

    def mirrored(self) -> 'Gravity':
        """The mirror image (x → -x)."""
        return Gravity(self.acceleration, self.tilt, -self.turn)


@dataclass(frozen=True)
class StartOnEdge:
    """At rest on `edge`, the centroid at `x` [m], both fingers closed on the object.

    felt: whether the hand has to feel first where the object lies; edge and x are then not for it
    to know, only where a simulated hand has the object.
    """

    edge: int
    x: float
    felt: bool = False

    def mirrored(self, edges: int) -> 'StartOnEdge':
        """The mirror image (x → -x), for an object with that many edges."""
        return StartOnEdge(edges - 1 - self.edge, -self.x, self.felt)


@dataclass(frozen=True, eq=False)
class StartAtPose:
    """pose: (3,) centroid x, y [m] and rotation [rad]; fingers: (2,) joint angles [rad]."""

    pose: np.ndarray
    fingers: np.ndarray

    def __post_init__(self) -> None:
        object.__setattr__(self, 'pose', readonly(self.pose, (3,)))
        object.__setattr__(self, 'fingers', readonly(self.fingers, (2,)))

    def mirrored(self, edges: int) -> 'StartAtPose':
        """The mirror image (x → -x), whatever the number of edges."""
        return StartAtPose(self.pose * [-1.0, 1.0, -1.0], np.pi - self.fingers[::-1])


@dataclass(frozen=True)
class GoalOnEdge:
    """At rest on `edge`, with the centroid within x ± x_tolerance [m] where x is given.

    direction: CCW or CW in which to turn, by a whole turn for the edge of the start; None for
    either, and then the edge of the start needs no turn.
    """

    edge: int
    direction: str | None = None
    x: float | None = None
    x_tolerance: float | None = None

    def mirrored(self, edges: int) -> 'GoalOnEdge':
        """The mirror image (x → -x), for an object with that many edges."""
        x = None if self.x is None else -self.x
        direction = None if self.direction is None else CCW if self.direction == CW else CW
        return GoalOnEdge(edges - 1 - self.edge, direction, x, self.x_tolerance)


@dataclass(frozen=True, eq=False)
class GoalAtPose:
    """pose: (3,) centroid x, y [m] and rotation, not wrapped [rad]; tolerance: (3,) likewise."""

    pose: np.ndarray
    tolerance: np.ndarray

    def __post_init__(self) -> None:
        object.__setattr__(self, 'pose', readonly(self.pose, (3,)))
        object.__setattr__(self, 'tolerance', readonly(self.tolerance, (3,)))

    def mirrored(self, edges: int) -> 'GoalAtPose':
        """The mirror image (x → -x), whatever the number of edges."""
        return GoalAtPose(self.pose * [-1.0, 1.0, -1.0], self.tolerance)


@dataclass(frozen=True)
class Scenario:
    """Everything that a plan depends on."""

    object: ManipulatedObject
    hand: Hand
    palm: Palm
    gravity: Gravity
    start: StartOnEdge | StartAtPose
    goal: GoalOnEdge | GoalAtPose
    name: str = ''

    @property
    def finger_weights(self) -> np.ndarray:
        """(2, 2) [N m], a row a finger, left then right: m g times how far its centre of mass is
        from the axis along and across it; m g L / 2 and 0 of a rectangle. See `bearing_torques`.
        """
        g, fingers = -float(self.gravity.pull[1]), (self.hand.left, self.hand.right)
        return readonly([f.mass * g * f.shape.centre for f in fingers])

    @property
    def to_be_felt(self) -> bool:
        """Whether nobody knows yet where the object lies."""
        return isinstance(self.start, StartOnEdge) and self.start.felt

    def mirrored(self) -> 'Scenario':
        """The mirror image (x → -x): left and right change places, and so do the directions."""
        edges = len(self.object.polygon.vertices)
        return Scenario(
            ManipulatedObject(self.object.polygon.mirrored(), self.object.mass),
            self.hand.mirrored(),
            self.palm.mirrored(),
            self.gravity.mirrored(),
            self.start.mirrored(edges),
            self.goal.mirrored(edges),
            self.name,
        )
