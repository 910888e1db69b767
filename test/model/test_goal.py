"""One judge of a goal: every coordinate that it names, within its tolerance, less the margin asked for."""

from dataclasses import replace

import numpy as np
import pytest
from problems import ASYMMETRIC, ON_BENT_PALM, REGULAR

from wholearm_ros.mechanics.contacts import pose_on_palm
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.goal import ANGLE_TOLERANCE, HEIGHT_TOLERANCE, goal_region
from wholearm_ros.model.orientation import goal_rotation, palm_segment_under
from wholearm_ros.model.scenario import GoalAtPose, GoalOnEdge


def lying(scenario, x=0.0, turn=0.0):
    """(3,) the object on the palm with its centroid at x, turned by `turn` from the goal's rotation."""
    segment = palm_segment_under(scenario.palm, x)
    return pose_on_palm(build_world(scenario), x, goal_rotation(scenario) + turn, segment)


@pytest.mark.parametrize('scenario', [ASYMMETRIC, REGULAR, ON_BENT_PALM, ASYMMETRIC.mirrored()])
@pytest.mark.parametrize('share', [-1.01, -0.99, 0.99, 1.01])
def test_on_an_edge_rotation_and_height_count_up_to_their_tolerances(scenario, share):
    goal = goal_region(scenario)
    turned = lying(scenario, turn=share * ANGLE_TOLERANCE)
    lifted = lying(scenario) + [0.0, share * HEIGHT_TOLERANCE, 0.0]
    for pose in (turned, lifted):
        assert goal.reached(pose) == (abs(share) < 1.0) == (goal.missing(pose) == [])
    assert goal.reached(lying(scenario, x=0.02)), 'no x is named'


@pytest.mark.parametrize('k, name', enumerate(['x', 'y', 'rotation']))
def test_at_a_pose_every_coordinate_counts(k, name):
    pose, tolerance = lying(ASYMMETRIC), np.array([0.01, 0.004, 0.02])
    goal = goal_region(replace(ASYMMETRIC, goal=GoalAtPose(pose, tolerance)))
    for share, margin in ((0.99, 0.0), (0.49, 0.5)):
        assert goal.reached(pose + share * tolerance * np.eye(3)[k], margin)
        missed = pose + (share + 0.02) * tolerance * np.eye(3)[k]
        assert not goal.reached(missed, margin) and goal.missing(missed, margin)[0].startswith(name)
    assert goal.distance(pose + 0.3 * tolerance) == pytest.approx(0.3)


def test_a_margin_may_differ_from_coordinate_to_coordinate():
    goal = goal_region(replace(ASYMMETRIC, goal=GoalOnEdge(5, 'ccw', x=0.0, x_tolerance=0.01)))
    pose = lying(ASYMMETRIC, x=0.006)
    assert goal.reached(pose) and not goal.reached(pose, 0.5)
    assert goal.reached(pose, np.array([0.0, 0.5, 0.5]))


@pytest.mark.parametrize('goal', [GoalOnEdge(5, 'ccw'), GoalOnEdge(5, 'ccw', x=0.01)])
def test_steps_that_are_ruled_out_do_not_pass_through_the_goal(goal):
    """Against looking at many poses between every two, over random paths on the palm."""
    scenario, rng = replace(ASYMMETRIC, goal=goal), np.random.default_rng(0)
    region = goal_region(scenario)
    path = np.array(
        [lying(scenario, x, turn) for x, turn in rng.uniform(-0.06, 0.06, size=(60, 2))]
    )
    near = set(region.near_steps(path).tolist())
    for i, (a, b) in enumerate(zip(path[:-1], path[1:], strict=True)):
        inside = any(region.reached((1 - u) * a + u * b) for u in np.linspace(0.0, 1.0, 30))
        assert i in near or not inside
    assert len(near) < 59
