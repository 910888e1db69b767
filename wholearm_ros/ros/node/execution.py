"""One execution of a trajectory: the mode switch on the stamps of the joint states, and its settling at the end."""

from wholearm_ros.control.mode_switch import DONE, IDLE, STOPPED, ModeSwitch
from wholearm_ros.control.setpoints import ControlOptions, Joints
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.ros.interface.messages import NANOSECONDS

MAX_SPEED = 20.0  # [rad/s] and
MAX_SLIP = 0.05  # [rad]: joints that move more than both allow between two states were put there


class Execution:
    """Leads the fingers along `trajectory` from the first joint state it is given. Stamps [ns].

    settle [s]: how long the end is held before `mode` says done; `over` from then on (also after a stop).
    Times count from the first stamp, so the same run at another time is the same to the last bit.
    """

    def __init__(self, trajectory: ManipulationTrajectory, options: ControlOptions, settle: float):
        self._switch, self._settle = ModeSwitch(trajectory, options), settle
        self.trajectory, self.state = trajectory, None
        self._began = self._ended = None
        self.mode, self.over = IDLE, False

    def step(self, stamp: int, joints: Joints):
        """Both setpoints for the joint states at `stamp`."""
        if self._began is None:
            self._began, self.state = stamp, self._switch.initial()
        now = (stamp - self._began) / NANOSECONDS
        relative = Joints(now, joints.angles, joints.velocities, joints.efforts)
        self.state, motion, torque = self._switch.step(self.state, now, relative)
        self._follow(stamp)
        return motion, torque

    def stop(self, joints: Joints, reason: str):
        """On request: the fingers hold the object where that is possible."""
        state = self._switch.initial() if self.state is None else self.state
        self.state, self.mode, self._ended = (
            self._switch.stop(state, joints, reason, hold=True),
            STOPPED,
            None,
        )

    def _follow(self, stamp: int):
        if self.state.mode in (DONE, STOPPED):
            self._ended = stamp if self._ended is None else self._ended
            self.over = stamp - self._ended >= self._settle * NANOSECONDS
        if self.state.mode != DONE or self.over:
            self.mode = self.state.mode

    @property
    def reason(self) -> str:
        return self.state.reason if self.state else ''

    @property
    def progress(self) -> float:
        return self.state.progress if self.state else 0.0

    @property
    def time_left(self) -> float:
        """[s] until done."""
        return max(
            0.0,
            self.trajectory.duration - (self.state.elapsed if self.state else 0.0) + self._settle,
        )


def jumped(before: Joints, after: Joints) -> bool:
    """Whether the fingers cannot have moved from one to the other: the hand was reset."""
    allowed = MAX_SLIP + MAX_SPEED * abs(after.stamp - before.stamp)
    return bool((abs(after.angles - before.angles) > allowed).any())
