"""Contacts of the object with the palm and the fingers: their names, the contact state, and how
the hand closes on the object.
"""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from wholearm_ros.errors import ScenarioError
from wholearm_ros.kernels import geometry
from wholearm_ros.mechanics.world import World, build_world
from wholearm_ros.model.configuration import SIZE
from wholearm_ros.model.hand import LEFT, RIGHT, SIDES
from wholearm_ros.model.orientation import palm_angle_under, palm_segment_under, start_rotation
from wholearm_ros.model.polygon import pose_on_edge
from wholearm_ros.model.scenario import Scenario, StartAtPose

ROUNDED, ROUNDED_ANGLE = 1e-4, 1e-3  # [m], [rad] a told start nearer to touching touches
CLOSED_GAP = 1e-7  # [m] a pair with a smaller gap is closed
DEEPEST_START = 1e-4  # [m] how far a start given as a pose may penetrate
FINGER_EDGES = ('inner', 'tip', 'outer', 'base')
FINGER_CORNERS = ('inner_corner', 'outer_corner')


def pair_name(code: int) -> str:
    """A contact pair in words: `v0:palm.e0`, `v5:left.inner`, `e3:right.inner_corner`."""
    kind, body = geometry.pair_kind(code), geometry.pair_body(code)
    hand, obj = int(geometry.pair_hand_feature(code)), int(geometry.pair_object_feature(code))
    if body == geometry.PALM:
        feature = f'palm.{"e" if kind == geometry.VERTEX_EDGE else "v"}{hand}'
    else:
        features = FINGER_EDGES if kind == geometry.VERTEX_EDGE else FINGER_CORNERS
        feature = f'{SIDES[body - 1]}.{features[hand]}'
    return f'{"v" if kind == geometry.VERTEX_EDGE else "e"}{obj}:{feature}'


def pair_from_name(name: str) -> int:
    """The inverse of `pair_name`. Raises ValueError for anything else."""
    obj, hand = name.split(':')
    body, feature = hand.split('.')
    kind = {'v': geometry.VERTEX_EDGE, 'e': geometry.EDGE_CORNER}[obj[0]]
    if body == 'palm':
        return int(geometry.pair_code(kind, geometry.PALM, _index(feature[1:]), _index(obj[1:])))
    features = FINGER_EDGES if kind == geometry.VERTEX_EDGE else FINGER_CORNERS
    return int(
        geometry.pair_code(kind, 1 + SIDES.index(body), features.index(feature), _index(obj[1:]))
    )


def _index(text: str) -> int:
    """A feature's number, of which a pair code has room for one byte."""
    if not 0 <= int(text) < 256:
        raise ValueError(f'contact pair: feature number {text}; allowed: 0 to 255')
    return int(text)


def pair_exists(code: int, vertices: int, palm_vertices: int) -> bool:
    """Whether an object and a palm of so many vertices have that pair; kernels do not look before
    they read.
    """
    kind, hand = geometry.pair_kind(code), int(geometry.pair_hand_feature(code))
    on_palm = geometry.pair_body(code) == geometry.PALM
    features = palm_vertices - (kind == geometry.VERTEX_EDGE) if on_palm else hand + 1
    return bool(geometry.pair_object_feature(code) < vertices and hand < features)


