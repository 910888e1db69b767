"""Wrong hands are found out by what they do: each of them fails the check of its mistake."""

from dataclasses import replace

import numpy as np
import pytest

from wholearm_ros.control.hand_checks import (
    Push,
    Sample,
    Silence,
    check_listening,
    check_moving,
    not_moved,
)
from wholearm_ros.model.hand import JOINT_NAMES
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.package_share import scenario_path

HAND = load_scenario(scenario_path('')).hand
RATE, START = 1000.0, 10**18
REST = np.array([2.0, 1.1])


def record(angles=lambda t: REST, velocities=lambda t: np.zeros(2), seconds=1.0, rate=RATE, **also):
    """What a right hand would send; `also`: fields to replace, functions of time."""
    samples = []
    for k in range(int(seconds * rate)):
        t = k / rate
        now = START + round(1e9 * t)
        sample = Sample(now + 200_000, now, JOINT_NAMES, tuple(angles(t)), tuple(velocities(t)),
                        (0.5, -0.5))  # fmt: skip
        samples.append(sample._replace(**{f: make(t, sample) for f, make in also.items()}))
    return samples


def failed(checks):
    return {check.name for check in checks if check.passed is False}


def test_a_right_hand_passes_what_can_be_heard():
    checks = check_listening(record(), HAND, RATE)
    assert all(check.passed for check in checks), checks
    assert {c.passed for c in not_moved()} == {None}


WRONG = {
    'swapped': ({'names': lambda t, s: s.names[::-1]}, {'joints'}),
    'missing': ({'names': lambda t, s: s.names[:1]}, {'joints'}),
    'no velocity': ({'velocity': lambda t, s: ()}, {'joints'}),
    'degrees': ({'position': lambda t, s: tuple(np.degrees(s.position))}, {'angles'}),
    'NaN': ({'effort': lambda t, s: (np.nan, 0.0)}, {'finite values'}),
    'too strong': ({'effort': lambda t, s: (900.0, 0.0)}, {'efforts'}),
    'zero stamps': ({'stamp': lambda t, s: 0}, {'stamps'}),
    'future': ({'stamp': lambda t, s: s.stamp + 10**8}, {'stamps'}),
    'one stamp': ({'stamp': lambda t, s: START}, {'stamps'}),
    'false velocity': ({'velocity': lambda t, s: (1.0, 0.0)}, {'velocities'}),
}


@pytest.mark.parametrize('name', WRONG)
def test_a_wrong_hand_fails_where_it_is_wrong(name):
    also, expected = WRONG[name]
    assert failed(check_listening(record(**also), HAND, RATE)) == expected


def test_degrees_are_named():
    wrong = record(position=lambda t, s: tuple(np.degrees(s.position)))
    [angles] = [c for c in check_listening(wrong, HAND, RATE) if c.name == 'angles']
    assert 'degrees' in angles.advice


def test_a_slow_hand_and_one_that_stutters():
    assert failed(check_listening(record(rate=100.0), HAND, RATE)) == {'rate'}
    stutter = record(heard=lambda t, s: START + round(1e9 * (t // 0.04) * 0.04) + 40_000_000)
    assert failed(check_listening(stutter, HAND, RATE)) == {'jitter'}


def push(joint, moves=None, sign=1.0, scale=1.0, delay=0.004):
    """A step of 0.35 N m; `moves`: the joint that truly moves."""
    moves, torque = joint if moves is None else moves, 0.35
    rate = sign * scale * torque / HAND[joint].inertia  # [rad/s²]
    unit = np.eye(2)[moves]
    samples = record(
        lambda t: REST + unit * rate * max(t - delay, 0.0) ** 2 / 2,
        lambda t: unit * rate * max(t - delay, 0.0),
        0.1,
    )
    return Push(joint, torque, START, samples)


def silence(angles=lambda t: REST, zero=True):
    return Silence(
        START,
        record(
            angles, seconds=1.0, effort=lambda t, s: (0.0, 0.0) if zero and t > 0.52 else (1.0, 1.0)
        ),
    )


PUSHES = push(0), push(1)


def test_a_right_hand_passes_what_is_moved():
    checks = check_moving(PUSHES, silence(), silence(zero=False), HAND)
    assert all(check.passed for check in checks), checks


@pytest.mark.parametrize(
    ('wrong', 'name'),
    [
        ({'sign': -1.0}, 'sign'),
        ({'moves': 1}, 'sign'),
        ({'scale': 0.0}, 'sign'),
        ({'scale': 57.3}, 'torque unit'),
        ({'delay': 0.05}, 'latency'),
    ],
)
def test_a_push_finds_sign_swap_unit_and_delay(wrong, name):
    checks = check_moving([push(0, **wrong)], None, None, HAND)
    assert failed(checks) == {f'{name} of {JOINT_NAMES[0]}'}
    assert [c.passed for c in checks[-2:]] == [None, None]  # not tried


def test_a_push_that_was_aborted_fails():
    aborted = replace(push(0), aborted='aborted: faster than 1.5 rad/s')
    assert failed(check_moving([aborted], None, None, HAND)) == {f'motion of {JOINT_NAMES[0]}'}


def test_no_watchdog_and_a_stop_that_does_nothing_are_found():
    drift = silence(lambda t: REST + 0.2 * t)
    late = silence(lambda t: REST + 0.2 * max(t - 0.6, 0.0), zero=False)
    assert not failed(check_moving(PUSHES, silence(zero=False), silence(), HAND)), 'it holds on'
    for wrong in (drift, late, Silence(START, ())):
        assert failed(check_moving(PUSHES, wrong, silence(), HAND)) == {'watchdog'}
    deaf = Silence(START, silence().samples, answered=False)
    for wrong in (drift, deaf):
        assert failed(check_moving(PUSHES, silence(), wrong, HAND)) == {'stop service'}
