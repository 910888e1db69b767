"""Checks of the start, and of a goal given as a pose: no penetration, an object within reach.

Each problem is reported as 'key: got ...; allowed: ...'.
"""

import numpy as np

from wholearm_ros.model.frame import Value, frame_at, placed
from wholearm_ros.model.hand import LEFT, SIDES
from wholearm_ros.model.orientation import palm_segment_under, start_rotation
from wholearm_ros.model.polygon import edge_table, pose_on_edge
from wholearm_ros.model.scenario import GoalAtPose, Scenario, StartAtPose
from wholearm_ros.model.separation import part_clearance, point_clearance

MAX_PENETRATION = 1e-4  # [m] at the start
SWEEP = 181  # angles at which a closing finger is looked at


def problems_at_start(scenario: Scenario) -> list[str]:
    """Penetration and reach at the start, and at a goal given as a pose."""
    pose = start_pose(scenario)
    problems = [_palm_penetration('start', scenario, pose)]
    problems += [_reach_problem(scenario, pose, side) for side in range(2)]
    start, goal = scenario.start, scenario.goal
    if isinstance(start, StartAtPose):
        problems += [_finger_penetration(scenario, start, pose, side) for side in range(2)]
    if isinstance(goal, GoalAtPose):
        problems.append(_palm_penetration('goal', scenario, goal.pose))
    return [p for p in problems if p]


def start_pose(scenario: Scenario) -> np.ndarray:
    """(3,) centroid x, y [m] and rotation [rad] at the start."""
    start = scenario.start
    if isinstance(start, StartAtPose):
        return start.pose
    vertices, palm = scenario.object.polygon.vertices_about_centroid, scenario.palm
    segment = edge_table(palm.vertices, closed=False)[palm_segment_under(palm, start.x)]
    return pose_on_edge(vertices, segment, start.x, start_rotation(scenario))


def palm_height(vertices: np.ndarray, x: float) -> float:
    """y [m] of the palm's polyline at x."""
    return float(np.interp(x, vertices[:, 0], vertices[:, 1]))


def palm_clearance(scenario: Scenario, pose: np.ndarray) -> float:
    """Between the palm and the object at `pose` (3,) [m]; negative where it penetrates."""
    vertices, palm = scenario.object.polygon.vertices_about_centroid, scenario.palm.vertices
    corners, edges = placed(vertices, pose), edge_table(vertices, closed=True)
    over = (corners[:, 0] >= palm[0, 0]) & (corners[:, 0] <= palm[-1, 0])
    heights = [y - palm_height(palm, x) for x, y in corners[over]]
    return float(min(heights + [point_clearance(edges, frame_at(*pose), *p)[0] for p in palm]))


def floating(key: str, scenario: Scenario, pose: np.ndarray, allowed: float) -> str | None:
    """The problem of an object at `pose` (3,) more than `allowed` [m] above the palm, if it is."""
    height = palm_clearance(scenario, pose)
    if height > allowed:
        return (
            f'{key}: got an object {1e3 * height:.2f} mm above the palm; '
            f'allowed: at most {1e3 * allowed:g} mm'
        )
    return None


def _palm_penetration(key: str, scenario: Scenario, pose: np.ndarray) -> str | None:
    depth = -palm_clearance(scenario, pose)
    if depth > MAX_PENETRATION:
        return (
            f'{key}: got an object that penetrates the palm by {1e3 * depth:.2f} mm; '
            f'allowed: at most {1e3 * MAX_PENETRATION} mm'
        )
    return None


def _finger_clearance(scenario: Scenario, pose: np.ndarray, side: int, angle: Value) -> Value:
    """Separation [m] of a finger at angles [rad] and the object at `pose` (3,)."""
    finger = scenario.hand[side]
    edges = edge_table(scenario.object.polygon.vertices_about_centroid, closed=True)
    at = frame_at(finger.axis[0], finger.axis[1], angle)
    parts = [edge_table(part, closed=True) for part in finger.shape.parts]
    gaps = [part_clearance(edges, frame_at(*pose), part, at) for part in parts]
    return np.min(gaps, axis=0)


def _finger_penetration(
    scenario: Scenario, start: StartAtPose, pose: np.ndarray, side: int
) -> str | None:
    key, (low, high), angle = (
        f'start.fingers[{side}]',
        scenario.hand[side].angle_limits,
        start.fingers[side],
    )
    if not low <= angle <= high:
        return (
            f'{key}: got {angle}; allowed: {low} to {high}, the limits of the {SIDES[side]} finger'
        )
    depth = -_finger_clearance(scenario, pose, side, angle)
    if depth > MAX_PENETRATION:
        return (
            f'{key}: got {angle}, where the {SIDES[side]} finger penetrates the object by '
            f'{1e3 * depth:.2f} mm; '
            f'allowed: at most {1e3 * MAX_PENETRATION} mm'
        )
    return None


def _reach_problem(scenario: Scenario, pose: np.ndarray, side: int) -> str | None:
    """A finger, swept closed from its open limit, must start clear of the object and meet it."""
    low, high = scenario.hand[side].angle_limits
    opened, shut = (high, low) if side == LEFT else (low, high)
    gaps = _finger_clearance(scenario, pose, side, np.linspace(opened, shut, SWEEP))
    if gaps.min() > 0.0:
        return (
            f'hand.{SIDES[side]}: got a finger that cannot touch the object at the start (nearest '
            f'{1e3 * gaps.min():.1f} mm, between {low} and {high} rad); '
            'allowed: an object within its reach'
        )
    if gaps[0] <= 0.0:
        return (
            f'hand.{SIDES[side]}: got a finger that meets the object even when open ({opened} '
            'rad); '
            'allowed: an object that lies between the open fingers'
        )
    return None
