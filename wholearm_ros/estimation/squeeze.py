"""Squeezes: the finger angles of an object that lies on an edge between a held finger and one that
closes.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from wholearm_ros.kernels import squeezing
from wholearm_ros.mechanics.contacts import pose_on_palm
from wholearm_ros.mechanics.world import World, build_world
from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.convex import turns
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario import ManipulatedObject, Scenario

VERTEX_STEP = 2e-4  # [m] over which the derivatives with respect to vertices are differenced
TIP_MARGIN = 0.005  # [m] of a finger's tip by which an object must not be met alone
ANGLE_STEP = 1e-4  # [rad] the same of the held finger's angle


@dataclass(frozen=True, eq=False)
class Resting:
    """A way in which the object may lie: on its `edge`, upon the palm's `segment`.

    pose (3,): centroid [m] and rotation [rad] with the centroid above the segment's middle; along
    (2,): direction in which it slides; reach [m]: how far the centroid may slide to either side and
    still be over the segment; height [m]: of the centroid above it.
    """

    edge: int
    segment: int
    pose: np.ndarray
    along: np.ndarray
    reach: float
    height: float

    def pose_at(self, slide: float) -> np.ndarray:
        """(3,) the pose after a slide [m]."""
        return np.array([*(self.pose[:2] + slide * self.along), self.pose[2]])


@dataclass(frozen=True, eq=False)
class Prediction:
    """Squeezes of one resting object at k angles of the held finger: slides (k,) [m]; angles (k,)
    [rad] of the closing finger; by_vertices (k, 2n) [rad/m] their derivatives with respect to the
    outline; by_held (k,) with respect to the held angle. NaN where such an object is not met.
    """

    slides: np.ndarray
    angles: np.ndarray
    by_vertices: np.ndarray
    by_held: np.ndarray


class SqueezeModel:
    """The squeezes of a scenario's object, and of outlines near its own."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.world = build_world(scenario)

    def resting(self, edge: int, segment: int = 0) -> Resting:
        """The object on an edge, upon a segment of the palm."""
        return _resting(self.scenario, self.world, edge, segment)

    def squeeze(
        self, resting: Resting, held: int, thetas: ArrayLike
    ) -> tuple[np.ndarray, np.ndarray]:
        """(slides (k,) [m], angles (k,) [rad] of the closing finger) for the held finger's angles
        thetas (k,).
        """
        return _squeeze(self.world, resting, held, thetas)

    def slide(self, resting: Resting, side: int, theta: float) -> float:
        """Slide [m] at which the object touches a finger that stands at `theta`; NaN when it does
        not.
        """
        return float(squeezing.resting_slide(self.world, _slideway(resting), side, theta))

    def predict(self, resting: Resting, held: int, thetas: ArrayLike) -> Prediction:
        """`squeeze` with its derivatives."""
        thetas = np.asarray(thetas, float)
        slides, angles = self.squeeze(resting, held, thetas)
        columns = []
        for scenario, world in self._neighbours:
            near = _resting(scenario, world, resting.edge, resting.segment)
            columns.append((_squeeze(world, near, held, thetas)[1] - angles) / VERTEX_STEP)
        ahead = self.squeeze(resting, held, thetas + ANGLE_STEP)[1]
        return Prediction(slides, angles, np.column_stack(columns), (ahead - angles) / ANGLE_STEP)

    def displaced(self, errors: np.ndarray) -> 'SqueezeModel | None':
        """Of the object with its vertices moved by errors (2n,) [m]; None when that outline is not
        convex.
        """
        scenario = _displaced(self.scenario, errors)
        convex = (turns(scenario.object.polygon.vertices) > 0.0).all()
        return SqueezeModel(scenario) if convex else None

    @cached_property
    def shortened(self) -> 'SqueezeModel':
        """In a hand whose fingers are shorter by TIP_MARGIN: what it does not meet, fingers of the
        true length may pass over.
        """
        hand = self.scenario.hand
        left, right = (
            replace(finger, shape=finger.shape.shortened(TIP_MARGIN))
            for finger in (hand.left, hand.right)
        )
        return SqueezeModel(replace(self.scenario, hand=replace(hand, left=left, right=right)))

    @cached_property
    def _neighbours(self) -> list[tuple[Scenario, World]]:
        """(scenario, world) with one coordinate of one vertex moved by VERTEX_STEP."""
        steps = VERTEX_STEP * np.eye(self.scenario.object.polygon.vertices.size)
        moved = [_displaced(self.scenario, step) for step in steps]
        return [(scenario, build_world(scenario)) for scenario in moved]


def _displaced(scenario: Scenario, errors: np.ndarray) -> Scenario:
    vertices = scenario.object.polygon.vertices
    outline = Polygon(vertices + errors.reshape(vertices.shape))
    return replace(scenario, object=ManipulatedObject(outline, scenario.object.mass))


def _resting(scenario: Scenario, world: World, edge: int, segment: int) -> Resting:
    ends = scenario.palm.vertices[segment : segment + 2]
    length = float(np.linalg.norm(ends[1] - ends[0]))
    along = (ends[1] - ends[0]) / length
    angle = scenario.object.polygon.resting_angle(edge) + float(np.arctan2(along[1], along[0]))
    pose = pose_on_palm(world, float(ends[:, 0].mean()), angle, segment)
    height = float(np.array([-along[1], along[0]]) @ (pose[:2] - ends[0]))
    return Resting(edge, segment, readonly(pose, (3,)), readonly(along, (2,)), length / 2, height)


def _squeeze(
    world: World, resting: Resting, held: int, thetas: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    thetas = np.ascontiguousarray(thetas, float)
    slides, angles = np.empty(len(thetas)), np.empty(len(thetas))
    squeezing.squeeze(world, _slideway(resting), held, thetas, slides, angles)
    return slides, angles


def _slideway(resting: Resting) -> squeezing.Slideway:
    return squeezing.Slideway(resting.pose, resting.along, resting.reach)
