"""One execution on the stamps of the joint states: stopped before its first step, of stale states, and its clock."""

import numpy as np
import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from wholearm_ros.control.setpoints import ControlOptions, Joints
from wholearm_ros.model.hand import LEFT
from wholearm_ros.model.modes import QUASI_STATIC, STOPPED
from wholearm_ros.model.trajectory import ManipulationTrajectory, Segment
from wholearm_ros.ros.node.execution import StampedExecution
from wholearm_ros.ros.node.stamp_age import SLOWEST, StampAge

MILLISECOND = 1_000_000
FIRST = 5_000_000_000  # [ns]


def execution(options: ControlOptions = ControlOptions()) -> StampedExecution:
    flat = np.zeros((101, 2))
    segments = (Segment(0.0, 1.0, QUASI_STATIC, LEFT),)
    trajectory = ManipulationTrajectory(
        'plan', 0.01, flat, flat, flat, np.full((101, 2), np.nan), np.zeros((101, 3)), segments
    )
    return StampedExecution(trajectory, options, 0.5)


def joints(stamp: int) -> Joints:
    return Joints(stamp / 1e9, np.zeros(2), np.zeros(2), np.zeros(2))


def test_a_stop_before_the_first_step_stays():
    run = execution()
    run.stop(joints(FIRST), 'asked to')
    for k in range(5):
        run.step_at(FIRST + k * MILLISECOND, joints(FIRST))
        assert run.mode == STOPPED and run.reason == 'asked to'


def test_stale_joint_states_stop_the_run():
    run, allowed = execution(), ControlOptions().stale_after
    run.step_at(FIRST, joints(FIRST), 0.5 * allowed)
    assert run.mode == QUASI_STATIC
    run.step_at(FIRST + MILLISECOND, joints(FIRST), 2 * allowed)
    assert run.mode == STOPPED and 'joint states are 0.200 s old' in run.reason


@pytest.mark.parametrize('ramp', [0.3, 1.2])
def test_the_trajectory_starts_a_ramp_after_the_first_state(ramp):
    run = execution(ControlOptions(ramp=ramp))
    assert run.trajectory_start is None
    run.step_at(FIRST, joints(FIRST))
    assert run.trajectory_start == FIRST + round(ramp * 1e9)


@pytest.mark.parametrize('offset', [0, 10**18, -(10**15)])
def test_age_is_that_beside_the_freshest_message_whatever_the_senders_clock(offset):
    age = StampAge()
    for k in range(1000):
        assert age(FIRST + k * MILLISECOND + offset, FIRST + k * MILLISECOND) == 0.0
    old, now = FIRST + 800 * MILLISECOND, FIRST + 1000 * MILLISECOND
    assert age(old + offset, now) == pytest.approx(0.2, abs=1e-3)


@pytest.mark.parametrize('speed', [0.6, 0.8, 1.0])
def test_a_sender_slower_than_real_time_is_not_late(speed):
    age = StampAge()
    for k in range(5000):
        assert age(FIRST + k * MILLISECOND, FIRST + round(k * MILLISECOND / speed)) < 1e-6


def test_a_sender_that_lags_for_good_is_no_longer_late():
    age, lag = StampAge(), 500 * MILLISECOND
    age(FIRST, FIRST)
    ages = [
        age(FIRST + k * MILLISECOND, FIRST + k * MILLISECOND + lag)
        for k in range(round(lag / (1.0 - SLOWEST)) // MILLISECOND)
    ]
    assert ages[0] == pytest.approx(0.25) and ages[-1] < 0.001
