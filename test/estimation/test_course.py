"""Courses: the distance of a run from the nearest sample that reached the goal, and which kind of
samples it is like.
"""

import numpy as np
import pytest

from wholearm_ros.estimation.course import (
    LIKE,
    NEAR,
    NEAR_ALONE,
    SLACK,
    likeness,
    nearest_course,
    went_as_planned,
)

TIMES = np.linspace(0.0, 3.0, 150)
COURSES = np.array([[[np.sin(t + late), np.cos(t)] for t in TIMES] for late in (0.0, 0.2, 0.4)])
FALLING = slice(100, 115)  # rows in which the two kinds of samples differ


def samples(rng, apart, count=12):
    """One way with errors of the start, shared by all of its rows, and with `apart` [rad] more of
    the right finger while the object falls."""
    courses = COURSES[0] + rng.normal(0.0, 0.01, (count, 1, 2))
    courses[:, FALLING, 1] += apart
    return courses + rng.normal(0.0, 0.0005, courses.shape)


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


def test_likeness_is_one_at_the_mean_of_one_kind_and_minus_one_at_that_of_the_other():
    rng = np.random.default_rng(1)
    arrived, strayed = samples(rng, 0.01), samples(rng, 0.0)
    mean, other = arrived.mean(axis=0), strayed.mean(axis=0)
    assert likeness(mean, arrived, strayed) == pytest.approx(1.0)
    assert likeness(other, arrived, strayed) == pytest.approx(-1.0)
    assert likeness((mean + other) / 2, arrived, strayed) == pytest.approx(0.0, abs=1e-9)


def test_a_short_difference_tells_where_shared_errors_are_larger():
    rng = np.random.default_rng(2)
    arrived, strayed = samples(rng, 0.01), samples(rng, 0.0)
    for course in samples(rng, 0.01):
        assert went_as_planned(course, arrived, strayed)
    for course in samples(rng, 0.0):
        assert nearest_course(course, arrived) < NEAR  # by itself this would be taken for arriving
        assert not went_as_planned(course, arrived, strayed)


def test_what_is_far_from_all_samples_did_not_go_as_planned_whichever_it_is_like():
    rng = np.random.default_rng(3)
    arrived, strayed = samples(rng, 0.01), samples(rng, 0.0)
    course = arrived.mean(axis=0)
    course[FALLING, 1] += 0.2
    assert likeness(course, arrived, strayed) > LIKE
    assert not went_as_planned(course, arrived, strayed)


def test_a_run_that_is_like_those_that_arrive_may_be_farther_off_than_one_that_nothing_else_tells():
    rng = np.random.default_rng(4)
    arrived, strayed = samples(rng, 0.01), samples(rng, 0.0)
    course = arrived[0] + (NEAR_ALONE + NEAR) / 2
    assert nearest_course(course, arrived) > NEAR_ALONE
    assert went_as_planned(course, arrived, strayed)


def test_where_none_strayed_the_distance_decides_and_where_nobody_looked_nothing_is_told():
    nothing = np.empty((0, 0, 2))
    between = COURSES[1] + (NEAR_ALONE + NEAR) / 2
    assert went_as_planned(COURSES[1], COURSES, nothing)
    assert not went_as_planned(between, COURSES, nothing)
    assert not went_as_planned(COURSES[1], COURSES, None)
    assert not went_as_planned(COURSES[1], None, None)
    assert not went_as_planned(COURSES[1][:50], COURSES, nothing)
