"""The mode switch: leads both fingers along a manipulation trajectory, on its clock, and stops on a fault."""

from dataclasses import dataclass, replace
from typing import Optional, Tuple

import numpy as np

from wholearm_ros.control.setpoints import (
    ControlOptions,
    Joints,
    TorqueSetpoint,
    VelocitySetpoint,
    readonly_pair,
)
from wholearm_ros.model.interpolation import fade
from wholearm_ros.model.trajectory import DWELL, QUASI_STATIC, ManipulationTrajectory

IDLE, DONE, STOPPED = 'idle', 'done', 'stopped'
HOLD_MARGIN = 0.2  # [N m] inside of the torque range when the fingers hold the object after a stop


@dataclass(frozen=True, eq=False)
class SwitchState:
    """mode: idle, one of the trajectory's modes, done or stopped; reason: why stopped.

    began [s]: when the run began, None before; elapsed [s]: along the trajectory, negative while ramping in;
    progress: its share, 0 to 1; velocity_finger: LEFT, RIGHT or None; handed_over [s]: when that finger took over;
    offset [rad]: how far it was from the plan then; first_angles, first_efforts: (2,) found when the run began;
    held_angle [rad]: of the velocity finger when stopped; held_efforts: (2,) [N m] of both from then on.
    """

    mode: str = IDLE
    reason: str = ''
    began: Optional[float] = None
    elapsed: float = 0.0
    progress: float = 0.0
    velocity_finger: Optional[int] = None
    handed_over: float = 0.0
    offset: float = 0.0
    first_efforts: Optional[np.ndarray] = None
    held_angle: float = 0.0
    held_efforts: tuple = (0.0, 0.0)


class ModeSwitch:
    """Pure: every step takes a state and returns the next one. One switch holds one trajectory."""

    def __init__(
        self, trajectory: ManipulationTrajectory, options: ControlOptions = ControlOptions()
    ):
        self.trajectory = trajectory
        self.options = options

    def initial(self) -> SwitchState:
        """Idle: the run begins with the first step whose joint states are sound."""
        return SwitchState()

    def stop(
        self, state: SwitchState, joints: Joints, reason: str, hold: bool = False
    ) -> SwitchState:
        """Stopped: the velocity finger holds its angle, the torque finger lets go (slew-limited).

        hold: nothing is wrong, so where the object is in equilibrium the torque finger keeps the smallest torque that
        holds it, a little inside of its range.
        """
        if state.mode == STOPPED:
            return state
        finger = self._finger(state)
        angle = float(joints.angles[finger])
        held = (
            angle
            if np.isfinite(angle)
            else float(self.trajectory.sample(state.elapsed).angles[finger])
        )
        efforts = self._holding(state, finger) if hold else (0.0, 0.0)
        return replace(
            state,
            mode=STOPPED,
            reason=reason,
            velocity_finger=finger,
            held_angle=held,
            held_efforts=efforts,
        )

    def _holding(self, state: SwitchState, finger: int) -> tuple:
        """(left, right) [N m] that hold the object at this point of the plan; zero where it is not in equilibrium."""
        if state.mode not in (QUASI_STATIC, DWELL):
            return 0.0, 0.0
        efforts = self.trajectory.sample(state.elapsed).efforts.copy()
        row = int(round(max(state.elapsed, 0.0) / self.trajectory.period))
        low, high = self.trajectory.torque_ranges[min(row, len(self.trajectory.torque_ranges) - 1)]
        if np.isfinite(low) and np.isfinite(high):
            inside = min(HOLD_MARGIN, (high - low) / 2)
            efforts[1 - finger] = np.clip(0.0, low + inside, high - inside)
        return float(efforts[0]), float(efforts[1])

    def step(
        self, state: SwitchState, now: float, joints: Joints
    ) -> Tuple[SwitchState, VelocitySetpoint, TorqueSetpoint]:
        """The next state and both setpoints at time `now` [s]."""
        if state.mode != STOPPED:
            state = self._advance(state, now, joints)
        if state.mode != STOPPED:
            motion, torque = self._setpoints(state, now)
            error = float(joints.angles[motion.joint]) - motion.angle
            if abs(error) <= self.options.max_tracking_error:
                return state, motion, torque
            state = self.stop(
                state,
                joints,
                f'tracking error of the velocity-controlled finger is {error:+.3f} rad; '
                f'allowed: {self.options.max_tracking_error} rad',
            )
        finger = self._finger(state)
        return (
            state,
            VelocitySetpoint(finger, state.held_angle, 0.0, state.held_efforts[finger]),
            TorqueSetpoint(1 - finger, state.held_efforts[1 - finger]),
        )

    def _finger(self, state: SwitchState) -> int:
        first = self.trajectory.segments[0].velocity_finger
        return first if state.velocity_finger is None else state.velocity_finger

    def watch(self, state: SwitchState, now: float, joints: Joints) -> SwitchState:
        """The same state, or stopped when the joints cannot be read: for whoever leads the fingers after the end."""
        fault = self._unreadable(now, joints)
        return self.stop(state, joints, fault) if fault else state

    def _advance(self, state: SwitchState, now: float, joints: Joints) -> SwitchState:
        fault = self._unreadable(now, joints)
        if fault:
            return self.stop(state, joints, fault)
        if state.began is None:
            state = replace(state, began=now, first_efforts=readonly_pair(joints.efforts))
        elapsed = now - state.began - self.options.ramp
        segment = self.trajectory.segment_at(elapsed)
        if segment.velocity_finger != state.velocity_finger:
            state = self._hand_over(state, now, elapsed, segment.velocity_finger, joints)
        duration = self.trajectory.duration
        return replace(
            state,
            elapsed=elapsed,
            progress=min(max(elapsed / duration, 0.0), 1.0),
            mode=DONE if elapsed >= duration else segment.mode,
        )

    def _unreadable(self, now: float, joints: Joints) -> str:
        age = now - joints.stamp
        if age > self.options.stale_after:
            return f'joint states are {age:.3f} s old; allowed: {self.options.stale_after} s'
        return '' if joints.finite else 'joint states hold a number that is not finite'

    def _hand_over(
        self, state: SwitchState, now: float, elapsed: float, finger: int, joints: Joints
    ) -> SwitchState:
        planned = self.trajectory.sample(elapsed).angles[finger]
        return replace(
            state,
            velocity_finger=finger,
            handed_over=now,
            offset=float(joints.angles[finger] - planned),
        )

    def _setpoints(self, state: SwitchState, now: float) -> Tuple[VelocitySetpoint, TorqueSetpoint]:
        """The plan's sample, ramped in from the efforts found at the start, the offset at a handover faded out."""
        sample = self.trajectory.sample(state.elapsed)
        v = state.velocity_finger
        span = self.options.ramp if state.handed_over == state.began else self.options.handover
        fading, fading_rate = fade(now - state.handed_over, span)
        ramp = 1.0 - fade(now - state.began, self.options.ramp)[0]
        efforts = state.first_efforts + ramp * (sample.efforts - state.first_efforts)
        motion = VelocitySetpoint(
            v,
            float(sample.angles[v] + state.offset * fading),
            float(sample.velocities[v] + state.offset * fading_rate),
            float(efforts[v]),
        )
        return motion, TorqueSetpoint(1 - v, float(efforts[1 - v]))
