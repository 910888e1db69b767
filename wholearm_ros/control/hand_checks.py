"""Whether a hand keeps to the contract of docs/your_hand.md, judged from recorded joint states."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from wholearm_ros.model.hand import JOINT_NAMES, Finger, Hand

RATE_TOLERANCE = 0.1  # of the rate
TIMEOUT = 0.015  # [s] without a command, after which the drives hold
HOLD_WITHIN, HOLD_TIME = 0.02, 0.5  # [s] after the last command; of holding, before zero torque
ZERO_WITHIN = 0.1  # [s] of grace for the messages after that
LATEST = 0.03  # [s] from a command to its effect
FUTURE, OLD = 0.005, 1.0  # [s] by which a stamp may lie after, before the time it is heard
HELD = 0.02  # [rad] by which a held finger may move
MOVED = 0.004  # [rad] of motion that is no noise
STARTED = 0.02  # [rad/s] of change at which a finger has begun to move
ZERO_TORQUE = 0.05  # [N m]
SCALE = 5.0  # factor by which the acceleration may differ from the scenario's
PUSHED = 'motion', 'sign', 'torque unit', 'latency'  # judged of each joint
NOT_TRIED = 'not tried: needs --move'


class Sample(NamedTuple):
    """A joint state as it was heard. heard, stamp [ns]; position [rad], velocity [rad/s], effort
    [N m] in the order of `names`.
    """

    heard: int
    stamp: int
    names: tuple[str, ...]
    position: tuple[float, ...]
    velocity: tuple[float, ...]
    effort: tuple[float, ...]


@dataclass(frozen=True)
class Check:
    """passed: None where it was not tried."""

    name: str
    passed: bool | None
    measured: str
    advice: str = ''


@dataclass(frozen=True)
class Push:
    """A torque step of `torque` [N m] beyond its weight on `joint`, begun at `began` [ns], and the
    joint states from then on, the last one before it first.

    aborted: why the push ended early, or nothing.
    """

    joint: int
    torque: float
    began: int
    samples: Sequence[Sample]
    aborted: str = ''


@dataclass(frozen=True)
class Silence:
    """The joint states after the last command, or after the stop, at `began` [ns]."""

    began: int
    samples: Sequence[Sample]
    answered: bool = True  # the stop service said success


def check_listening(samples: Sequence[Sample], hand: Hand, rate: float) -> list[Check]:
    """What can be seen without moving; `samples`: at least two; rate [Hz] that is expected."""
    checks = [_names(samples)]
    if not checks[0].passed:
        return checks + _clock(samples, rate)
    checks.append(_finite(samples))
    if checks[-1].passed:
        checks += [_angles(samples, hand), _velocities(samples), _efforts(samples, hand)]
    return checks + _clock(samples, rate)


def check_moving(
    pushes: Sequence[Push], silence: Silence | None, stop: Silence | None, hand: Hand
) -> list[Check]:
    """What takes a torque to see; a phase that an earlier one forbade is not tried."""
    checks = [check for push in pushes for check in _push(push, hand[push.joint])]
    checks += _watchdog(silence)
    if stop is None:
        return [*checks, Check('stop service', None, 'not tried: a check before it failed')]
    moved = _most_moved(_after(stop, HOLD_WITHIN, np.inf))
    return [
        *checks,
        Check(
            'stop service',
            stop.answered and moved <= HELD,
            f'answered {"yes" if stop.answered else "no"}, then moved {moved:.3f} rad under '
            'commands',
            'hand_hardware/stop answers success, holds both fingers and takes no command until the '
            'reset',
        ),
    ]


def not_moved(why: str = NOT_TRIED) -> list[Check]:
    """The checks of `check_moving` where nothing was moved."""
    names = [f'{kind} of {n}' for n in JOINT_NAMES for kind in PUSHED]
    return [Check(n, None, why) for n in (*names, 'watchdog', 'stop service')]


def in_order(samples: Sequence[Sample]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angles [rad], velocities [rad/s], efforts [N m], each (n, 2), left first."""
    order = [samples[0].names.index(name) for name in JOINT_NAMES]
    return tuple(  # type: ignore[return-value]
        np.array([getattr(s, field) for s in samples])[:, order]
        for field in ('position', 'velocity', 'effort')
    )


