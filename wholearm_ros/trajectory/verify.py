"""Verification: a candidate trajectory run through our own forward dynamics, as told and in perturbed copies."""
from dataclasses import dataclass

import numpy as np

from ..control.setpoints import ControlOptions
from ..kernels import stepping
from ..mechanics.world import World, build_world
from ..model.scenario import GoalAtPose, Scenario
from ..model.task import goal_rotation
from ..model.trajectory import ManipulationTrajectory
from ..simulation.perturbation import NOMINAL, Perturbation, draw_perturbation
from ..simulation.start import settled_start

STEP = 0.001           # [s]
SETTLE = 0.3           # [s] of holding after the trajectory's end
ANGLE_TOLERANCE = 0.02  # [rad] from the goal's rotation; less than a run is allowed
REST_SPEED = 0.005     # [m/s] of the centroid at the end
RECORD_EVERY = 0.02    # [s]


@dataclass(frozen=True, eq=False)
class Copy:
    """The hand and object as they might truly be: its arrays, start (5,), goal rotation [rad] and actuation."""

    world: World
    start: np.ndarray
    goal_angle: float
    perturbation: Perturbation


@dataclass(frozen=True, eq=False)
class Trial:
    """One copy's run: times (r,) [s], configurations (r, 5), whether the object rests at its goal, and why not."""

    times: np.ndarray
    configurations: np.ndarray
    success: bool
    reason: str
    residual: float


@dataclass(frozen=True)
class Verification:
    """The first trial is of the copy that is as told, the others are perturbed; `asked` were to be run, and trials that
    were not run, as the candidate had failed already, count as failed."""

    trials: tuple
    asked: int

    @property
    def survived(self) -> float:
        """Share of the trials that end at the goal."""
        return sum(t.success for t in self.trials) / self.asked

    @property
    def nominal(self) -> Trial:
        return self.trials[0]

    def reasons(self) -> list:
        """Why trials failed."""
        return [t.reason for t in self.trials if t.reason]

    def to_dict(self) -> dict:
        return {'copies': self.asked, 'survived': sum(t.success for t in self.trials), 'reasons': self.reasons(),
                'lcp_residual': max(t.residual for t in self.trials)}


def build_copies(scenario: Scenario, count: int, level: float, seed: int) -> tuple:
    """The scenario as told, and `count` perturbed copies of it at `level` (see Perturbation), always the same."""
    rng = np.random.default_rng(seed)
    drawn = (NOMINAL, *(draw_perturbation(rng, level, scenario) for _ in range(count)))
    return tuple(_copy(scenario, p) for p in drawn)


def _copy(scenario, perturbation):
    truth = perturbation.applied(scenario)
    return Copy(build_world(truth), settled_start(scenario, truth), goal_rotation(truth), perturbation)


def verify(trajectory: ManipulationTrajectory, scenario: Scenario, copies: tuple,
           controls: ControlOptions = ControlOptions()) -> Verification:
    """Run every copy."""
    return Verification(tuple(run_trial(trajectory, scenario, copy, controls) for copy in copies), len(copies))


def run_trial(trajectory: ManipulationTrajectory, scenario: Scenario, copy: Copy, controls: ControlOptions) -> Trial:
    """One copy under the closed loop of control/, simulated by the LCP time stepping."""
    w, p = copy.world, copy.perturbation
    every = int(round(RECORD_EVERY / STEP))
    settle = int(round(SETTLE / STEP))
    size = int(trajectory.duration / RECORD_EVERY + SETTLE / RECORD_EVERY) + 4
    q, v = copy.start.copy(), np.zeros(5)
    qs, vs = np.empty((size, 5)), np.empty((size, 5))
    count, residual = stepping.run_trajectory(
        *w.geometry, w.corners, w.inertias, w.load, w.finger_moment, w.torque_limits, p.friction, p.torque_factors,
        int(round(p.actuation_delay / STEP)), controls.gains.kp, controls.gains.kd, STEP, trajectory.period,
        trajectory.angles, trajectory.velocities, trajectory.efforts, velocity_fingers(trajectory), settle,
        q, v, every, qs, vs)
    reason = _missing(scenario, copy, q, v)
    times = RECORD_EVERY * np.arange(count)
    return Trial(times, qs[:count], not reason, reason, residual)


def velocity_fingers(trajectory: ManipulationTrajectory) -> np.ndarray:
    """(m,) the velocity-controlled finger from each sample on."""
    ends = np.array([s.end for s in trajectory.segments])
    sides = np.array([s.velocity_finger for s in trajectory.segments])
    place = np.searchsorted(ends, trajectory.times + 1e-9, side='right')
    return sides[np.minimum(place, len(sides) - 1)]


def _missing(scenario, copy, q, v):
    error = q[2] - copy.goal_angle
    if abs(error) > ANGLE_TOLERANCE:
        return f'rotation is off by {error:+.3f} rad'
    if np.hypot(v[0], v[1]) > REST_SPEED:
        return f'the object still moves at {np.hypot(v[0], v[1]):.3f} m/s'
    goal = scenario.goal
    x = goal.pose[0] if isinstance(goal, GoalAtPose) else goal.x
    if x is not None:
        allowed = goal.tolerance[0] if isinstance(goal, GoalAtPose) else goal.x_tolerance or 0.01
        if abs(q[0] - x) > allowed:
            return f'x is off by {q[0] - x:+.4f} m'
    return ''
