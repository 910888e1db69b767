"""What the numbers of a scenario must satisfy among themselves: shapes, rest, reach, no
penetration.

Each problem is told as 'key: got ...; allowed: ...'. Geometry is only looked at when the shapes
themselves are sound.
"""

from collections.abc import Iterable

import numpy as np

from wholearm_ros.model.convex import (
    crossing_edges,
    rectangle,
    separation,
    signed_area,
    turned,
    turns,
)
from wholearm_ros.model.hand import LEFT, SIDES
from wholearm_ros.model.orientation import palm_angle_under, start_rotation
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario import GoalAtPose, Scenario, StartAtPose
from wholearm_ros.model.scenario_schema import (
    FingerTable,
    GoalOnEdgeTable,
    ScenarioTable,
    StartOnEdgeTable,
)

MIN_EDGE = 1e-3  # [m] a shorter edge is a mistake, and of the size of the contact tolerances
MIN_TURN = 1e-3  # sine of the smallest turn at a vertex that is still a corner
MAX_PENETRATION = 1e-4  # [m] at the start
SWEEP = 181  # angles at which a closing finger is looked at


def problems_with(table: ScenarioTable) -> list[str]:
    """Every problem that the tables show by themselves; see `problems_at_start` for the rest."""
    shape = _object_problems(np.array(table.object.vertices))
    palm = _palm_problems(np.array(table.palm.vertices))
    hand = [
        p for side in SIDES for p in _finger_problems(f'hand.{side}', getattr(table.hand, side))
    ]
    rest = [] if shape else _rest_problems(table)
    size = [] if shape else _size_problems(table)
    return shape + size + hand + palm + rest + ([] if palm else _place_problems(table))


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
    if signed_area(vertices) < 0.0:
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
        if not isinstance(end, kind):
            continue
        n = len(polygon.vertices)
        stable = [k for k in range(n) if polygon.can_rest_on(k)]
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
    return problems


# ---------------------------------------------------------------------- penetration and reach
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


def _list(numbers: Iterable[int]) -> str:
    return ', '.join(str(k) for k in numbers) or 'none'
