"""The monitor of the switch law: a run has deviated when a finger was out of the band for longer than the patience."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wholearm_ros.kernels.switch_law import Course, Outside, watch_band

PATIENCE, DT = 0.1, 0.001
INSIDE = Outside(math.inf, math.inf, 0.0, 0.0)


def course(low, high) -> Course:
    """Only its band, a row every 0.5 s, counts here."""
    rows = np.zeros((2, 2))
    ends, fingers = np.array([1.0]), np.array([0])
    return Course(
        1.0, rows, rows, rows, ends, fingers, 0.5, np.array(low), np.array(high), PATIENCE
    )


BAND = course([[0.0, -1.0], [1.0, -1.0], [1.0, -1.0]], [[0.2, 1.0], [1.2, 1.0], [1.4, 1.0]])


def watched(angles, seconds, start=0.0, before=INSIDE, band=BAND):
    """`Outside` after `seconds` at angles(elapsed) (2,), from `start` [s] along the course on."""
    for k in range(int(round(seconds / DT))):
        t = start + k * DT
        before = watch_band(band, before, t, t, np.array(angles(t)))
    return before


def middle(t):
    return (min(2.0 * t, 1.0) + 0.1, 0.0)


@given(st.floats(-0.099, 0.099), st.floats(-1.0, 1.0))
def test_inside_of_the_band_nothing_is_said(left, right):
    assert watched(lambda t: (middle(t)[0] + left, right), 0.9) == INSIDE


@pytest.mark.parametrize('off', [(0.15, 0.0), (-0.15, 0.0), (0.0, 1.05), (0.0, -1.05)])
def test_longer_outside_than_the_patience_is_a_deviation_with_time_and_residuals(off):
    """How far outside, with its sign: beyond the upper bound positive, below the lower one negative."""
    said = watched(lambda t: (middle(t)[0] + off[0], off[1]), 0.3, start=0.2)
    assert said.deviated == pytest.approx(0.2 + PATIENCE, abs=2 * DT)
    assert (said.left, said.right) == pytest.approx(np.sign(off) * 0.05, abs=1e-9)


def test_shorter_outside_than_the_patience_is_none_however_often():
    """80 ms outside, 20 ms inside, over and over."""
    assert (
        watched(lambda t: (middle(t)[0], 2.0 if t % 0.1 < 0.08 else 0.0), 0.9).deviated == math.inf
    )


def test_the_first_deviation_stays():
    first = watched(lambda t: (2.0, 0.0), 0.3)
    assert watched(middle, 0.3, start=0.3, before=first)[1:] == first[1:]
    again = watched(lambda t: (0.0, 2.0), 0.3, start=0.3, before=first)
    assert again[1:] == first[1:]


def test_before_and_after_the_band_and_without_one_everything_is_inside():
    assert watched(lambda t: (9.0, 9.0), 0.3, start=-0.3) == INSIDE
    assert watched(lambda t: (9.0, 9.0), 0.3, start=1.01) == INSIDE
    none = course(np.empty((0, 2)), np.empty((0, 2)))
    assert watched(lambda t: (9.0, 9.0), 0.3, band=none) == INSIDE