def _names(samples: Sequence[Sample]) -> Check:
    seen = {s.names for s in samples}
    full = all(len(s.names) == len(s.position) == len(s.velocity) == len(s.effort) for s in samples)
    return Check(
        'joints',
        seen == {JOINT_NAMES} and full,
        '; '.join(', '.join(names) or 'no name' for names in sorted(seen))
        + ('' if full else '; columns of different length'),
        f'every message names {JOINT_NAMES[0]} and {JOINT_NAMES[1]}, with position, velocity and '
        'effort of both',
    )


def _finite(samples: Sequence[Sample]) -> Check:
    bad = sum(not np.isfinite([*s.position, *s.velocity, *s.effort]).all() for s in samples)
    return Check(
        'finite values',
        not bad,
        f'{bad} of {len(samples)} messages with NaN or infinity',
        'send no state rather than one that was not measured',
    )


def _angles(samples: Sequence[Sample], hand: Hand) -> Check:
    angles = in_order(samples)[0]
    limits = np.array([hand.left.angle_limits, hand.right.angle_limits])  # (2, 2)
    passed, in_degrees = _within(angles, limits), _within(np.radians(angles), limits)
    return Check(
        'angles',
        passed,
        ', '.join(
            f'{a.min():.3f} to {a.max():.3f} (limits {low:.3f} to {high:.3f} rad)'
            for a, (low, high) in zip(angles.T, limits)
        ),
        'these are degrees: send radians'
        if in_degrees
        else 'check zero and sign (direction of the finger from +x, counter-clockwise), and '
        'angle_limits of the scenario',
    )


def _within(angles: np.ndarray, limits: np.ndarray) -> bool:
    return bool((angles >= limits[:, 0] - HELD).all() and (angles <= limits[:, 1] + HELD).all())


def _velocities(samples: Sequence[Sample]) -> Check:
    """The mean velocity against the change of the angle."""
    angles, velocities, _ = in_order(samples)
    seconds = (samples[-1].heard - samples[0].heard) / 1e9
    change, told = angles[-1] - angles[0], velocities.mean(axis=0) * seconds
    return Check(
        'velocities',
        bool((np.abs(told - change) <= HELD + 0.3 * np.abs(change)).all()),
        f'angles changed by {change[0]:.3f}, {change[1]:.3f} rad; velocities say {told[0]:.3f}, '
        f'{told[1]:.3f} rad',
        'velocity is the rate of the same angle [rad/s]',
    )


def _efforts(samples: Sequence[Sample], hand: Hand) -> Check:
    largest = np.abs(in_order(samples)[2]).max(axis=0)
    limits = np.array([hand.left.torque_limit, hand.right.torque_limit])
    return Check(
        'efforts',
        bool((largest <= 1.01 * limits).all()),
        f'at most {largest[0]:.2f}, {largest[1]:.2f} N m (limits {limits[0]:.2f}, {limits[1]:.2f})',
        'effort is the torque at the joint [N m], within torque_limit of the scenario',
    )


def _clock(samples: Sequence[Sample], rate: float) -> list[Check]:
    heard = np.array([s.heard for s in samples])
    stamps = np.array([s.stamp for s in samples])
    gaps, ages = np.diff(heard) / 1e9, (heard - stamps) / 1e9  # [s]
    got, slow = (len(samples) - 1) / max(gaps.sum(), 1e-9), np.percentile(gaps, 99)
    back = int((np.diff(stamps) <= 0).sum())
    zero = bool((stamps == 0).any())
    return [
        Check(
            'rate',
            bool(abs(got - rate) <= RATE_TOLERANCE * rate),
            f'{got:.0f} Hz, expected {rate:.0f} Hz',
            'publish once a motor period, or tell the true rate (--rate, motor_rate of the nodes)',
        ),
        Check(
            'jitter',
            bool(slow <= max(TIMEOUT, 2 / rate)),
            f'99 % of the gaps below {1e3 * slow:.1f} ms, the longest {1e3 * np.max(gaps):.1f} ms',
            f'a gap above {1e3 * TIMEOUT:.0f} ms trips the watchdog: raise the priority of the '
            'process, or unload the machine',
        ),
        Check(
            'stamps',
            not zero and not back and bool((ages >= -FUTURE).all() and (ages <= OLD).all()),
            'zero'
            if zero
            else f'{1e3 * ages.min():.1f} to {1e3 * ages.max():.1f} ms old, {back} not advancing',
            'the stamp is the ROS time of the measurement, later in every message, and the clocks '
            'of both machines agree',
        ),
    ]


