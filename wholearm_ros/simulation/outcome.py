"""Whether a run did what the scenario asked for, judged on the truth after the run."""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.mechanics.contacts import pose_on_palm
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.orientation import goal_rotation, palm_angle_under, palm_segment_under
from wholearm_ros.model.scenario import GoalAtPose, Scenario
from wholearm_ros.simulation.closed_loop import RunRecord

ANGLE_TOLERANCE = 0.03  # [rad] from the goal's rotation
X_TOLERANCE = 0.01  # [m] from the goal's x, when it has one without a tolerance of its own
GAP_TOLERANCE = 0.0015  # [m] between the object and the palm
REST_SPEED = 0.01  # [m/s] of the centroid; slower is at rest
REST_TURNING = 0.1  # [rad/s]; slower is at rest
REST_TIME = 0.1  # [s] at the end of the run, over whose mean both are taken


@dataclass(frozen=True, eq=False)
class Outcome:
    """executed: the object rests at its goal; reason: the first thing that is missing, '' when nothing is.

    pose (3,) [m, m, rad] at the end; angle_error [rad], x_error [m] (0 when no x is asked for), gap [m] to the palm,
    speed [m/s], turning [rad/s].
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
    """The judgement of `record`; angles and the palm's gap are those of the true object (`record.truth`)."""
    truth, pose = record.truth, record.poses[-1]
    still = record.times >= record.times[-1] - REST_TIME
    velocity = (record.poses[still][-1] - record.poses[still][0]) / (
        record.times[still][-1] - record.times[still][0]
    )
    speed, turning = float(np.hypot(*velocity[:2])), abs(float(velocity[2]))
    angle_error = float(pose[2] - goal_rotation(truth))
    gap = palm_gap(truth, pose)
    x_error, missing = _missing(truth, pose, angle_error, gap)
    if speed > REST_SPEED or turning > REST_TURNING:
        missing.append(f'the object still moves: {speed:.3f} m/s, {turning:.3f} rad/s')
    if missing and record.reason:
        missing.insert(0, f'stopped: {record.reason}')
    return Outcome(
        not missing, '; '.join(missing), pose.copy(), angle_error, x_error, gap, speed, turning
    )


def palm_gap(scenario: Scenario, pose: np.ndarray) -> float:
    """Distance [m] of the object's lowest vertex from the palm under its centroid."""
    segment = palm_segment_under(scenario.palm, pose[0])
    lying = pose_on_palm(build_world(scenario), pose[0], pose[2], segment)
    return float((pose[1] - lying[1]) * np.cos(palm_angle_under(scenario.palm, pose[0])))


def _missing(truth: Scenario, pose: np.ndarray, angle_error: float, gap: float):
    goal = truth.goal
    if isinstance(goal, GoalAtPose):
        errors = pose - goal.pose
        words = [
            f'{name} is off by {e:+.4f}; allowed: {t}'
            for name, e, t in zip(('x', 'y', 'rotation'), errors, goal.tolerance)
            if abs(e) > t
        ]
        return float(errors[0]), words
    words = []
    if abs(angle_error) > ANGLE_TOLERANCE:
        words.append(f'rotation is off by {angle_error:+.3f} rad; allowed: {ANGLE_TOLERANCE}')
    if abs(gap) > GAP_TOLERANCE:
        words.append(
            f'the object is {1e3 * gap:.2f} mm above the palm; allowed: {1e3 * GAP_TOLERANCE}'
        )
    x_error = 0.0 if goal.x is None else float(pose[0] - goal.x)
    allowed = X_TOLERANCE if goal.x_tolerance is None else goal.x_tolerance
    if abs(x_error) > allowed:
        words.append(f'x is off by {x_error:+.4f} m; allowed: {allowed}')
    return x_error, words
