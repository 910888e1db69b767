"""Courses of a plan: of rollouts that reached the goal, and of those that ended on another edge."""

from pathlib import Path

import numpy as np
import pytest

from wholearm_ros.model.configuration import ROTATION
from wholearm_ros.model.goal import goal_region
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.rollout.courses import DIGITS, MOST, build_courses
from wholearm_ros.rollout.verification import Rollout

ROWS = 120


@pytest.fixture(scope='module')
def regular():
    return load_scenario(Path(__file__).parents[2] / 'config' / 'regular_hexagon.yaml')


def ended(scenario, off, left, success, rows=ROWS):
    """A rollout that ends `off` [rad] from the goal, with its left finger at an angle."""
    configurations = np.zeros((rows, 5))
    configurations[:, ROTATION] = goal_region(scenario).rotation + off
    configurations[:, 3:] = left, 2.0
    return Rollout(0.02 * np.arange(rows), configurations, success, '', 0.0)


def test_what_arrived_and_what_ended_on_another_edge_are_kept_apart(regular):
    rollouts = [
        ended(regular, 0.0, 1.0, True),
        ended(regular, -np.pi / 3, 1.1, False),
        ended(regular, 0.05, 1.2, False),  # on the goal's edge, only not well enough: of no kind
        ended(regular, -np.pi / 3, 1.3, False, rows=30),  # stopped: that is known without courses
        ended(regular, 0.0, 1.4, True),
    ]
    arrived, strayed = build_courses(regular, rollouts)
    assert arrived.shape[1:] == strayed.shape[1:]
    assert arrived[:, 0, 0].tolist() == [1.0, 1.4] and strayed[:, 0, 0].tolist() == [1.1]


def test_a_plan_holds_some_of_many_from_the_first_to_the_last(regular):
    many = [ended(regular, 0.0, 1.0 + 0.001 * k, True) for k in range(3 * MOST)]
    arrived, strayed = build_courses(regular, many)
    assert len(arrived) == MOST and strayed.shape[0] == 0
    assert arrived[0, 0, 0] == 1.0
    assert arrived[-1, 0, 0] == pytest.approx(1.0 + 0.001 * (3 * MOST - 1), abs=10.0**-DIGITS)


def test_there_are_no_courses_when_none_arrived(regular):
    assert build_courses(regular, [ended(regular, -1.0, 1.0, False)]) == (None, None)
