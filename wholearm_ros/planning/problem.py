"""What a search works on: a scenario whose object turns counter-clockwise, as arrays, with its start, cages and goal."""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.kernels import geometry
from wholearm_ros.mechanics.caging import PAST_THE_TOP, Cage, cages_between
from wholearm_ros.mechanics.contacts import closed_pairs, pose_on_palm, start_configuration
from wholearm_ros.mechanics.world import World, build_world
from wholearm_ros.model.orientation import (
    goal_rotation,
    palm_angle_under,
    palm_segment_under,
    start_rotation,
    start_x,
)
from wholearm_ros.model.scenario import GoalAtPose, Scenario

RESTING = 1e-4  # [rad] a rotation this near a landing lies on its edge


@dataclass(frozen=True, eq=False)
class PlanningProblem:
    """start: (5,) configuration; pairs: closed at the start; goal_angle [rad]; goal_x: (low, high) [m] of the centroid;
    cages: in the order in which they are met; cage_intervals: (c, 2) rotations at which the object may be let go.
    """

    scenario: Scenario
    world: World
    start: np.ndarray
    pairs: tuple
    goal_angle: float
    angle_tolerance: float
    goal_x: tuple
    cages: tuple
    cage_intervals: np.ndarray

    def reached(self, pose: np.ndarray) -> bool:
        """Whether the object at `pose` (3,) is where X_goal wants it (NEW_SUBGOAL step 7)."""
        return (
            abs(pose[2] - self.goal_angle) <= self.angle_tolerance
            and self.goal_x[0] <= pose[0] <= self.goal_x[1]
        )

    def cage_at(self, angle: float) -> Cage:
        """The cage in which the object at that rotation may be let go, or None."""
        for cage, (low, high) in zip(self.cages, self.cage_intervals):
            if low <= angle <= high:
                return cage
        return None

    def landed(self, q: np.ndarray, cage: Cage) -> np.ndarray:
        """q (5,) with the object come to rest below where it is, the fingers closed on it; None when there is no room."""
        segment = palm_segment_under(self.scenario.palm, q[0])
        pose = pose_on_palm(self.world, q[0], cage.landing, segment)
        w = self.world
        angles = [
            geometry.closing_angle(w.obj, w.fingers, w.limits, side, *pose) for side in range(2)
        ]
        return None if np.isnan(angles).any() else np.array([*pose, *angles])


def build_problem(scenario: Scenario) -> PlanningProblem:
    """The task of a counter-clockwise scenario.

    Raises ScenarioError when the fingers cannot touch the object or the start penetrates the hand.
    """
    world = build_world(scenario)
    q = start_configuration(scenario, world)
    goal = goal_rotation(scenario)
    floor = palm_angle_under(scenario.palm, start_x(scenario))
    cages = cages_between(scenario.object.polygon, start_rotation(scenario), goal, floor)
    intervals = np.array([(c.top + PAST_THE_TOP, c.landing) for c in cages]).reshape(-1, 2)
    low, high, tolerance = _goal_box(scenario)
    return PlanningProblem(
        scenario, world, q, closed_pairs(world, q), goal, tolerance, (low, high), cages, intervals
    )


def _goal_box(scenario):
    goal = scenario.goal
    if isinstance(goal, GoalAtPose):
        return (
            goal.pose[0] - goal.tolerance[0],
            goal.pose[0] + goal.tolerance[0],
            float(goal.tolerance[2]),
        )
    if goal.x is None:
        return -np.inf, np.inf, RESTING
    tolerance = 0.005 if goal.x_tolerance is None else goal.x_tolerance
    return goal.x - tolerance, goal.x + tolerance, RESTING
