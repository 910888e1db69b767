"""The mode switch: leads both fingers along a manipulation trajectory, on its clock, and stops on a
fault.
"""

from dataclasses import dataclass, replace

import numpy as np

from wholearm_ros.control.setpoints import (
    ControlOptions,
    Joints,
    TorqueSetpoint,
    VelocitySetpoint,
    readonly_pair,
)
from wholearm_ros.kernels.switch_law import NO_FINGER, Course, Switch, switch_at, switch_period
from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.modes import DONE, DWELL, IDLE, QUASI_STATIC, STOPPED
from wholearm_ros.model.trajectory import ManipulationTrajectory

HOLD_MARGIN = 0.2  # [N m] inside of the torque range when the fingers hold the object after a stop


def course_of(trajectory: ManipulationTrajectory) -> Course:
    """A trajectory as the arrays of the switch law."""
    band = trajectory.band
    course = Course(
        trajectory.period,
        trajectory.angles,
        trajectory.velocities,
        trajectory.efforts,
        readonly([s.end for s in trajectory.segments]),
        readonly([s.velocity_finger for s in trajectory.segments], dtype=np.int64),
    )
    if band is None:
        return course
    return course._replace(
        band_period=band.period, low=band.low, high=band.high, patience=band.patience
    )


@dataclass(frozen=True, eq=False)
class SwitchState:
    """mode: idle, one of the trajectory's modes, done or stopped; reason: why stopped.

    switch: the switch law's state, None before the run began; progress: share of the trajectory,
    0 to 1; first_efforts: (2,) [N m] found when the run began; held_angle [rad]: of the velocity
    finger when stopped; held_efforts: (2,) [N m] of both from then on.
    """

    mode: str = IDLE
    reason: str = ''
    switch: Switch | None = None
    progress: float = 0.0
    first_efforts: np.ndarray | None = None
    held_angle: float = 0.0
    held_efforts: tuple[float, float] = (0.0, 0.0)

    @property
    def began(self) -> float | None:
        """[s] when the run began, None before."""
        return None if self.switch is None else self.switch.began

    @property
    def elapsed(self) -> float:
        """[s] along the trajectory, negative while ramping in."""
        return 0.0 if self.switch is None else self.switch.elapsed

    @property
    def deviated(self) -> bool:
        """Whether a finger was out of the trajectory's band for longer than its patience."""
        return self.switch is not None and bool(np.isfinite(self.switch.outside.deviated))


class ModeSwitch:
    """Pure: every step takes a state and returns the next one. One switch holds one trajectory."""

    def __init__(
        self, trajectory: ManipulationTrajectory, options: ControlOptions = ControlOptions()
    ) -> None:
        self.trajectory = trajectory
        self.options = options
        self._law, self._course = options.switch_law(), course_of(trajectory)

    def initial(self) -> SwitchState:
        """Idle: the run begins with the first step whose joint states are sound."""
        return SwitchState()

    def stop(
        self, state: SwitchState, joints: Joints, reason: str, hold: bool = False
    ) -> SwitchState:
        """Stopped: the velocity finger holds its angle, the torque finger's torque goes to zero,
        slew-limited.

        hold: nothing is wrong, so where the object is in equilibrium the torque finger keeps the
        smallest torque that holds it, a little inside of its range.
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
            held_angle=held,
            held_efforts=efforts,
        )

    def _holding(self, state: SwitchState, finger: int) -> tuple[float, float]:
        """(left, right) [N m] that hold the object at this point of the plan; zero where it is not
        in equilibrium.
        """
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
    ) -> tuple[SwitchState, VelocitySetpoint, TorqueSetpoint]:
        """The next state and both setpoints at time `now` [s]."""
        state = self.watch(state, now, joints)
        if state.mode != STOPPED:
            state, motion, torque = self._advance(state, now, joints)
            if state.mode != STOPPED:
                return state, motion, torque
        finger = self._finger(state)
        return (
            state,
            VelocitySetpoint(finger, state.held_angle, 0.0, state.held_efforts[finger]),
            TorqueSetpoint(1 - finger, state.held_efforts[1 - finger]),
        )

    def _advance(
        self, state: SwitchState, now: float, joints: Joints
    ) -> tuple[SwitchState, VelocitySetpoint, TorqueSetpoint]:
        """One period of the switch law, on joints that can be read."""
        switch, efforts = state.switch, state.first_efforts
        if switch is None or efforts is None:
            switch, efforts = switch_at(now, NO_FINGER), readonly_pair(joints.known_efforts)
        switch, motion, torque = switch_period(
            self._law, self._course, efforts, switch, now, joints.angles
        )
        duration = self.trajectory.duration
        over = switch.elapsed >= duration
        state = replace(
            state,
            mode=DONE if over else self.trajectory.segments[switch.segment].mode,
            switch=switch,
            progress=min(max(switch.elapsed / duration, 0.0), 1.0),
            first_efforts=efforts,
        )
        if switch.stops:
            state = self.stop(state, joints, self._fault(state), hold=switch.error == 0.0)
        return state, motion, torque

    def _fault(self, state: SwitchState) -> str:
        """Why the switch law stops."""
        if state.switch is not None and state.switch.error != 0.0:
            return (
                f'tracking error of the velocity-controlled finger is {state.switch.error:+.3f} '
                f'rad; allowed: {self.options.max_tracking_error} rad'
            )
        return self.deviation(state)

    def deviation(self, state: SwitchState) -> str:
        """Where and how a finger left the band for longer than its patience, '' when none did."""
        if state.switch is None or not state.deviated:
            return ''
        outside, segments = state.switch.outside, self.trajectory.segments
        number = segments.index(self.trajectory.segment_at(outside.deviated))
        return (
            f'deviated in segment {number + 1} of {len(segments)} ({segments[number].mode}), '
            f't = {outside.deviated:.2f} s: the left finger {outside.left:+.3f} rad, '
            f'the right one {outside.right:+.3f} rad outside of the band'
        )

    def _finger(self, state: SwitchState) -> int:
        """The velocity-controlled finger, the first one before the run began."""
        if state.switch is None:
            return self.trajectory.segments[0].velocity_finger
        return int(state.switch.finger)

    def watch(self, state: SwitchState, now: float, joints: Joints) -> SwitchState:
        """The same state, or stopped when the joints cannot be read."""
        fault = '' if state.mode == STOPPED else self._unreadable(now, joints)
        return self.stop(state, joints, fault) if fault else state

    def _unreadable(self, now: float, joints: Joints) -> str:
        age = now - joints.stamp
        if age > self.options.stale_after:
            return f'joint states are {age:.3f} s old; allowed: {self.options.stale_after} s'
        return '' if joints.finite else 'joint states hold a number that is not finite'
