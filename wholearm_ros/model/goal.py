"""The goal region of a scenario: the one judge of whether an object has arrived."""

from dataclasses import dataclass
from typing import Union

import numpy as np

from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.hand import Palm
from wholearm_ros.model.orientation import goal_rotation, palm_segment_under
from wholearm_ros.model.polygon import support
from wholearm_ros.model.scenario import GoalAtPose, Scenario

ANGLE_TOLERANCE = 0.03  # [rad] of an object that shall lie on an edge
X_TOLERANCE = 0.01  # [m] of a goal's x that comes without a tolerance of its own
HEIGHT_TOLERANCE = 0.0015  # [m] between the palm and an object that shall lie on it

Margin = Union[float, np.ndarray]


@dataclass(frozen=True, eq=False)
class GoalRegion:
    """Target pose of the object and the tolerance of each of its coordinates.

    target: (3,) centroid x, y [m] and rotation [rad], NaN where the goal does not name the
    coordinate; tolerance: (3,) in the same units; on_palm: whether the object shall lie on the
    palm, in which case `error` holds its height above the palm in place of y; vertices: (n, 2) [m]
    of the object about its centroid. Where the true object is known, target and vertices are its.
    either_way: whether whole turns do not count, as for a goal without a direction.

    `margin` arguments: the share of all tolerances, or of each one (3,), that must remain unused.
    Planning asks for such a margin; outcomes are judged without.
    """

    target: np.ndarray
    tolerance: np.ndarray
    on_palm: bool
    vertices: np.ndarray
    palm: Palm
    either_way: bool = False

    @property
    def rotation(self) -> float:
        """[rad] at the goal; every goal names it."""
        return float(self.target[2])

    def height(self, pose: np.ndarray) -> float:
        """Height [m] of the object's lowest vertex at `pose` (3,) above the palm's segment under
        its centroid.
        """
        k = palm_segment_under(self.palm, pose[0])
        start, end = self.palm.vertices[k : k + 2]
        dx, dy = end - start
        normal = np.array([-dy, dx]) / np.hypot(dx, dy)
        below = support(self.vertices, pose[2], normal)
        return float(normal @ (pose[:2] - start) + below)

    def error(self, pose: np.ndarray) -> np.ndarray:
        """(3,) error of `pose` (3,): x, y (or height above the palm) [m], rotation [rad]; 0 where
        the goal does not name the coordinate.
        """
        error = self._difference(pose)
        if self.on_palm:
            error[1] = self.height(pose)
        return error

    def missing(self, pose: np.ndarray, margin: Margin = 0.0) -> list[str]:
        """In words, the coordinates of `pose` (3,) outside the region, rotation first."""
        allowed = (1.0 - np.asarray(margin)) * self.tolerance
        error, words = self.error(pose), []
        for k in np.flatnonzero(np.abs(error) > allowed)[::-1]:
            if k == 1 and self.on_palm:
                words.append(
                    f'the object is {1e3 * error[1]:.2f} mm above the palm; '
                    f'allowed: {1e3 * allowed[1]:.3g}'
                )
            else:
                name, unit = ('x', 'y', 'rotation')[k], ('m', 'm', 'rad')[k]
                words.append(f'{name} is off by {error[k]:+.4f} {unit}; allowed: {allowed[k]:.3g}')
        return words

    def reached(self, pose: np.ndarray, margin: Margin = 0.0) -> bool:
        """Whether `pose` (3,) is inside the region, by that margin."""
        allowed = (1.0 - np.asarray(margin)) * self.tolerance
        return bool((np.abs(self.error(pose)) <= allowed).all())

    def near_steps(self, poses: np.ndarray, margin: Margin = 0.0) -> np.ndarray:
        """Indices of the steps between successive poses (m, 3) that may cross the region, judged
        by x and rotation only: a quick filter for long paths.
        """
        error = self._difference(poses)[:, [0, 2]]
        allowed = ((1.0 - np.asarray(margin)) * self.tolerance)[[0, 2]]
        low, high = np.minimum(error[:-1], error[1:]), np.maximum(error[:-1], error[1:])
        return np.flatnonzero(((low <= allowed) & (high >= -allowed)).all(axis=1))

    def _difference(self, poses: np.ndarray) -> np.ndarray:
        """(..., 3) from the target; 0 where the goal does not name the coordinate."""
        difference = np.where(np.isnan(self.target), 0.0, poses - self.target)
        if self.either_way:
            difference[..., 2] -= 2.0 * np.pi * np.round(difference[..., 2] / (2.0 * np.pi))
        return difference

    def distance(self, pose: np.ndarray) -> float:
        """Largest error of `pose` (3,) as a share of its tolerance."""
        return float(np.abs(self.error(pose) / self.tolerance).max())


def goal_region(scenario: Scenario) -> GoalRegion:
    """The goal region of `scenario` for the object that it holds (nominal or true)."""
    goal, polygon, palm = scenario.goal, scenario.object.polygon, scenario.palm
    if isinstance(goal, GoalAtPose):
        target, tolerance, on_palm, either_way = goal.pose, goal.tolerance, False, False
    else:
        x = np.nan if goal.x is None else goal.x
        x_tolerance = X_TOLERANCE if goal.x_tolerance is None else goal.x_tolerance
        target = np.array([x, np.nan, goal_rotation(scenario)])
        tolerance, on_palm = np.array([x_tolerance, HEIGHT_TOLERANCE, ANGLE_TOLERANCE]), True
        either_way = goal.direction is None
    fixed = np.array(target, float)
    fixed.setflags(write=False)
    return GoalRegion(
        fixed, readonly(tolerance, (3,)), on_palm, polygon.vertices_about_centroid, palm, either_way
    )
