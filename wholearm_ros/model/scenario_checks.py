"""Checks of the numbers of a scenario against one another: shapes, sizes, rest, place.

Each problem is reported as 'key: got ...; allowed: ...'. Geometry is checked only where the shapes
themselves are sound; the start is checked by `start_checks.py`.
"""

from collections.abc import Iterable

import numpy as np

from wholearm_ros.model.convex import crossing_edges, turns
from wholearm_ros.model.finger_shape import ConvexParts, FingerShape, Rectangle
from wholearm_ros.model.frame import Frame
from wholearm_ros.model.hand import SIDES
from wholearm_ros.model.polygon import Polygon, edge_table
from wholearm_ros.model.scenario_schema import (
    FingerTable,
    GoalOnEdgeTable,
    ScenarioTable,
    StartOnEdgeTable,
)
from wholearm_ros.model.separation import part_clearance, point_clearance

MIN_EDGE = 1e-3  # [m] a shorter edge is a mistake, and of the size of the contact tolerances
ON_OUTLINE = 1e-9  # [m] a point that is nearer to an outline is on it
HERE = Frame(0.0, 0.0, 1.0, 0.0)
MIN_TURN = 1e-3  # sine of the smallest turn at a vertex that is still a corner


def problems_with(table: ScenarioTable) -> list[str]:
    """Every problem that the tables show by themselves."""
    shape = _outline_problems('object.vertices', np.array(table.object.vertices))
    palm = _palm_problems(np.array(table.palm.vertices))
    hand = [
        p for side in SIDES for p in _finger_problems(f'hand.{side}', getattr(table.hand, side))
    ]
    rest = [] if shape else _rest_problems(table)
    size = [] if shape or hand else _size_problems(table)
    return shape + size + hand + palm + rest + ([] if palm else _place_problems(table))


# ---------------------------------------------------------------------- shapes
def _outline_problems(key: str, vertices: np.ndarray) -> list[str]:
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
    lengths = sum(finger_shape(finger).length for finger in (left, right))
    span = float(np.hypot(*np.subtract(left.axis, right.axis)) + lengths)
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
    shape = _drawn_finger_problems if _drawn(finger) else _rectangle_problems
    return problems + shape(key, finger)


def finger_shape(finger: FingerTable) -> FingerShape:
    """What the table's keys say, of a table without problems."""
    drawn = _drawn(finger)
    if drawn:
        return ConvexParts([np.array(vertices) for _, vertices in drawn])
    assert finger.length is not None and finger.half_width is not None
    return Rectangle(finger.length, finger.half_width)


def _drawn(finger: FingerTable) -> list[tuple[str, list[list[float]]]]:
    """(key, vertices) of each part that the table draws; none of a rectangle."""
    found = [] if finger.vertices is None else [('vertices', finger.vertices)]
    return found + [(f'parts[{k}]', part) for k, part in enumerate(finger.parts or [])]


def _rectangle_problems(key: str, finger: FingerTable) -> list[str]:
    missing = [name for name in ('length', 'half_width') if getattr(finger, name) is None]
    if len(missing) == 2:
        return [
            f'{key}: got a finger without a shape; '
            'allowed: length and half_width, or vertices, or parts'
        ]
    if missing:
        return [f'{key}.{missing[0]}: missing; this key is needed']
    assert finger.length is not None and finger.half_width is not None
    if finger.half_width >= finger.length:
        return [
            f'{key}.half_width: got {finger.half_width}; '
            f'allowed: less than the length, {finger.length}'
        ]
    return []


def _drawn_finger_problems(key: str, finger: FingerTable) -> list[str]:
    given = [
        name
        for name in ('length', 'half_width', 'vertices', 'parts')
        if getattr(finger, name) is not None
    ]
    if len(given) > 1:
        return [
            f'{key}: got {" and ".join(given)}; '
            'allowed: length and half_width, or vertices, or parts'
        ]
    parts = [(f'{key}.{name}', np.array(vertices)) for name, vertices in _drawn(finger)]
    outlines = [problem for name, part in parts for problem in _outline_problems(name, part)]
    return outlines or _place_of_axis_problems(f'{key}.{given[0]}', [part for _, part in parts])


def _place_of_axis_problems(key: str, parts: list[np.ndarray]) -> list[str]:
    """Where the axis is not in the finger, or that does not go along x, or not in one piece."""
    tables = [edge_table(part, closed=True) for part in parts]
    away = min(point_clearance(table, HERE, 0.0, 0.0)[0] for table in tables)
    if away > ON_OUTLINE:
        return [
            f'{key}: got a finger {1e3 * away:.3g} mm beside its axis; '
            'allowed: vertices about the axis, which is their origin, and lies in the finger'
        ]
    length = max(float(part[:, 0].max()) for part in parts)
    if length < MIN_EDGE:
        return [
            f'{key}: got a finger that reaches {length} m along x; '
            'allowed: x along the finger, from the axis to the tip'
        ]
    held, waiting = [0], list(range(1, len(parts)))
    for one in held:
        gaps = {k: part_clearance(tables[one], HERE, tables[k], HERE) for k in waiting}
        near = [k for k, gap in gaps.items() if gap <= ON_OUTLINE]
        waiting = [k for k in waiting if k not in near]
        held += near
    return [
        f'{key}[{k}]: got a part that touches no other one that hangs on part 0; '
        'allowed: parts that overlap'
        for k in waiting
    ]


def _palm_problems(vertices: np.ndarray) -> list[str]:
    steps = np.diff(vertices, axis=0)
    if np.min(np.linalg.norm(steps, axis=1)) < MIN_EDGE:
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
