"""Whether a run did what the scenario asked for, judged on the truth after the run."""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.model.goal import goal_region
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.simulation.closed_loop import RunRecord

REST_SPEED = 0.01  # [m/s] of the centroid; slower is at rest
REST_TURNING = 0.1  # [rad/s]; slower is at rest
REST_TIME = 0.1  # [s] at the end of the run, over whose mean both are taken


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a run achieved.

    executed: the object rests at its goal; reason: what is missing, '' when nothing is; at the end:
    pose (3,) [m, m, rad], angle_error [rad], x_error [m] (0 when no x is asked for), gap [m] to the
    palm, speed [m/s], turning [rad/s].
    """

    executed: bool
    reason: str
    pose: np.ndarray
    angle_error: float
    x_error: float
    gap: float
    speed: float
    turning: float


def outcome(scenario: Scenario, record: RunRecord) -> Outcome:
    """The judgement of `record`, on the true object (`record.truth`)."""
    goal, pose = goal_region(record.truth), record.poses[-1]
    missing = goal.missing(pose)
    speed, turning = _speeds_at_end(record)
    if not (speed <= REST_SPEED and turning <= REST_TURNING):
        missing.append(f'the object still moves: {speed:.3f} m/s, {turning:.3f} rad/s')
    if missing and record.reason:
        missing.insert(0, f'stopped: {record.reason}')
    x_error, _, angle_error = goal.error(pose)
    return Outcome(
        executed=not missing,
        reason='; '.join(missing),
        pose=pose.copy(),
        angle_error=float(angle_error),
        x_error=float(x_error),
        gap=goal.height(pose),
        speed=speed,
        turning=turning,
    )


def palm_gap(scenario: Scenario, pose: np.ndarray) -> float:
    """Distance [m] of the object's lowest vertex from the palm under its centroid."""
    return goal_region(scenario).height(pose)


def _speeds_at_end(record: RunRecord) -> tuple[float, float]:
    """Mean speed [m/s] and rate of turning [rad/s] over the last REST_TIME.

    Over the last two records if those lie further apart; infinite when there is but one.
    """
    if len(record.times) < 2:
        return np.inf, np.inf
    first = min(
        int(np.searchsorted(record.times, record.times[-1] - REST_TIME)), len(record.times) - 2
    )
    velocity = (record.poses[-1] - record.poses[first]) / (record.times[-1] - record.times[first])
    return float(np.hypot(*velocity[:2])), abs(float(velocity[2]))
