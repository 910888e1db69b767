"""The keys of a scenario file and what each may hold, as pydantic models."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Strict, Tag

MAX_VERTICES = 64
MAX_PARTS = 8  # of a finger; a contact pair has room for 252 edges of it
MAX_PART_VERTICES = 24
MAX_LENGTH = 10.0  # [m] no coordinate or size is larger

Number = Annotated[float, Strict(), Field(allow_inf_nan=False)]
Positive = Annotated[float, Strict(), Field(gt=0.0, allow_inf_nan=False)]
Length = Annotated[float, Strict(), Field(gt=0.0, le=MAX_LENGTH, allow_inf_nan=False)]
Coordinate = Annotated[float, Strict(), Field(ge=-MAX_LENGTH, le=MAX_LENGTH, allow_inf_nan=False)]
Mass = Annotated[float, Strict(), Field(gt=0.0, le=100.0, allow_inf_nan=False)]
Angle = Annotated[float, Strict(), Field(ge=-6.2832, le=6.2832, allow_inf_nan=False)]
Edge = Annotated[int, Strict(), Field(ge=0, lt=MAX_VERTICES)]
Point = Annotated[list[Coordinate], Field(min_length=2, max_length=2)]
Pair = Annotated[list[Angle], Field(min_length=2, max_length=2)]
Pose = Annotated[list[Number], Field(min_length=3, max_length=3)]


class _Table(BaseModel):
    model_config = ConfigDict(extra='forbid', frozen=True)


class ObjectTable(_Table):
    """The key `object`."""

    vertices: Annotated[list[Point], Field(min_length=3, max_length=MAX_VERTICES)]
    mass: Mass


Part = Annotated[list[Point], Field(min_length=3, max_length=MAX_PART_VERTICES)]


class FingerTable(_Table):
    """One finger of the key `hand`: a rectangle of length and half width, or vertices of a convex
    polygon, or several such polygons.
    """

    axis: Point
    length: Length | None = None
    half_width: Length | None = None
    vertices: Part | None = None
    parts: Annotated[list[Part], Field(min_length=1, max_length=MAX_PARTS)] | None = None
    mass: Mass
    rotor_inertia: Annotated[float, Strict(), Field(ge=0.0, le=100.0, allow_inf_nan=False)]
    angle_limits: Pair
    torque_limit: Annotated[float, Strict(), Field(gt=0.0, le=1e4, allow_inf_nan=False)]


class HandTable(_Table):
    """The key `hand`."""

    left: FingerTable
    right: FingerTable


class PalmTable(_Table):
    """The key `palm`."""

    vertices: Annotated[list[Point], Field(min_length=2, max_length=MAX_VERTICES)]


class GravityTable(_Table):
    """The key `gravity`."""

    acceleration: Annotated[float, Strict(), Field(gt=0.0, le=1000.0, allow_inf_nan=False)]
    tilt_deg: Annotated[float, Strict(), Field(ge=0.0, lt=90.0, allow_inf_nan=False)]


class StartOnEdgeTable(_Table):
    """The key `start`, on an edge; `felt` alone where nobody knows on which."""

    edge: Edge | None = None
    x: Coordinate | None = None
    felt: Annotated[bool, Strict()] = False


class StartAtPoseTable(_Table):
    """The key `start`, at a pose."""

    pose: Pose
    fingers: Pair


class GoalOnEdgeTable(_Table):
    """The key `goal`, on an edge."""

    edge: Edge | None = None  # that of the start
    direction: Literal['ccw', 'cw'] | None = None  # CCW, CW of scenario.py; the better one
    x: Coordinate | None = None
    x_tolerance: Positive | None = None


class GoalAtPoseTable(_Table):
    """The key `goal`, at a pose."""

    pose: Pose
    tolerance: Annotated[list[Positive], Field(min_length=3, max_length=3)] = [0.01, 0.01, 0.03]


ON_EDGE, AT_POSE = 'on_edge', 'at_pose'


def _kind(value: Any) -> str:
    return AT_POSE if isinstance(value, (dict, BaseModel)) and 'pose' in dict(value) else ON_EDGE


class ScenarioTable(_Table):
    """A scenario file as a whole."""

    name: Annotated[str, Strict(), Field(max_length=200)] = ''
    note: Any = None
    object: ObjectTable
    hand: HandTable
    palm: PalmTable
    gravity: GravityTable
    start: Annotated[
        Annotated[StartOnEdgeTable, Tag(ON_EDGE)] | Annotated[StartAtPoseTable, Tag(AT_POSE)],
        Discriminator(_kind),
    ]
    goal: Annotated[
        Annotated[GoalOnEdgeTable, Tag(ON_EDGE)] | Annotated[GoalAtPoseTable, Tag(AT_POSE)],
        Discriminator(_kind),
    ]
