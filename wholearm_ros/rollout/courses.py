"""Courses: both fingers' angles over time in rollouts of objects that feel alike on several edges,
of those that reach the goal and of those that end elsewhere (`estimation/course.py` says what for).
"""

from collections.abc import Sequence

import numpy as np

from wholearm_ros.control.execution import COURSE_PERIOD
from wholearm_ros.model.configuration import JOINTS, ROTATION
from wholearm_ros.model.goal import goal_region
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.rollout.perturbed_samples import RECORD_EVERY
from wholearm_ros.rollout.verification import Rollout

MOST = 50  # of either kind that a plan holds
DIGITS = 3  # of an angle [rad]: a document shall be short
ASTRAY = 0.2  # [rad] from the goal: the object lies on another edge, or on none


def build_courses(
    scenario: Scenario, rollouts: Sequence[Rollout]
) -> tuple[np.ndarray | None, np.ndarray | None]:
    """(k, r, 2) of rollouts that reached the goal and (s, r, 2) of those that ended elsewhere [rad]
    every COURSE_PERIOD from the trajectory's start; None and None when none reached the goal.
    """
    arrived = [r for r in rollouts if r.success]
    if not arrived:
        return None, None
    rows = min(len(r.times) for r in arrived) - 1
    strayed = [r for r in rollouts if len(r.times) >= rows and has_strayed(scenario, r)]
    return _angles(arrived, rows), _angles(strayed, rows)


def has_strayed(scenario: Scenario, rollout: Rollout) -> bool:
    """Whether it ended on another edge than the goal's, or on none."""
    off = rollout.configurations[-1, ROTATION] - goal_region(scenario).rotation
    return bool(abs(off) > ASTRAY)


def _angles(rollouts: Sequence[Rollout], rows: int) -> np.ndarray:
    """Of as many as a plan holds, from the first to the last."""
    every = round(COURSE_PERIOD / RECORD_EVERY)
    chosen = np.unique(np.linspace(0, len(rollouts) - 1, MOST).round().astype(int))
    angles = [rollouts[k].configurations[:rows:every, JOINTS] for k in chosen if rollouts]
    return np.array(angles).reshape(len(angles), -(-rows // every), 2).round(DIGITS)
