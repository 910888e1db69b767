"""Courses: the distance of a run from the nearest sample that reached the goal."""

import numpy as np

from wholearm_ros.estimation.course import NEAR, SLACK, nearest_course

TIMES = np.linspace(0.0, 3.0, 150)
COURSES = np.array([[[np.sin(t + late), np.cos(t)] for t in TIMES] for late in (0.0, 0.2, 0.4)])


def test_a_course_that_was_gone_before_is_at_no_distance():
    assert nearest_course(COURSES[1], COURSES) == 0.0


def test_a_little_later_is_the_same_way():
    late = np.roll(COURSES[2], SLACK, axis=0)
    late[:SLACK] = late[SLACK]
    assert nearest_course(late, COURSES) < 1e-9


def test_the_largest_difference_at_any_instant_counts():
    course = COURSES[0].copy()
    course[70:80, 1] += 0.2
    assert 0.15 < nearest_course(course, COURSES) <= 0.2


def test_nothing_to_compare_with_and_courses_that_end_early_are_far():
    assert nearest_course(COURSES[0], None) > NEAR
    assert nearest_course(COURSES[0][:50], COURSES) > NEAR
    assert nearest_course(np.empty((0, 2)), COURSES) > NEAR
