"""One execution of a trajectory on the stamps of the joint states."""

from typing import Optional

from wholearm_ros.control.execution import Execution
from wholearm_ros.control.setpoints import Joints, TorqueSetpoint, VelocitySetpoint
from wholearm_ros.ros.interface.joint_state_serialization import NANOSECONDS

MAX_SPEED = 20.0  # [rad/s] and
MAX_SLIP = 0.05  # [rad]: joints that move more than both allow between two states were put there


class StampedExecution(Execution):
    """An `Execution` on the stamps [ns] of joint states.

    Times count from the first stamp, so the same run at another time is the same to the last bit.
    """

    _first: Optional[int] = None

    def step_at(
        self, stamp: int, joints: Joints, age: float = 0.0
    ) -> tuple[VelocitySetpoint, TorqueSetpoint]:
        """Both setpoints for the joint state at `stamp`, which is `age` [s] old."""
        if self._first is None:
            self._first = stamp
        now = (stamp - self._first) / NANOSECONDS
        return self.step(now, Joints(now - age, joints.angles, joints.velocities, joints.efforts))

    @property
    def trajectory_start(self) -> Optional[int]:
        """The stamp [ns] at which the trajectory's time is zero, after the ramp; None before."""
        if self._first is None or self.state.began is None:
            return None
        return self._first + round((self.state.began + self.ramp) * NANOSECONDS)


def jumped(before: Joints, after: Joints) -> bool:
    """Whether the fingers cannot have moved from one to the other: the hand was reset."""
    allowed = MAX_SLIP + MAX_SPEED * abs(after.stamp - before.stamp)
    return bool((abs(after.angles - before.angles) > allowed).any())
