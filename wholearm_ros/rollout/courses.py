"""Courses: both fingers' angles over time in rollouts that reach the goal, of objects that feel
alike on several edges (`estimation/course.py` says what for).
"""

from collections.abc import Sequence

import numpy as np

from wholearm_ros.control.execution import COURSE_PERIOD
from wholearm_ros.model.configuration import JOINTS
from wholearm_ros.model.polygon import ALIKE, edges_look_alike
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.rollout.perturbed_samples import RECORD_EVERY
from wholearm_ros.rollout.verification import Rollout

MOST = 50  # that a plan holds
DIGITS = 3  # of an angle [rad]: a document shall be short


def build_courses(scenario: Scenario, rollouts: Sequence[Rollout]) -> np.ndarray | None:
    """(k, r, 2) [rad] every COURSE_PERIOD from the trajectory's start; None of an object whose
    edges feel different, or when no rollout reached the goal.
    """
    survived = [r.configurations[:, JOINTS] for r in rollouts if r.success][:MOST]
    if not survived or not edges_look_alike(scenario.object.polygon, ALIKE):
        return None
    every, rows = round(COURSE_PERIOD / RECORD_EVERY), min(map(len, survived)) - 1
    return np.array([angles[:rows:every] for angles in survived]).round(DIGITS)
