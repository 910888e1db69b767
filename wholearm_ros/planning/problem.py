"""The planning problem: a scenario whose object turns counter-clockwise, as arrays, with its start,
its cages and its goal.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from wholearm_ros.kernels.world import World
from wholearm_ros.mechanics.caging import PAST_THE_TOP, Cage, cages_between
from wholearm_ros.mechanics.contacts import (
    closed_pairs,
    closing_angle,
    pose_on_palm,
    start_configuration,
)
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.configuration import JOINTS, POSE, ROTATION
from wholearm_ros.model.goal import ANGLE_TOLERANCE, GoalRegion, Margin, goal_region
from wholearm_ros.model.orientation import (
    palm_angle_under,
    palm_segment_under,
    start_rotation,
    start_x,
)
from wholearm_ros.model.scenario import Scenario

FLAT = 1e-4  # [rad] a rotation this near that of an edge lies on it
# Shares of the goal's tolerances (x, height, rotation) that a plan leaves unused.
MARGIN_ON_EDGE = np.array([0.5, 0.0, 1.0 - FLAT / ANGLE_TOLERANCE])
MARGIN_AT_POSE = 0.5
TOO_FAR = 0.1  # [rad] past the goal's rotation


class Reach(NamedTuple):
    """Bounds of the centroid [m]: far enough from the ends of the palm that the object cannot tip
    over them, and not far above the fingertips.
    """

    left: float
    right: float
    top: float


@dataclass(frozen=True, eq=False)
class PlanningProblem:
    """What every search works on.

    world: arrays of the scenario; start: (5,) configuration [m, rad]; pairs: closed at the start;
    goal: the region to be reached, of whose tolerances a plan leaves `margin` unused; cages: in the
    order in which they are met; cage_intervals: (c, 2) rotations between which the object may be
    released in each [rad]; reach: bounds of the centroid.
    """

    scenario: Scenario
    world: World
    start: np.ndarray
    pairs: tuple[int, ...]
    goal: GoalRegion
    margin: Margin
    cages: tuple[Cage, ...]
    cage_intervals: np.ndarray
    reach: Reach

    def reached(self, pose: np.ndarray) -> bool:
        """Whether the object at `pose` (3,) is where X_goal wants it (NEW_SUBGOAL step 7)."""
        return self.goal.reached(pose, self.margin)

    def distance(self, pose: np.ndarray) -> float:
        """Largest error of `pose` (3,) as a share of the goal's tolerance, rounded to 0.001 so that
        equal errors compare equal.
        """
        return round(self.goal.distance(pose), 3)

    def rotation_left(self, q: np.ndarray) -> float:
        """Rotation [rad] from q (5,) to where gravity alone turns the object on to the goal,
        negative past it; for a goal to which no cage leads, the distance left in scaled coordinates
        [rad].
        """
        if self.caged_goal:
            return float(self.cage_intervals[-1, 0] - q[ROTATION])
        away = self.goal.error(q[POSE]) / self.world.scale[POSE]
        return float(np.abs(away).sum())

    @property
    def caged_goal(self) -> bool:
        """Whether the last cage ends in the goal's rotation."""
        return bool(self.cages) and self.cages[-1].landing >= self.goal.rotation - FLAT

    def hopeless(self, q: np.ndarray) -> bool:
        """Whether q (5,) leads nowhere: out of reach, turned too far, or a finger at an end
        stop.
        """
        limits = self.world.limits
        return bool(
            not self.reach.left <= q[0] <= self.reach.right
            or q[1] > self.reach.top
            or q[ROTATION] > self.goal.rotation + TOO_FAR
            or (q[JOINTS] <= limits[:, 0]).any()
            or (q[JOINTS] >= limits[:, 1]).any()
        )

    def cage_at(self, angle: float) -> Cage | None:
        """The cage in which the object may be released at that rotation [rad], or None."""
        for cage, (low, high) in zip(self.cages, self.cage_intervals):
            if low <= angle <= high:
                return cage
        return None

    def landed(self, q: np.ndarray, cage: Cage) -> np.ndarray | None:
        """(5,) the object at rest on the palm below q (5,), the fingers closed on it; None when
        there is no room for a finger.
        """
        segment = palm_segment_under(self.scenario.palm, q[0])
        pose = pose_on_palm(self.world, q[0], cage.landing, segment)
        angles = [closing_angle(self.world, pose, side) for side in range(2)]
        return None if np.isnan(angles).any() else np.array([*pose, *angles])


def build_problem(scenario: Scenario) -> PlanningProblem:
    """The problem of a counter-clockwise scenario.

    Raises ScenarioError when the fingers cannot touch the object or the start penetrates the hand.
    """
    world = build_world(scenario)
    q = start_configuration(scenario, world)
    goal = goal_region(scenario)
    floor = palm_angle_under(scenario.palm, start_x(scenario))
    cages = cages_between(scenario.object.polygon, start_rotation(scenario), goal.rotation, floor)
    intervals = np.array([(c.top + PAST_THE_TOP, c.landing) for c in cages]).reshape(-1, 2)
    margin = MARGIN_ON_EDGE if goal.on_palm else MARGIN_AT_POSE
    return PlanningProblem(
        scenario, world, q, closed_pairs(world, q), goal, margin, cages, intervals, _reach(world)
    )


def _reach(world: World) -> Reach:
    """A fifth of a finger's length inside the ends of the palm, and as much above the tips of
    upright fingers.
    """
    length, slack = world.fingers[:, 2].max(), 0.2 * world.fingers[:, 2].max()
    top = world.fingers[:, 1].max() + length + slack
    return Reach(float(world.palm[0, 0] + slack), float(world.palm[-1, 0] - slack), float(top))