def _push(push: Push, finger: Finger) -> list[Check]:
    name, sign = JOINT_NAMES[push.joint], np.sign(push.torque)
    angles, velocities, _ = in_order(push.samples)
    moves = angles - angles[0]  # (n, 2)
    own, other = moves[:, push.joint], moves[:, 1 - push.joint]
    furthest = own[np.abs(own).argmax()]
    swapped = np.abs(other).max() > max(MOVED, abs(furthest))
    right = bool(sign * furthest > MOVED) and not swapped
    speeds = velocities[:, push.joint] - velocities[0, push.joint]
    started = np.flatnonzero(np.abs(speeds) > STARTED)
    checks = [
        Check(
            f'motion of {name}',
            not push.aborted,
            push.aborted or 'within the limits of the push',
            'compare sign and unit of torque and angle, mass and rotor_inertia of the scenario; '
            'nothing else in the way of the finger',
        ),
        Check(
            f'sign of {name}',
            right,
            f'{push.torque:+.2f} N m moved it by {furthest:+.4f} rad',
            'the other joint moved: the joints are swapped'
            if swapped
            else 'angle and torque are both counter-clockwise positive; where it does not move, '
            'look for friction, an end stop, or a command that is not taken',
        ),
    ]
    if not right or not started.size:
        why = 'not tried: it did not move as it should'
        return [
            *checks,
            Check(f'torque unit of {name}', None, why),
            Check(f'latency of {name}', None, why),
        ]
    seconds = np.array([s.heard - push.began for s in push.samples]) / 1e9
    expected = abs(push.torque) / finger.inertia  # [rad/s²]
    first = int(started[0])
    got = abs(speeds[-1]) / max(seconds[-1] - seconds[max(first - 1, 0)], 1e-3)
    latency = seconds[first] - STARTED / expected
    return [
        *checks,
        Check(
            f'torque unit of {name}',
            bool(expected / SCALE <= got <= expected * SCALE),
            f'{got:.1f} rad/s², expected {expected:.1f}',
            'torque in N m at the joint (not the motor, not the current), angle in radians, mass '
            'and rotor_inertia of the scenario',
        ),
        Check(
            f'latency of {name}',
            bool(latency <= LATEST),
            f'{1e3 * max(latency, 0.0):.1f} ms from command to motion',
            f'at most {1e3 * LATEST:.0f} ms: apply a command in the motor period after it comes',
        ),
    ]


def _watchdog(silence: Silence | None) -> list[Check]:
    if silence is None:
        return [Check('watchdog', None, 'not tried: a check before it failed')]
    zero_after = TIMEOUT + HOLD_TIME + ZERO_WITHIN
    moved = _most_moved(_after(silence, HOLD_WITHIN, HOLD_TIME))
    last = _after(silence, zero_after, np.inf)
    effort = float(np.abs(in_order(last)[2]).max()) if last else np.inf
    holds_on = bool(last) and _most_moved(_after(silence, HOLD_WITHIN, np.inf)) <= HELD
    return [
        Check(
            'watchdog',
            moved <= HELD and (holds_on or effort <= ZERO_TORQUE),
            f'without commands moved {moved:.3f} rad in {HOLD_TIME:.1f} s, '
            + (f'then {effort:.2f} N m' if last else 'then no state was heard'),
            f'hold both fingers {1e3 * TIMEOUT:.0f} ms after the last command, and go on, or '
            f'have zero torque {HOLD_TIME:.1f} s later: CommandWatchdog does this',
        )
    ]


def _after(silence: Silence, low: float, high: float) -> list[Sample]:
    """Those heard from `low` to `high` [s] after it began."""
    return [s for s in silence.samples if low <= (s.heard - silence.began) / 1e9 <= high]


def _most_moved(samples: Sequence[Sample]) -> float:
    """[rad]; infinite where nothing was heard."""
    return float(np.ptp(in_order(samples)[0], axis=0).max()) if samples else np.inf
