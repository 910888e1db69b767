"""Probing: the motion that feels what lies between the fingers. Pure: a step takes a state and
returns the next one.

The closing finger gives way at a small torque, so the object is pushed by the held finger, which is
position-controlled, and slides along the palm until it lies at both: friction does not keep it from
doing so.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from wholearm_ros.control.setpoints import Joints, TorqueSetpoint, VelocitySetpoint
from wholearm_ros.model.hand import CLOSING
from wholearm_ros.model.interpolation import fade, rise
from wholearm_ros.model.probe import Probe
from wholearm_ros.model.weight import bearing_torques

# Greatest acceleration of a fifth-order move from rest to rest, over its way and time.
PEAK = 5.7735
SHORTEST = 0.12  # [s] of one of its moves
AWAY_SPEED = 0.35  # [rad/s] at most when it leads the object away: the closing one keeps up
# Greatest speed of a fifth-order move from rest to rest, over its way and time.
PEAK_SPEED = 1.875
STIFFNESS = 6.0  # [N m/rad] of the closing finger about its target, until `torque` bounds it
# [rad/s] at which damping balances the closing torque: faster, it would tip what it meets.
CLOSING_SPEED = 0.4
OPENING_TORQUE = 0.3  # [N m] at most, while the closing finger opens
RELEASE = 0.25  # [s] in which the torques found at the start fade out
# [s] and number of the stretches of readings whose means are compared: noise averages out.
WINDOW, WINDOWS = 0.02, 4
# [rad] fingers whose means all lie within this are at rest; a finger that turns round is not.
AT_REST = 6e-4
LONGEST_WAIT = 2.0  # [s] for rest at one place
JAMMED = 0.06  # [rad] of the held finger from its setpoint: something does not give way

Reading = tuple[float, np.ndarray]  # time [s], angles (2,) [rad]


@dataclass(frozen=True)
class Phase:
    """One move: the held finger goes to `angle` [rad] in `duration` [s], the closing one opens, or
    closes meanwhile and ends at rest. measured: whether the pair of angles is read then.
    """

    angle: float
    duration: float
    closes: bool
    measured: bool


@dataclass(frozen=True, eq=False)
class ProbingState:
    """phases: from where the held finger was found; phase: index of the present one; began,
    phase_began [s]; first_angles, first_efforts: (2,) [rad, N m] found at the start; readings: the
    last ones; pairs: (2,) [rad] each, what was felt at the places so far; reason: why it ended
    early.
    """

    phases: tuple[Phase, ...]
    phase: int
    began: float
    phase_began: float
    first_angles: np.ndarray
    first_efforts: np.ndarray
    readings: tuple[Reading, ...] = ()
    pairs: tuple[np.ndarray, ...] = ()
    over: bool = False
    reason: str = ''


class Probing:
    """Leads both fingers along a `Probe`."""

    def __init__(self, probe: Probe) -> None:
        self.probe = probe

    def initial(self, now: float, joints: Joints) -> ProbingState:
        """Probing begins at `now` [s] from where the fingers are."""
        found = float(joints.angles[self.probe.held])
        return ProbingState(
            self._phases(found), 0, now, now, joints.angles.copy(), joints.known_efforts
        )

    def _phases(self, found: float) -> tuple[Phase, ...]:
        """The moves of a held finger that was found at an angle [rad]: both open, it comes back,
        the other one closes, it leads the object to the first place, and from place to place.
        """
        probe, held = self.probe, self.probe.held
        opened = found - CLOSING[held] * float(probe.opened[held])
        phases = [Phase(found, RELEASE, False, False)]
        if probe.opened.any():
            time = self._time(opened, found)
            phases += [Phase(angle, time, False, False) for angle in (opened, found)]
            phases += [Phase(found, SHORTEST, True, False)]
        first, *others = map(float, probe.places)
        slowly = max(self._time(found, first), PEAK_SPEED * abs(first - found) / AWAY_SPEED)
        phases += [Phase(first, slowly, True, True)]
        ways = pairwise([first, *others])
        phases += [Phase(place, self._time(before, place), True, True) for before, place in ways]
        return tuple(phases)

    def _time(self, start: float, end: float) -> float:
        """[s] of the held finger's move between two angles [rad]."""
        return max(SHORTEST, float(np.sqrt(PEAK * abs(end - start) / self.probe.acceleration)))

    def step(
        self, state: ProbingState, now: float, joints: Joints
    ) -> tuple[ProbingState, VelocitySetpoint, TorqueSetpoint]:
        """The next state and the setpoints of the held and of the closing finger at `now` [s]."""
        if not state.over:
            oldest = now - WINDOWS * WINDOW
            recent = tuple(r for r in state.readings if r[0] > oldest)
            state = replace(state, readings=(*recent, (now, joints.angles.copy())))
            state = self._next(state, now)
        motion = self._motion(state, now, joints)
        error = abs(float(joints.angles[motion.joint]) - motion.angle)
        if error > JAMMED and not state.over:
            reason = f'the held finger is {error:.3f} rad off: jammed'
            state = replace(state, over=True, reason=reason)
        return state, motion, self._torque(state, now, joints)

    def _next(self, state: ProbingState, now: float) -> ProbingState:
        """The state after the present move, if it has ended."""
        phase, elapsed = state.phases[state.phase], now - state.phase_began
        if elapsed < phase.duration:
            return state
        waits = phase.closes and elapsed < phase.duration + LONGEST_WAIT
        if waits and not _at_rest(state.readings, now):
            return state
        pairs = state.pairs
        if phase.measured:
            pairs = (*pairs, _mean(state.readings, now - 2 * WINDOW, now))
        last = state.phase + 1 == len(state.phases)
        return replace(
            state,
            phase=state.phase + (not last),
            phase_began=state.phase_began if last else now,
            readings=(),
            pairs=pairs,
            over=last,
        )

    def _motion(self, state: ProbingState, now: float, joints: Joints) -> VelocitySetpoint:
        """The held finger's move, its own weight fed forward."""
        held, phases = self.probe.held, state.phases
        phase = phases[state.phase]
        start = phases[state.phase - 1].angle if state.phase else float(state.first_angles[held])
        share, rate = rise(now - state.phase_began, phase.duration)
        weight = float(bearing_torques(self.probe.weights, joints.angles)[held])
        kept = fade(now - state.began, RELEASE)[0]
        effort = weight + kept * (float(state.first_efforts[held]) - weight)
        turn = phase.angle - start
        return VelocitySetpoint(held, start + share * turn, rate * turn, effort)

    def _torque(self, state: ProbingState, now: float, joints: Joints) -> TorqueSetpoint:
        """A soft servo: towards the stop, or towards open, never with more than the bound."""
        probe, side = self.probe, self.probe.closing
        angle, speed = float(joints.angles[side]), float(joints.velocities[side])
        closes = state.phases[state.phase].closes
        bound = probe.torque if closes else OPENING_TORQUE
        target = float(probe.stops[side])
        if not closes:
            target = float(state.first_angles[side]) - CLOSING[side] * float(probe.opened[side])
        pull = min(max(STIFFNESS * (target - angle), -bound), bound)
        weight = float(bearing_torques(probe.weights, joints.angles)[side])
        effort = weight + pull - bound / CLOSING_SPEED * speed
        kept = fade(now - state.began, RELEASE)[0]
        return TorqueSetpoint(
            side, float(effort + kept * (float(state.first_efforts[side]) - effort))
        )


def _at_rest(readings: tuple[Reading, ...], now: float) -> bool:
    if now - readings[0][0] < (WINDOWS - 0.5) * WINDOW:
        return False
    ends = [now - k * WINDOW for k in range(WINDOWS, -1, -1)]
    means = [_mean(readings, a, b) for a, b in zip(ends, ends[1:])]
    return bool(np.ptp(means, axis=0).max() < AT_REST)


def _mean(readings: tuple[Reading, ...], after: float, until: float) -> np.ndarray:
    """(2,) [rad] mean angles in (after, until]; NaN where there are none."""
    within = [angles for t, angles in readings if after < t <= until]
    return np.mean(within, axis=0) if within else np.full(2, np.nan)
