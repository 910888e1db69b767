"""Verification: a candidate trajectory run through our own forward dynamics, on the nominal and on
perturbed samples.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from wholearm_ros.control.mode_switch import course_of
from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.model.configuration import POSE, ROTATION
from wholearm_ros.model.hand import SIDES
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.rollout.parallel import parallel_map
from wholearm_ros.rollout.perturbed_samples import (
    PerturbedSample,
    Run,
    follow_course,
    start_at_rest,
)

SETTLE = 0.3  # [s] of holding after the trajectory's end
MARGIN = 1.0 / 3.0  # of the goal's tolerances that a simulated run must leave
MOST_BEYOND = (
    0.15  # [rad] past the goal on the way: what comes down faster may go on to the next edge
)
STOP_USED = 0.02  # [rad] a plan that brings a finger as near to its end stop makes use of it
REST_SPEED = 0.005  # [m/s] of the centroid at the end


@dataclass(frozen=True, eq=False)
class Rollout:
    """One sample's run: times (r,) [s], configurations (r, 5), whether the object rests at its
    goal, and why not.
    """

    times: np.ndarray
    configurations: np.ndarray
    success: bool
    reason: str
    residual: float


@dataclass(frozen=True)
class Verification:
    """The first rollout is the nominal one, the others are perturbed; `asked` were to be run, and
    rollouts that were not run, as the candidate had failed already, count as failed.
    """

    rollouts: tuple[Rollout, ...]
    asked: int

    @property
    def success_rate(self) -> float:
        """Share of the rollouts that end at the goal."""
        return sum(r.success for r in self.rollouts) / self.asked

    @property
    def nominal(self) -> Rollout:
        """Of the nominal sample."""
        return self.rollouts[0]

    def reasons(self) -> list[str]:
        """Why rollouts failed."""
        return [r.reason for r in self.rollouts if r.reason]

    def to_dict(self) -> dict[str, Any]:
        """The JSON object that a trajectory document holds."""
        return {
            'copies': self.asked,
            'survived': sum(r.success for r in self.rollouts),
            'reasons': self.reasons(),
            'lcp_residual': max(r.residual for r in self.rollouts),
        }


def verify(
    trajectory: ManipulationTrajectory,
    samples: Sequence[PerturbedSample],
    controls: ControlOptions = ControlOptions(),
) -> Verification:
    """Roll the trajectory out on every sample, the nominal one first."""
    return Verification(tuple(rollouts(trajectory, samples, controls)), len(samples))


def rollouts(
    trajectory: ManipulationTrajectory,
    samples: Sequence[PerturbedSample],
    controls: ControlOptions,
) -> Iterator[Rollout]:
    """In the order of the samples, the first one alone: most candidates fail it."""
    yield from parallel_rollouts(trajectory, samples[:1], controls)
    yield from parallel_rollouts(trajectory, samples[1:], controls)


def parallel_rollouts(
    trajectory: ManipulationTrajectory,
    samples: Sequence[PerturbedSample],
    controls: ControlOptions,
) -> Iterator[Rollout]:
    """In the order of the samples, as many at once as there are processors."""
    return parallel_map(partial(roll_out, trajectory, controls=controls), samples)


def roll_out(
    trajectory: ManipulationTrajectory, sample: PerturbedSample, controls: ControlOptions
) -> Rollout:
    """One sample under the closed loop of control/, simulated by the LCP time stepping."""
    run = follow_course(sample, course_of(trajectory), start_at_rest(sample), controls, SETTLE)
    reason = _stopped(run, controls) or _stop_met(trajectory, sample, run) or _missing(sample, run)
    return Rollout(run.times, run.configurations, not reason, reason, run.residual)


def most_beyond(sample: PerturbedSample, run: Run) -> float:
    """How far past its goal the object turned on the way [rad], negative if it never did."""
    turn = np.sign(sample.goal.rotation - sample.start[ROTATION])
    return float((turn * (run.configurations[:, ROTATION] - sample.goal.rotation)).max())


def _stopped(run: Run, controls: ControlOptions) -> str:
    """Why the mode switch stopped the run, '' when it did not."""
    if not run.stopped:
        return ''
    return (
        f'stopped: tracking error of the velocity-controlled finger is '
        f'{run.switch.error:+.3f} rad; '
        f'allowed: {controls.max_tracking_error} rad'
    )


def _stop_met(trajectory: ManipulationTrajectory, sample: PerturbedSample, run: Run) -> str:
    """Why a run fails whose finger came to bear on an end stop to which the plan does not bring
    it; '' when none did.
    """
    for side, end in zip(*np.nonzero(run.stops_met)):
        stop = sample.world.limits[side, end]
        if np.abs(trajectory.angles[:, side] - stop).min() > STOP_USED:
            return f'the {SIDES[side]} finger came to its end stop at {stop:.3f} rad'
    return ''


def _missing(sample: PerturbedSample, run: Run) -> str:
    """Why a run does not count as one that reached the goal, '' when it does."""
    missing = sample.goal.missing(run.q[POSE], MARGIN)
    if missing:
        return missing[0]
    beyond = most_beyond(sample, run)
    if beyond > MOST_BEYOND:
        return f'it turned {beyond:.3f} rad past its goal on the way'
    speed = np.hypot(run.v[0], run.v[1])
    return f'the object still moves at {speed:.3f} m/s' if speed > REST_SPEED else ''
