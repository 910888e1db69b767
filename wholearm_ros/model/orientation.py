"""Orientation of the object at the start and at the goal of a scenario."""

from dataclasses import replace

import numpy as np

from wholearm_ros.model.hand import Palm
from wholearm_ros.model.scenario import CCW, CW, GoalAtPose, Scenario, StartAtPose

SAME_ANGLE = 1e-9  # [rad] smaller rotations count as none


def palm_segment_under(palm: Palm, x: float) -> int:
    """Index of the palm's segment at `x` [m]; beyond the ends of the polyline, the nearest one."""
    v = palm.vertices
    for k in range(len(v) - 1):
        if min(v[k, 0], v[k + 1, 0]) <= x <= max(v[k, 0], v[k + 1, 0]):
            return k
    return 0 if abs(x - v[0, 0]) <= abs(x - v[-1, 0]) else len(v) - 2


def palm_angle_under(palm: Palm, x: float) -> float:
    """Direction of that segment [rad], 0 for a palm along +x."""
    k = palm_segment_under(palm, x)
    dx, dy = palm.vertices[k + 1] - palm.vertices[k]
    return float(np.arctan2(dy, dx))


def start_rotation(scenario: Scenario) -> float:
    """Rotation of the object's file axes at the start [rad]."""
    start = scenario.start
    if isinstance(start, StartAtPose):
        return float(start.pose[2])
    return scenario.object.polygon.resting_angle(start.edge) + palm_angle_under(
        scenario.palm, start.x
    )


def goal_rotation(scenario: Scenario) -> float:
    """Rotation of the object's file axes at the goal [rad], not wrapped.

    For a goal on an edge: the start's rotation plus the smallest turn (0, 2π] in the goal's
    direction that lays that edge on the palm, under the goal's x if it has one, else under the
    start's; without a direction the shorter turn, none if that edge lies there already.
    """
    goal, begin = scenario.goal, start_rotation(scenario)
    if isinstance(goal, GoalAtPose):
        return float(goal.pose[2])
    x = goal.x if goal.x is not None else start_x(scenario)
    rest = scenario.object.polygon.resting_angle(goal.edge) + palm_angle_under(scenario.palm, x)
    if goal.direction is None:
        return begin + _shorter_turn(rest - begin)
    sign = 1.0 if goal.direction == CCW else -1.0
    turn = float(np.mod(sign * (rest - begin) - SAME_ANGLE, 2 * np.pi)) + SAME_ANGLE
    return begin + sign * turn


def _shorter_turn(angle: float) -> float:
    """The same angle in (-π, π], exactly 0 for none [rad]."""
    turn = -float(np.mod(np.pi - angle, 2 * np.pi) - np.pi)
    return 0.0 if abs(turn) < SAME_ANGLE else turn


def directed(scenario: Scenario) -> tuple[Scenario, ...]:
    """The scenario with its goal's direction; for a goal on another edge without one, both
    directions, the shorter turn first.
    """
    goal = scenario.goal
    if isinstance(goal, GoalAtPose) or goal.direction is not None:
        return (scenario,)
    turn = goal_rotation(scenario) - start_rotation(scenario)
    if turn == 0.0:
        return (scenario,)
    order = (CCW, CW) if turn > 0.0 else (CW, CCW)
    return tuple(replace(scenario, goal=replace(goal, direction=d)) for d in order)


def start_x(scenario: Scenario) -> float:
    """Centroid's x at the start [m]."""
    start = scenario.start
    return float(start.pose[0] if isinstance(start, StartAtPose) else start.x)


def turns_clockwise(scenario: Scenario) -> bool:
    """Whether the object shall turn clockwise: such a scenario is planned as its mirror image."""
    goal = scenario.goal
    if isinstance(goal, GoalAtPose) or goal.direction is None:
        return goal_rotation(scenario) < start_rotation(scenario) - SAME_ANGLE
    return goal.direction == CW
