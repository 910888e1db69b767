"""Verification: a candidate trajectory run through our own forward dynamics, as told and in perturbed copies."""

from dataclasses import dataclass
from functools import partial
from typing import Iterator

import numpy as np

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.model.scenario import GoalAtPose, Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.rollout.parallel import parallel_map
from wholearm_ros.rollout.perturbed_samples import PerturbedSample, follow_setpoints

SETTLE = 0.3  # [s] of holding after the trajectory's end
ANGLE_TOLERANCE = 0.02  # [rad] from the goal's rotation; less than a run is allowed
MOST_BEYOND = 0.15  # [rad] past the goal on the way: an object that comes down faster may go on to the next edge
REST_SPEED = 0.005  # [m/s] of the centroid at the end


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
        return {
            'copies': self.asked,
            'survived': sum(t.success for t in self.trials),
            'reasons': self.reasons(),
            'lcp_residual': max(t.residual for t in self.trials),
        }


def verify(
    trajectory: ManipulationTrajectory,
    scenario: Scenario,
    copies: tuple,
    controls: ControlOptions = ControlOptions(),
) -> Verification:
    """Run every copy."""
    return Verification(tuple(run_trials(trajectory, scenario, copies, controls)), len(copies))


def run_trials(
    trajectory: ManipulationTrajectory, scenario: Scenario, copies: tuple, controls: ControlOptions
) -> Iterator[Trial]:
    """The trials in the order of their copies, the first one alone: most candidates fail it."""
    yield from run_trials_at_once(trajectory, scenario, copies[:1], controls)
    yield from run_trials_at_once(trajectory, scenario, copies[1:], controls)


def run_trials_at_once(
    trajectory: ManipulationTrajectory, scenario: Scenario, copies: tuple, controls: ControlOptions
) -> Iterator[Trial]:
    """The trials in the order of their copies, as many at once as there are processors."""
    return parallel_map(partial(run_trial, trajectory, scenario, controls=controls), copies)


def run_trial(
    trajectory: ManipulationTrajectory,
    scenario: Scenario,
    copy: PerturbedSample,
    controls: ControlOptions,
) -> Trial:
    """One copy under the closed loop of control/, simulated by the LCP time stepping."""
    run = follow_setpoints(
        copy,
        copy.start,
        np.zeros(5),
        trajectory.period,
        trajectory.angles,
        trajectory.velocities,
        trajectory.efforts,
        velocity_fingers(trajectory),
        controls.gains,
        SETTLE,
    )
    reason = _missing(scenario, copy, run)
    return Trial(run.times, run.configurations, not reason, reason, run.residual)


def velocity_fingers(trajectory: ManipulationTrajectory) -> np.ndarray:
    """(m,) the velocity-controlled finger from each sample on."""
    ends = np.array([s.end for s in trajectory.segments])
    sides = np.array([s.velocity_finger for s in trajectory.segments])
    place = np.searchsorted(ends, trajectory.times + 1e-9, side='right')
    return sides[np.minimum(place, len(sides) - 1)]


def _missing(scenario, copy, run):
    q, v = run.q, run.v
    error = q[2] - copy.goal_angle
    if abs(error) > ANGLE_TOLERANCE:
        return f'rotation is off by {error:+.3f} rad'
    turn = np.sign(copy.goal_angle - copy.start[2])
    beyond = (turn * (run.configurations[:, 2] - copy.goal_angle)).max()
    if beyond > MOST_BEYOND:
        return f'it turned {beyond:.3f} rad past its goal on the way'
    if np.hypot(v[0], v[1]) > REST_SPEED:
        return f'the object still moves at {np.hypot(v[0], v[1]):.3f} m/s'
    goal = scenario.goal
    x = goal.pose[0] if isinstance(goal, GoalAtPose) else goal.x
    if x is not None:
        allowed = goal.tolerance[0] if isinstance(goal, GoalAtPose) else goal.x_tolerance or 0.01
        if abs(q[0] - x) > allowed:
            return f'x is off by {q[0] - x:+.4f} m'
    return ''
