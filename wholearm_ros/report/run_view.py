"""A run as figures and reports need it, wherever it came from: a simulation, or a bag."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.hand import CLOSING
from wholearm_ros.model.modes import IDLE, QUASI_STATIC
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.simulation.closed_loop import RunRecord
from wholearm_ros.simulation.outcome import Outcome, outcome


@dataclass(frozen=True, eq=False)
class RunView:
    """times (m,) [s] on the trajectory's clock: 0 is its start, negative while the setpoints are
    ramped in.

    angles, velocities, efforts (m, 2) [rad, rad/s, N m], left then right; poses (m, 3) the truth
    [m, m, rad], NaN where it is not known; modes (m,) names; judged: of the end, None when the
    truth is not known; reason: why the run stopped; facts: what else is known of it, name → text,
    in the order in which it is shown; estimates (m, 3): the object as the observer took it to be,
    NaN where it did not know, None where nobody listened to it.
    """

    times: np.ndarray
    angles: np.ndarray
    velocities: np.ndarray
    efforts: np.ndarray
    poses: np.ndarray
    modes: tuple[str, ...]
    judged: Outcome | None = None
    reason: str = ''
    facts: dict[str, Any] = field(default_factory=dict)
    estimates: np.ndarray | None = None

    def __post_init__(self) -> None:
        for name, width in (('angles', 2), ('velocities', 2), ('efforts', 2)):
            object.__setattr__(self, name, readonly(getattr(self, name), (-1, width)))

    def until(self, time: float) -> 'RunView':
        """Its beginning, up to `time` [s]."""
        m = max(1, int(np.searchsorted(self.times, time, side='right')))
        rows = ('times', 'angles', 'velocities', 'efforts', 'poses', 'modes', 'estimates')
        cut: dict[str, Any] = {k: v[:m] for k in rows if (v := getattr(self, k)) is not None}
        return replace(self, **cut)

    def pose_at(self, times: np.ndarray) -> np.ndarray:
        """(k, 3) the object at `times` [s], held beyond both ends."""
        return np.column_stack([np.interp(times, self.times, self.poses[:, k]) for k in range(3)])

    def angles_at(self, times: np.ndarray) -> np.ndarray:
        """(k, 2) joint angles at `times` [s]."""
        return np.column_stack([np.interp(times, self.times, self.angles[:, k]) for k in range(2)])


def view_of(
    record: RunRecord,
    scenario: Scenario,
    controls: ControlOptions = ControlOptions(),
    facts: dict[str, Any] | None = None,
) -> RunView:
    """The view of a run made without ROS; its first row is where the mode switch began."""
    started = next((k for k, mode in enumerate(record.modes) if mode != IDLE), 0)
    times = record.times - record.times[started] - controls.ramp
    return RunView(
        times,
        record.angles,
        record.velocities,
        record.efforts,
        record.poses,
        record.modes,
        outcome(scenario, record),
        record.reason,
        dict(facts or {}),
    )


@dataclass(frozen=True, eq=False)
class Controlled:
    """Planned and executed side by side at the run's instants, (m,) each: the torque-controlled
    finger's `side` and pressing torques [N m], the velocity-controlled finger's angles [rad];
    torque_range (m, 2), NaN where there is none: out of quasi-static motion, and where no torque
    bears the object.
    """

    torque_side: np.ndarray
    planned_torque: np.ndarray
    torque: np.ndarray
    torque_range: np.ndarray
    planned_angle: np.ndarray
    angle: np.ndarray

    @property
    def angle_error(self) -> np.ndarray:
        """(m,) [rad]."""
        error: np.ndarray = self.angle - self.planned_angle
        return error


def controlled(trajectory: ManipulationTrajectory, run: RunView) -> Controlled:
    """Torques are pressing torques: positive towards the other finger, whichever finger it is."""
    segments = trajectory.segments
    ends = np.array([s.end for s in segments])
    place = np.minimum(np.searchsorted(ends, run.times, side='right'), len(ends) - 1)
    t_side = np.array([s.torque_finger for s in segments])[place]
    rows = np.arange(len(run.times))
    sign = np.array(CLOSING)[t_side]
    planned, planned_angles = setpoints_at(trajectory, run.times)
    held = np.clip(run.times, 0.0, trajectory.duration)
    # The sample where two segments meet belongs to neither's range.
    first = np.array([s.start for s in segments])[place]
    at = np.maximum(
        (held / trajectory.period + 1e-6).astype(int),
        (first / trajectory.period + 1e-6).astype(int) + 1,
    )
    at = np.minimum(at, len(trajectory.angles) - 1)
    limits = np.where(
        sign[:, None] > 0, trajectory.torque_ranges[at], -trajectory.torque_ranges[at][:, ::-1]
    )
    limits[
        np.array([s.mode != QUASI_STATIC for s in segments])[place] | (limits[:, 0] > limits[:, 1])
    ] = np.nan
    return Controlled(
        t_side,
        sign * planned[rows, t_side],
        sign * run.efforts[rows, t_side],
        limits,
        planned_angles[rows, 1 - t_side],
        run.angles[rows, 1 - t_side],
    )


def setpoints_at(
    trajectory: ManipulationTrajectory, times: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(efforts (k, 2) [N m], angles (k, 2) [rad]) as ManipulationTrajectory.sample gives them, for
    many instants.
    """
    held = np.clip(times, 0.0, trajectory.duration)
    efforts = np.column_stack(
        [np.interp(held, trajectory.times, trajectory.efforts[:, k]) for k in range(2)]
    )
    angles = CubicHermiteSpline(trajectory.times, trajectory.angles, trajectory.velocities)
    return efforts, angles(held)


def errors(trajectory: ManipulationTrajectory, run: RunView) -> dict[str, tuple[float, str]]:
    """name → (value, unit) of a run's accuracy, over the time of the trajectory."""
    shown = (run.times >= 0.0) & (run.times <= trajectory.duration)
    if not shown.any():
        return {}
    both = controlled(trajectory, run)
    told = {
        'velocity finger, largest error': (
            1e3 * float(np.abs(both.angle_error[shown]).max()),
            'mrad',
        ),
        'velocity finger, RMS error': (
            1e3 * float(np.sqrt((both.angle_error[shown] ** 2).mean())),
            'mrad',
        ),
        'torque finger, RMS difference to the plan': (
            float(np.sqrt(((both.torque - both.planned_torque)[shown] ** 2).mean())),
            'N m',
        ),
    }
    if np.isfinite(run.poses).all():
        away = run.poses[shown] - planned_poses_at(trajectory, run.times[shown])
        told['object, largest distance to the plan'] = (
            1e3 * float(np.hypot(away[:, 0], away[:, 1]).max()),
            'mm',
        )
        told['object, largest rotation from the plan'] = (float(np.abs(away[:, 2]).max()), 'rad')
    return told


def planned_poses_at(trajectory: ManipulationTrajectory, times: np.ndarray) -> np.ndarray:
    """(k, 3) the object as planned; in caging and dynamic motion a guess, the object is not held to
    it there.
    """
    return np.column_stack(
        [np.interp(times, trajectory.times, trajectory.poses[:, k]) for k in range(3)]
    )
