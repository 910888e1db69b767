"""Fifth-order polynomials, segment durations, τ_min + τ_margin inside its range, and the slew limit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from wholearm_ros.kernels.interpolation import held_within, slew_limited
from wholearm_ros.model.hand import LEFT, RIGHT
from wholearm_ros.model.interpolation import quintic
from wholearm_ros.trajectory.execution_options import ExecutionOptions
from wholearm_ros.trajectory.get_torque import quasi_static_torque
from wholearm_ros.trajectory.timing import (
    PEAK_ACCELERATION,
    PEAK_SPEED,
    SHORTEST,
    segment_duration,
)

U = np.linspace(0.0, 1.0, 20_001)
TORQUES = arrays(float, st.integers(1, 40), elements=st.floats(-7.0, 7.0))


def test_the_quintic_goes_from_rest_to_rest_without_acceleration_at_either_end():
    position, speed = quintic(U)
    acceleration = np.gradient(speed, U)
    np.testing.assert_allclose([position[0], position[-1]], [0.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(
        [speed[0], speed[-1], acceleration[0], acceleration[-1]], 0.0, atol=4e-3
    )
    assert speed[0] == speed[-1] == 0.0 and (np.diff(position) > 0.0).all()


def test_the_speed_of_the_quintic_is_its_derivative_and_the_peaks_are_as_named():
    """15/8 and 10/√3, of the distance over the time and over its square."""
    position, speed = quintic(U)
    np.testing.assert_allclose(np.gradient(position, U)[1:-1], speed[1:-1], atol=1e-6)
    assert speed.max() == pytest.approx(PEAK_SPEED, abs=1e-6)
    assert np.abs(np.gradient(speed, U)).max() == pytest.approx(PEAK_ACCELERATION, rel=1e-4)


@settings(max_examples=50)
@given(st.floats(1e-3, 3.0), st.floats(0.1, 8.0), st.floats(0.2, 5.0), st.floats(1.0, 50.0))
def test_a_segment_takes_the_least_time_that_keeps_every_coordinate_within_its_limits(
    distance, fastest, speed, acceleration
):
    duration = segment_duration(distance, fastest, speed, acceleration)
    d = distance * max(1.0, fastest)
    used = max(
        PEAK_SPEED * d / duration / speed, PEAK_ACCELERATION * d / duration**2 / acceleration
    )
    assert used <= 1.0 + 1e-9
    assert used == pytest.approx(1.0) or duration == SHORTEST
    assert segment_duration(-distance, fastest, speed, acceleration) == duration


@settings(max_examples=50)
@given(TORQUES, st.floats(-7.0, 7.0), st.floats(0.01, 2.0))
def test_a_slew_limited_torque_never_steps_further_than_it_may(torque, start, step):
    out = slew_limited(torque, start, step)
    assert np.abs(np.diff(np.concatenate([[start], out]))).max() <= step + 1e-12


@settings(max_examples=50)
@given(TORQUES, st.floats(0.01, 2.0), st.integers(0, 2**32 - 1))
def test_a_torque_is_held_inside_a_range_that_moves_slowly_and_stays_slew_limited(
    torque, step, seed
):
    slow = np.cumsum(
        np.random.default_rng(seed).uniform(-0.4, 0.4, (2, len(torque))) * step, axis=1
    )
    low, high = slow.min(axis=0) - step, slow.max(axis=0) + step
    out = held_within(slew_limited(torque, torque[0], step), low, high, step)
    assert (low - 1e-12 <= out).all() and (out <= high + 1e-12).all()
    assert np.abs(np.diff(out)).max(initial=0.0) <= step + 1e-12


@settings(max_examples=50)
@given(TORQUES, st.floats(0.01, 2.0))
def test_a_torque_that_is_slow_enough_is_left_alone(torque, step):
    slow = np.cumsum(np.clip(torque, -0.99 * step, 0.99 * step))
    np.testing.assert_allclose(slew_limited(slow, slow[0], step), slow, atol=1e-12)


@settings(max_examples=50)
@given(st.integers(0, 2**32 - 1), st.sampled_from([LEFT, RIGHT]), st.floats(0.0, 4.0))
def test_the_torque_lies_inside_the_range_and_at_most_the_margin_above_its_pressing_end(
    seed, side, margin
):
    """Ranges that move slowly: then the torque is τ_min + min(τ_margin, its share of the width), towards closing."""
    rng = np.random.default_rng(seed)
    middle = 0.5 + np.cumsum(rng.uniform(-0.01, 0.01, 30))
    half = 0.5 + np.cumsum(rng.uniform(-0.01, 0.01, 30))
    sign = -1.0 if side == LEFT else 1.0
    ends = np.sort(sign * np.column_stack([middle - half, middle + half]), axis=1)
    statics = np.column_stack([ends, ends])
    options = ExecutionOptions(torque_margin=margin)
    torque = quasi_static_torque(statics, side, options, 7.0)
    assert (torque >= ends[:, 0] - 1e-12).all() and (torque <= ends[:, 1] + 1e-12).all()
    pressing = sign * torque - (middle - half)
    np.testing.assert_allclose(
        pressing, np.minimum(margin, options.range_fraction * 2 * half), atol=0.05
    )
    mirrored = quasi_static_torque(-statics[:, [1, 0, 3, 2]], 1 - side, options, 7.0)
    np.testing.assert_allclose(mirrored, -torque, atol=1e-12)


def test_the_motor_limit_is_kept_whatever_the_range():
    statics = np.tile([5.0, 9.0, 5.0, 9.0], (10, 1))
    assert (
        quasi_static_torque(statics, RIGHT, ExecutionOptions(torque_margin=3.5), 6.0).max() <= 6.0
    )
