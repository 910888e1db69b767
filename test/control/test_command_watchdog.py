"""The drives' guard: fresh commands drive, old ones hold, then give zero torque; a stop holds until the reset; whatever is commanded."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip('rclpy')

from wholearm_ros.control.command_watchdog import (
    BRAKE,
    DRIVEN,
    HOLD,
    STOPPED,
    ZERO_TORQUE,
    CommandWatchdog,
)

MS = 1_000_000  # [ns]
LIMITS = [7.0, 5.0]


def guard() -> CommandWatchdog:
    made = CommandWatchdog(LIMITS, timeout=15 * MS, hold_time=500 * MS)
    made.reset(0)
    return made


def driven(now=MS) -> CommandWatchdog:
    made = guard()
    for joint in (0, 1):
        assert made.command(joint, now, 1.0, now)
    assert made.decide(now).tolist() == [1.0, 1.0] and made.state == DRIVEN
    return made


def test_before_the_first_command_the_drives_brake_for_ever():
    made = guard()
    assert (
        all(made.decide(k * MS) is None for k in range(2000))
        and made.state == BRAKE
        and made.trips == 0
    )


def test_the_watchdog_holds_within_16_ms_then_lets_go_and_one_joint_alone_does_not_feed_it():
    made = driven()
    for k in range(2, 17):
        made.command(0, k * MS, 2.0, k * MS)
        assert made.decide(k * MS).tolist() == [2.0, 1.0]
    assert made.decide(17 * MS) is None and made.state == HOLD and made.trips == 1
    assert made.decide(517 * MS) is None
    assert made.decide(518 * MS).tolist() == [0.0, 0.0] and made.state == ZERO_TORQUE
    assert not made.command(0, 518 * MS, 1.0, 518 * MS), 'zero torque is left by a reset only'
    made.reset(600 * MS)
    assert made.decide(600 * MS) is None and made.state == BRAKE


def test_fresh_commands_end_a_hold():
    made = driven()
    assert made.decide(40 * MS) is None
    for joint in (0, 1):
        made.command(joint, 40 * MS, 3.0, 40 * MS)
    assert made.decide(40 * MS).tolist() == [3.0, 3.0]


def test_a_stop_holds_from_the_next_period_on_and_takes_no_command_until_the_reset():
    made = driven()
    made.stop()
    assert made.decide(2 * MS) is None and made.state == STOPPED
    assert not made.command(0, 2 * MS, 1.0, 2 * MS) and made.decide(5000 * MS) is None
    made.reset(6000 * MS)
    assert made.state == BRAKE and made.command(0, 6000 * MS, 1.0, 6000 * MS)


def test_stamped_on_arrival_any_stamp_within_the_tolerance_or_none_counts_as_now():
    made = CommandWatchdog(LIMITS, 15 * MS, 500 * MS, tolerance=100 * MS)
    made.reset(1000 * MS)
    for stamp in (0, 900 * MS, 1100 * MS):
        assert all(made.command(k, stamp, 1.0, 1000 * MS) for k in (0, 1))
        assert made.both_at(1000 * MS)
    assert not made.command(0, 899 * MS, 2.0, 1000 * MS)
    assert not made.command(1, 1101 * MS, 2.0, 1000 * MS) and made.late == 2
    assert made.decide(1015 * MS).tolist() == [1.0, 1.0]
    assert made.decide(1016 * MS) is None and made.state == HOLD, 'fresh is what has just arrived'


@given(
    st.lists(
        st.tuples(st.integers(0, 1), st.integers(-10, 60), st.floats(-1e9, 1e9), st.booleans()),
        max_size=60,
    )
)
def test_whatever_is_commanded_efforts_stay_within_limits_and_old_or_future_stamps_are_dropped(
    commands,
):
    made, newest = guard(), [-1, -1]
    for now, (joint, stamp, effort, ask) in enumerate(commands):
        taken = made.command(joint, stamp, effort, now)
        assert not taken or newest[joint] < stamp <= now
        newest[joint] = stamp if taken else newest[joint]
        if ask:
            asked = made.decide(now)
            assert asked is None or (np.abs(asked) <= LIMITS).all()
    assert sum(made.taken) + made.late == len(commands)
