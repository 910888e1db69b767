"""Checks of the start, and of a goal given as a pose: no penetration, an object within reach.

Each problem is reported as 'key: got ...; allowed: ...'.
"""

import numpy as np

from wholearm_ros.model.convex import rectangle, separation, turned
from wholearm_ros.model.hand import LEFT, SIDES
from wholearm_ros.model.orientation import palm_angle_under, start_rotation
from wholearm_ros.model.scenario import GoalAtPose, Scenario, StartAtPose

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
    angle = start_rotation(scenario)
    corners = turned(
        scenario.object.polygon.vertices_about_centroid, np.array([start.x, 0.0, angle])
    )
    # lowered along y until the first corner meets the line of the palm's segment under the centroid
    slope = np.tan(palm_angle_under(scenario.palm, start.x))
    lift = (slope * (corners[:, 0] - start.x) - corners[:, 1]).max()
    return np.array([start.x, lift + palm_height(scenario.palm.vertices, start.x), angle])


def palm_height(vertices: np.ndarray, x: float) -> float:
    """y [m] of the palm's polyline at x."""
    return float(np.interp(x, vertices[:, 0], vertices[:, 1]))


def _palm_penetration(key: str, scenario: Scenario, pose: np.ndarray) -> str | None:
    corners = turned(scenario.object.polygon.vertices_about_centroid, pose)
    palm = scenario.palm.vertices
    over = (corners[:, 0] >= palm[0, 0]) & (corners[:, 0] <= palm[-1, 0])
    depths = [palm_height(palm, x) - y for x, y in corners[over]]
    depth = max(depths + [_depth_of(p, corners) for p in palm])
    if depth > MAX_PENETRATION:
        return (
            f'{key}: got an object that penetrates the palm by {1e3 * depth:.2f} mm; '
            f'allowed: at most {1e3 * MAX_PENETRATION} mm'
        )
    return None


def _depth_of(point: np.ndarray, polygon: np.ndarray) -> float:
    """How deep [m] a point is in a convex polygon; negative outside."""
    edges = np.roll(polygon, -1, axis=0) - polygon
    inward = np.stack([-edges[:, 1], edges[:, 0]], axis=1) / np.linalg.norm(edges, axis=1)[:, None]
    return float((inward * (point - polygon)).sum(axis=1).min())


def _finger_separation(
    scenario: Scenario, pose: np.ndarray, side: int, angle: np.ndarray
) -> np.ndarray:
    finger = scenario.hand[side]
    corners = turned(scenario.object.polygon.vertices_about_centroid, pose)
    return separation(corners, rectangle(finger.axis, angle, finger.length, finger.half_width))


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
    depth = -_finger_separation(scenario, pose, side, angle)
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
    gaps = _finger_separation(scenario, pose, side, np.linspace(opened, shut, SWEEP))
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
