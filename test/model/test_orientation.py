"""Start and goal rotations: the smallest turn in the asked direction, mirrored tasks mirrored."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wholearm_ros.model.goal import goal_region
from wholearm_ros.model.orientation import directed, goal_rotation, start_rotation
from wholearm_ros.model.scenario import GoalOnEdge, ManipulatedObject, StartOnEdge
from wholearm_ros.model.scenario_file import load_scenario

CONFIG = Path(__file__).parents[2] / 'config'
SCENARIO = load_scenario(CONFIG / 'asymmetric_hexagon.yaml')


def test_turn_of_the_shipped_scenarios():
    assert np.degrees(goal_rotation(SCENARIO) - start_rotation(SCENARIO)) == pytest.approx(
        64.3119, abs=1e-3
    )
    regular = load_scenario(CONFIG / 'regular_hexagon.yaml')
    assert np.degrees(goal_rotation(regular) - start_rotation(regular)) == pytest.approx(
        60.0, abs=1e-5
    )


@pytest.mark.parametrize('edge', range(6))
@pytest.mark.parametrize('start', range(6))
def test_both_directions_together_make_a_full_turn_and_the_goal_edge_lies_down(start, edge):
    scenario = replace(SCENARIO, start=StartOnEdge(start, 0.0))
    turned = {
        d: goal_rotation(replace(scenario, goal=GoalOnEdge(edge, d))) - start_rotation(scenario)
        for d in ('ccw', 'cw')
    }
    full = 2 * np.pi + 1e-12
    assert 0.0 < turned['ccw'] <= full and -full <= turned['cw'] < 0.0
    if start != edge:
        assert turned['ccw'] - turned['cw'] == pytest.approx(2 * np.pi)
    rotation = start_rotation(scenario) + turned['ccw']
    dx, dy = scenario.object.polygon.edges[edge]
    assert np.sin(rotation) * dx + np.cos(rotation) * dy == pytest.approx(0.0, abs=1e-12)


def test_a_mirrored_task_turns_the_other_way_by_as_much():
    n = len(SCENARIO.object.polygon.vertices)
    mirrored = replace(
        SCENARIO,
        object=ManipulatedObject(SCENARIO.object.polygon.mirrored(), 1.0),
        start=StartOnEdge(n - 1, 0.02),
        goal=GoalOnEdge(n - 1 - 5, 'cw'),
    )
    assert goal_rotation(mirrored) - start_rotation(mirrored) == pytest.approx(
        -(goal_rotation(SCENARIO) - start_rotation(SCENARIO))
    )


@pytest.mark.parametrize('edge', range(6))
def test_a_goal_without_a_direction_takes_the_shorter_turn_and_forgives_whole_ones(edge):
    scenario = replace(SCENARIO, goal=GoalOnEdge(edge))
    turn = goal_rotation(scenario) - start_rotation(scenario)
    both = directed(scenario)
    if edge == SCENARIO.start.edge:
        assert turn == 0.0 and both == (scenario,)
    else:
        turns = [goal_rotation(s) - start_rotation(s) for s in both]
        assert turns[0] == pytest.approx(turn) and abs(turn) <= np.pi
        assert turns[0] - turns[1] == pytest.approx(np.copysign(2 * np.pi, turn))
    region = goal_region(scenario)
    for whole_turns in (-1, 0, 1):
        pose = np.array([0.0, 0.0, goal_rotation(scenario) + 2 * np.pi * whole_turns])
        assert region.error(pose)[2] == pytest.approx(0.0, abs=1e-12)
