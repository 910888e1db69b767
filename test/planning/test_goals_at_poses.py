"""Goals given as poses are planned like any other: a turn, a slide, a slide and a turn, either way round."""

from dataclasses import replace

import numpy as np
import pytest
from problems import ASYMMETRIC, beliefs

from wholearm_ros.mechanics.contacts import pose_on_palm, start_configuration
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.scenario import GoalAtPose
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.planning.problem import build_problem
from wholearm_ros.planning.routes import SearchOptions, plan
from wholearm_ros.search.state_routes import StateRoutes

TOLERANCE = [0.01, 0.005, 0.03]
WORLD, START = build_world(ASYMMETRIC), start_configuration(ASYMMETRIC)


def moved(slide=0.0, turn=0.0):
    """The shipped hexagon, to be moved along the palm and turned on it."""
    pose = pose_on_palm(WORLD, START[0] + slide, START[2] + turn)
    return replace(ASYMMETRIC, goal=GoalAtPose(pose, TOLERANCE), name=f'{slide} m, {turn} rad')


@pytest.mark.parametrize('slide, turn', [(0.01, 0.0), (0.023, 0.302)])
def test_a_route_ends_at_the_pose_and_survives(slide, turn):
    scenario = moved(slide, turn)
    found = plan_and_verify(scenario, PlanRequest(samples=2, moves=300))
    assert found.trajectory is not None, found.plan.reason
    error = found.plan.object_path()[-1] - scenario.goal.pose
    assert (np.abs(error) <= 0.5 * np.array(TOLERANCE)).all()


def test_a_route_does_not_stop_at_the_first_sample_within_tolerance():
    """It goes on to where it comes nearest: a run must have room for its own error."""
    found = plan(moved(0.02))
    assert found.found and abs(found.object_path()[-1, 0] - (START[0] + 0.02)) < 1e-4


@pytest.mark.parametrize('slide, turn', [(0.01, 0.0), (0.0, 0.2), (-0.01, 0.0), (0.0, -0.1)])
def test_a_tree_of_primitives_needs_no_edge_between_start_and_goal(slide, turn):
    """It is looked for, and found or not; without a stable edge on the way there is no cage to aim at."""
    scenario = moved(slide, turn)
    assert not build_problem(scenario if turn >= 0.0 else scenario.mirrored()).cages
    answer = StateRoutes(scenario, SearchOptions(move_limit=60), beliefs).next_plan()
    assert answer.found or 'no sequence of arcs and dynamic primitives' in answer.reason
