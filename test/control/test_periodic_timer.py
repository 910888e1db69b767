"""The motor loop's clock, on a time of our own: the mean rate is kept, lateness is worked off under control."""

import pytest

pytest.importorskip('rclpy')

from wholearm_ros.control.periodic_timer import MOST_BEHIND, SHORTEST, SLOWLY, PeriodicTimer

PERIOD = 1_000_000  # [ns]


class Time:
    """A clock that only sleep and work move."""

    def __init__(self):
        self.now = 0

    def sleep(self, seconds: float):
        self.now += round(seconds * 1e9)


def ticks(count: int, work) -> tuple:
    """Times of `count` ticks; work(k) is the duration [ns] of what is done after the k-th."""
    time, found = Time(), []
    clock = PeriodicTimer(PERIOD, lambda: time.now, time.sleep)
    for k in range(count):
        clock.wait()
        found.append(time.now)
        time.now += work(k)
    return found, clock


def test_the_rate_does_not_depend_on_the_work():
    found, clock = ticks(1000, lambda k: 100_000 + 700 * (k % 900))
    assert found == [PERIOD * (k + 1) for k in range(1000)] and clock.overruns == 0


@pytest.mark.parametrize('late', [5, 30, 90])
def test_lateness_is_worked_off_by_periods_a_tenth_shorter(late):
    found, clock = ticks(1200, lambda k: late * PERIOD if k == 10 else PERIOD // 4)
    gaps = [b - a for a, b in zip(found, found[1:])]
    assert min(gaps) == SHORTEST * PERIOD, 'no burst'
    assert found[-1] == 1200 * PERIOD and clock.behind == 0, 'in the end not a tick is missing'
    assert clock.worst_late == (late - 1) * PERIOD


def test_what_is_too_far_behind_is_worked_off_slowly():
    found, clock = ticks(300, lambda k: 10 * MOST_BEHIND if k == 10 else 0)
    assert clock.slipped == 10 * MOST_BEHIND - PERIOD
    assert {b - a for a, b in zip(found[12:], found[13:])} == {SLOWLY * PERIOD}
    assert found[-1] == 300 * PERIOD + clock.behind, 'what is said to be missing is missing'
    found, clock = ticks(101_000, lambda k: 10 * MOST_BEHIND if k == 10 else 0)
    assert found[-1] == 101_000 * PERIOD and clock.behind == 0, 'in the end not a tick is missing'
