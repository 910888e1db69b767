"""One execution of a trajectory: the mode switch to its end, the settling there, and the probe that
feels what came of it.

Nodes and the closed loop without ROS call the same code.
"""

import numpy as np

from wholearm_ros.control.mode_switch import ModeSwitch, SwitchState
from wholearm_ros.control.probing import Probing, ProbingState
from wholearm_ros.control.setpoints import ControlOptions, Joints, Setpoints
from wholearm_ros.model.modes import DONE, IDLE, PROBING, STOPPED
from wholearm_ros.model.probe import Probe
from wholearm_ros.model.trajectory import ManipulationTrajectory

COURSE_PERIOD = 0.02  # [s] between two rows of a course


class Execution:
    """Leads the fingers along `trajectory` from the first joint state it is given. Times [s] from
    any zero.

    settle [s]: how long the end is held; `over` when that time has passed after the end, the
    probe's if there is one, or after a stop. probe: the motion after the settling, None to do
    without.
    """

    def __init__(
        self,
        trajectory: ManipulationTrajectory,
        options: ControlOptions,
        settle: float,
        probe: Probe | None = None,
    ) -> None:
        self._switch, self._settle = ModeSwitch(trajectory, options), settle
        self._probing = None if probe is None else Probing(probe)
        self.trajectory, self.probe = trajectory, probe
        self.state: SwitchState = self._switch.initial()
        self.felt: ProbingState | None = None
        self._ended: float | None = None
        self.mode, self.over = IDLE, False
        self._course: list[np.ndarray] = []

    def step(self, now: float, joints: Joints) -> Setpoints:
        """Both setpoints for the joint state at `now` [s]."""
        if self.felt is not None and self.state.mode != STOPPED:
            return self._probe(now, joints)
        self.state, motion, torque = self._switch.step(self.state, now, joints)
        if self.state.elapsed >= COURSE_PERIOD * len(self._course):
            self._course.append(np.array(joints.angles))
        ended = self.state.mode in (DONE, STOPPED)
        if ended and self._ended is None:
            self._ended = now
        settled = self._ended is not None and now - self._ended >= self._settle
        if settled and self.state.mode == DONE and self._probing is not None:
            self.felt = self._probing.initial(now, joints)
            return self._probe(now, joints)
        self.over = settled
        if self.state.mode != DONE or self.over:
            self.mode = self.state.mode
        return motion, torque

    def _probe(self, now: float, joints: Joints) -> Setpoints:
        assert self._probing is not None and self.felt is not None
        self.state = self._switch.watch(self.state, now, joints)
        if self.state.mode == STOPPED:
            return self.step(now, joints)
        self.felt, motion, torque = self._probing.step(self.felt, now, joints)
        self.over = self.felt.over
        self.mode = DONE if self.over else PROBING
        return motion, torque

    def stop(self, joints: Joints, reason: str) -> None:
        """On request: the fingers hold the object where that is possible."""
        self.state = self._switch.stop(self.state, joints, reason, hold=True)
        self.mode, self._ended = STOPPED, None

    @property
    def ramp(self) -> float:
        """[s] from the first step to the start of the trajectory."""
        return self._switch.options.ramp

    @property
    def reason(self) -> str:
        """Why it stopped, '' when it did not."""
        return self.state.reason

    @property
    def shown(self) -> str:
        """The mode; done as soon as the trajectory is at its end, even while settling there."""
        return self.mode if self.felt is not None else self.state.mode

    @property
    def progress(self) -> float:
        """Share of the trajectory that is done, 0 to 1."""
        return self.state.progress

    @property
    def pairs(self) -> tuple[np.ndarray, ...]:
        """Pairs of angles (2,) [rad] that the probe has measured so far."""
        return () if self.felt is None else self.felt.pairs

    @property
    def interrupted(self) -> str:
        """Why the probe ended before its end, '' when it did not."""
        if self.felt is not None and self.felt.reason:
            return self.felt.reason
        return self.state.reason if self.felt is not None and self.state.mode == STOPPED else ''

    @property
    def in_band(self) -> bool:
        """Whether both fingers are known to have kept to the trajectory's band to its end."""
        known = self.trajectory.band is not None and self.state.progress >= 1.0
        return known and not self.state.deviated

    @property
    def deviated(self) -> str:
        """Where and how the fingers left the trajectory's band, '' when they did not."""
        return self._switch.deviation(self.state)

    @property
    def course(self) -> np.ndarray:
        """(r, 2) [rad] both angles every COURSE_PERIOD from the trajectory's start to the probe."""
        return np.array(self._course).reshape(-1, 2)

    @property
    def time_left(self) -> float:
        """[s] until done, the probe not counted."""
        return max(0.0, self.trajectory.duration - self.state.elapsed + self._settle)
