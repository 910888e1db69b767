"""Checks of the numbers of a scenario against one another: shapes, sizes, rest, place.

Each problem is reported as 'key: got ...; allowed: ...'. Geometry is checked only where the shapes
themselves are sound; the start is checked by `start_checks.py`.
"""

from collections.abc import Iterable

import numpy as np

from wholearm_ros.model.convex import crossing_edges, turns
from wholearm_ros.model.hand import SIDES
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario_schema import (
    FingerTable,
    GoalOnEdgeTable,
    ScenarioTable,
    StartOnEdgeTable,
)

MIN_EDGE = 1e-3  # [m] a shorter edge is a mistake, and of the size of the contact tolerances
MIN_TURN = 1e-3  # sine of the smallest turn at a vertex that is still a corner


def problems_with(table: ScenarioTable) -> list[str]:
    """Every problem that the tables show by themselves."""
    shape = _object_problems(np.array(table.object.vertices))
    palm = _palm_problems(np.array(table.palm.vertices))
    hand = [
        p for side in SIDES for p in _finger_problems(f'hand.{side}', getattr(table.hand, side))
    ]
    rest = [] if shape else _rest_problems(table)
    size = [] if shape else _size_problems(table)
    return shape + size + hand + palm + rest + ([] if palm else _place_problems(table))


# ---------------------------------------------------------------------- shapes
def _object_problems(vertices: np.ndarray) -> list[str]:
    key = 'object.vertices'
    lengths = np.linalg.norm(np.roll(vertices, -1, axis=0) - vertices, axis=1)
    if lengths.min() < MIN_EDGE:
        k = int(lengths.argmin())
        return [
            f'{key}: got an edge {k} of {lengths[k]:.6f} m (degenerate); '
            f'allowed: edges of at least {MIN_EDGE} m'
        ]
    crossing = crossing_edges(vertices)
    if crossing:
        return [
            f'{key}: got edges {crossing[0]} and {crossing[1]} that cross; '
            'allowed: a convex polygon'
        ]
    if Polygon(vertices).area < 0.0:
        return [f'{key}: got them clockwise; allowed: counter-clockwise']
    sines = turns(vertices)
    flat = [int(k) for k in np.flatnonzero(np.abs(sines) <= MIN_TURN)]
    dents = [int(k) for k in np.flatnonzero(sines < -MIN_TURN)]
    if dents:
        return [
            f'{key}: got a polygon that is not convex (at vertex {_list(dents)}); '
            'allowed: a convex polygon'
        ]
    if flat:
        return [
            f'{key}: got no corner at vertex {_list(flat)} (degenerate); '
            'allowed: a turn at every vertex'
        ]
    return []


def _size_problems(table: ScenarioTable) -> list[str]:
    """An object larger than the open hand is one whose lengths are in another unit."""
    vertices, left, right = np.array(table.object.vertices), table.hand.left, table.hand.right
    size = float(np.linalg.norm(vertices[:, None] - vertices[None], axis=-1).max())
    span = float(np.hypot(*np.subtract(left.axis, right.axis)) + left.length + right.length)
    if size <= span:
        return []
    return [
        f'object.vertices: got an object {size:.3g} m across; '
        f'allowed: at most {span:.3g} m, the span of the open hand '
        '(are the vertices in metres?)'
    ]


def _finger_problems(key: str, finger: FingerTable) -> list[str]:
    low, high = finger.angle_limits
    problems = []
    if not low < high:
        problems.append(
            f'{key}.angle_limits: got {finger.angle_limits}; allowed: the lower one first'
        )
    if finger.half_width >= finger.length:
        problems.append(
            f'{key}.half_width: got {finger.half_width}; '
            f'allowed: less than the length, {finger.length}'
        )
    return problems


def _palm_problems(vertices: np.ndarray) -> list[str]:
    steps = np.diff(vertices, axis=0)
    if np.linalg.norm(steps, axis=1).min() < MIN_EDGE:
        return [f'palm.vertices: got a segment shorter than {MIN_EDGE} m; allowed: longer ones']
    if steps[:, 0].min() <= 0.0:
        return [
            'palm.vertices: got x that does not rise from vertex to vertex; '
            'allowed: from left to right, '
            'so that the free side, on the left of the line, is up'
        ]
    return []


# ---------------------------------------------------------------------- rest and place
def _rest_problems(table: ScenarioTable) -> list[str]:
    polygon, problems = Polygon(np.array(table.object.vertices)), []
    for key, end, kind in (
        ('start', table.start, StartOnEdgeTable),
        ('goal', table.goal, GoalOnEdgeTable),
    ):
        if not isinstance(end, kind) or end.edge is None:
            continue
        n = len(polygon.vertices)
        stable = polygon.resting_edges
        if end.edge >= n:
            problems.append(
                f'{key}.edge: got {end.edge}; allowed: 0 to {n - 1}, the object has {n} edges'
            )
        elif end.edge not in stable:
            problems.append(
                f'{key}.edge: got {end.edge}, on which the object cannot rest (its centroid is '
                'not over it); '
                f'allowed: {_list(stable)}'
            )
    return problems


def _place_problems(table: ScenarioTable) -> list[str]:
    low, high = table.palm.vertices[0][0], table.palm.vertices[-1][0]
    places = {
        f'{key}.x': getattr(end, 'x', None)
        for key, end in (('start', table.start), ('goal', table.goal))
    }
    places.update(
        {
            f'{key}.pose[0]': end.pose[0]
            for key, end in (('start', table.start), ('goal', table.goal))
            if hasattr(end, 'pose')
        }
    )
    problems = [
        f'{key}: got {x}, which is not over the palm; allowed: {low} to {high}'
        for key, x in places.items()
        if x is not None and not low < x < high
    ]
    if (
        isinstance(table.goal, GoalOnEdgeTable)
        and table.goal.x_tolerance is not None
        and table.goal.x is None
    ):
        problems.append(
            f'goal.x_tolerance: got {table.goal.x_tolerance} without goal.x; '
            'allowed: both or neither'
        )
    return problems + _missing_keys(table)


def _missing_keys(table: ScenarioTable) -> list[str]:
    start, goal, problems = table.start, table.goal, []
    if isinstance(start, StartOnEdgeTable) and not start.felt:
        missing = [key for key in ('edge', 'x') if getattr(start, key) is None]
        problems += [f'start.{key}: missing; this key is needed' for key in missing]
    if isinstance(goal, GoalOnEdgeTable) and goal.edge is None:
        if goal.x is None:
            problems.append('goal: got neither an edge nor x; allowed: either, or both, or a pose')
        elif not isinstance(start, StartOnEdgeTable) or start.felt:
            problems.append(
                'goal.edge: missing; this key is needed when the start is a pose, or is to be felt'
            )
    return problems


def _list(numbers: Iterable[int]) -> str:
    return ', '.join(str(k) for k in numbers) or 'none'