def gap_table(world: World, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(gaps (m,) [m], pair codes (m,)) of every feature with the nearest edge opposite; see the
    kernel.
    """
    size = geometry.table_size(world)
    gaps, codes = np.empty(size), np.empty(size, np.int64)
    geometry.gap_table(world, q, gaps, codes)
    return gaps, codes


def closed_pairs(world: World, q: np.ndarray, tolerance: float = CLOSED_GAP) -> tuple[int, ...]:
    """Codes of the pairs that are closed at q, sorted: the contact state."""
    gaps, codes = gap_table(world, q)
    return tuple(sorted(int(c) for c in codes[np.abs(gaps) <= tolerance]))


def contact_state_matrix(world: World, pairs: Sequence[int]) -> np.ndarray:
    """C (2n, h), bool: rows are the object's vertices then edges, columns the hand's features
    (palm, left, right).
    """
    n, p = len(world.obj), len(world.palm)
    palm_columns = (p - 1) + p
    c = np.zeros((2 * n, palm_columns + 12), dtype=bool)
    for code in pairs:
        kind, body = geometry.pair_kind(code), geometry.pair_body(code)
        hand = geometry.pair_hand_feature(code)
        row = geometry.pair_object_feature(code) + (n if kind else 0)
        column = (
            hand + (p - 1 if kind else 0)
            if body == 0
            else palm_columns + 6 * (body - 1) + hand + (4 if kind else 0)
        )
        c[row, column] = True
    return c


def four_contact_subsets(pairs: Sequence[int]) -> list[tuple[int, ...]]:
    """Every choice of four of the pairs with at least one on each finger and the palm."""
    return [
        four
        for four in combinations(pairs, 4)
        if {int(geometry.pair_body(c)) for c in four} == {0, 1, 2}
    ]


def contact_rows(
    world: World, pairs: Sequence[int], q: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(rows (k, 5) = [G_nᵀ, −J_n] of eq. (1), gaps (k,) [m])."""
    codes = np.asarray(pairs, dtype=np.int64)
    rows, gaps = np.empty((len(codes), SIZE)), np.empty(len(codes))
    geometry.normal_rows(world, codes, q, rows, gaps)
    return rows, gaps


def deepest_penetration(world: World, q: np.ndarray) -> tuple[float, str]:
    """(depth [m], pair name): the most negative gap at q, 0 when nothing penetrates."""
    gaps, codes = gap_table(world, q)
    k = int(np.argmin(gaps))
    return max(0.0, -float(gaps[k])), pair_name(codes[k])


def closing_angle(world: World, pose: np.ndarray, side: int) -> float:
    """Joint angle [rad] at which a finger, swept closed from its open limit, first touches the
    object at `pose` (3,); NaN when it touches at its open limit already, or never.
    """
    return float(geometry.closing_angle(world, side, pose))


def close_finger(world: World, pose: np.ndarray, side: int) -> float:
    """The `closing_angle`.

    Raises ScenarioError when it comes to its other limit without touching, or touches at its open
    limit already.
    """
    angle = closing_angle(world, pose, side)
    if np.isnan(angle):
        low, high = world.limits[side]
        raise ScenarioError(
            f'hand.{SIDES[side]}: the finger, swept closed between {low:.3f} and {high:.3f} rad, '
            f'does not come to touch the object at {_show(pose)}; allowed: an object that lies '
            'between the open fingers and within their reach'
        )
    return angle


def start_configuration(scenario: Scenario, world: World | None = None) -> np.ndarray:
    """q (5,) at the start: the object at rest on the palm, the fingers closed on it.

    Of a start at a pose, what nearly touches touches: poses are written with few digits.

    Raises ScenarioError when a finger cannot touch the object, or the start penetrates the hand.
    """
    world = world or build_world(scenario)
    start = scenario.start
    if isinstance(start, StartAtPose):
        q = _in_contact(world, scenario, np.concatenate([start.pose, start.fingers]))
    else:
        pose = pose_on_palm(
            world, start.x, start_rotation(scenario), palm_segment_under(scenario.palm, start.x)
        )
        q = np.concatenate(
            [pose, [close_finger(world, pose, LEFT), close_finger(world, pose, RIGHT)]]
        )
    depth, pair = deepest_penetration(world, q)
    if depth > DEEPEST_START:
        raise ScenarioError(
            f'start: the object penetrates the hand by {1000 * depth:.2f} mm at {pair}; '
            f'allowed: at most {1000 * DEEPEST_START:.2f} mm'
        )
    return q


def _in_contact(world: World, scenario: Scenario, told: np.ndarray) -> np.ndarray:
    """q (5,) near `told` (5,): flat on its edge, on the palm, the fingers at the object, where it
    is nearer to that than ROUNDED and ROUNDED_ANGLE.
    """
    q, polygon = told.copy(), scenario.object.polygon
    flat = palm_angle_under(scenario.palm, q[0])
    for edge in polygon.resting_edges:
        turn = np.remainder(polygon.resting_angle(edge) + flat - q[2] + np.pi, 2 * np.pi) - np.pi
        if abs(turn) <= ROUNDED_ANGLE:
            q[2] += turn
    lying = pose_on_palm(world, q[0], q[2], palm_segment_under(scenario.palm, q[0]))
    if abs(q[1] - lying[1]) <= ROUNDED:
        q[1] = lying[1]
    for side in (LEFT, RIGHT):
        touching = closing_angle(world, q[:3], side)
        if abs(q[3 + side] - touching) <= ROUNDED_ANGLE:
            q[3 + side] = touching
    return q


def pose_on_palm(world: World, x: float, angle: float, segment: int = 0) -> np.ndarray:
    """(3,) pose whose lowest vertex touches the line of a palm segment, with the centroid at x
    [m].
    """
    return pose_on_edge(world.obj[:, :2], world.palm[segment], x, angle)


def _show(pose: np.ndarray) -> str:
    return f'x {pose[0]:.3f} m, y {pose[1]:.3f} m, {pose[2]:.3f} rad'
