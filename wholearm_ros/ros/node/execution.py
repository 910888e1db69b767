"""One execution of a trajectory: the mode switch on the stamps of the joint states, and its settling at the end."""

from typing import Optional

from wholearm_ros.control.mode_switch import DONE, IDLE, STOPPED, ModeSwitch, SwitchState
from wholearm_ros.control.setpoints import ControlOptions, Joints, TorqueSetpoint, VelocitySetpoint
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.ros.interface.messages import NANOSECONDS

MAX_SPEED = 20.0  # [rad/s] and
MAX_SLIP = 0.05  # [rad]: joints that move more than both allow between two states were put there


class Execution:
    """Leads the fingers along `trajectory` from the first joint state it is given. Stamps [ns].

    settle [s]: how long the end is held before `mode` says done; `over` from then on (also after a stop).
    Times count from the first stamp, so the same run at another time is the same to the last bit.
    """

    def __init__(
        self, trajectory: ManipulationTrajectory, options: ControlOptions, settle: float
    ) -> None:
        self._switch, self._settle = ModeSwitch(trajectory, options), settle
        self.trajectory = trajectory
        self.state: SwitchState = self._switch.initial()
        self._began: Optional[int] = None
        self._ended: Optional[int] = None
        self.mode, self.over = IDLE, False

    def step(
        self, stamp: int, joints: Joints, age: float = 0.0
    ) -> tuple[VelocitySetpoint, TorqueSetpoint]:
        """Both setpoints for the joint states at `stamp`, which are `age` [s] old."""
        if self._began is None:
            self._began = stamp
        now = (stamp - self._began) / NANOSECONDS
        relative = Joints(now - age, joints.angles, joints.velocities, joints.efforts)
        self.state, motion, torque = self._switch.step(self.state, now, relative)
        self._follow(stamp)
        return motion, torque

    def stop(self, joints: Joints, reason: str) -> None:
        """On request: the fingers hold the object where that is possible."""
        self.state = self._switch.stop(self.state, joints, reason, hold=True)
        self.mode, self._ended = STOPPED, None

    def _follow(self, stamp: int) -> None:
        if self.state.mode in (DONE, STOPPED):
            self._ended = stamp if self._ended is None else self._ended
            self.over = stamp - self._ended >= self._settle * NANOSECONDS
        if self.state.mode != DONE or self.over:
            self.mode = self.state.mode

    @property
    def reason(self) -> str:
        """Why it was stopped, or nothing."""
        return self.state.reason

    @property
    def progress(self) -> float:
        """Share of the trajectory, 0 to 1."""
        return self.state.progress

    @property
    def time_left(self) -> float:
        """[s] until done."""
        return max(0.0, self.trajectory.duration - self.state.elapsed + self._settle)

    @property
    def trajectory_start(self) -> Optional[int]:
        """The stamp [ns] at which the trajectory's own time is zero, after the ramp; None before the first state."""
        if self._began is None or self.state.began is None:
            return None
        return self._began + round((self.state.began + self._switch.options.ramp) * NANOSECONDS)


def jumped(before: Joints, after: Joints) -> bool:
    """Whether the fingers cannot have moved from one to the other: the hand was reset."""
    allowed = MAX_SLIP + MAX_SPEED * abs(after.stamp - before.stamp)
    return bool((abs(after.angles - before.angles) > allowed).any())
