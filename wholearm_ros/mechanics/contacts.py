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
from wholearm_ros.model.hand import CLOSING, LEFT, RIGHT, SIDES
from wholearm_ros.model.orientation import palm_angle_under, palm_segment_under, start_rotation
from wholearm_ros.model.polygon import pose_on_edge
from wholearm_ros.model.scenario import Scenario, StartAtPose

ROUNDED, ROUNDED_ANGLE = 1e-4, 1e-3  # [m], [rad] a told start nearer to touching touches
CLOSED_GAP = 1e-7  # [m] a pair with a smaller gap is closed
DEEPEST_START = 1e-4  # [m] how far a start given as a pose may penetrate
FINGER_EDGES = ('inner', 'tip', 'outer', 'base')
FINGER_CORNERS = ('inner_corner', 'outer_corner')


def pair_name(code: int) -> str:
    """A contact pair in words: `v0:palm.e0`, `v5:left.inner`, `e3:right.inner_corner`; of a finger
    that is no rectangle `v5:left.e0`, `e3:right.c1`, see `finger_features`.
    """
    kind, body = geometry.pair_kind(code), geometry.pair_body(code)
    hand, obj = int(geometry.pair_hand_feature(code)), int(geometry.pair_object_feature(code))
    if body == geometry.PALM:
        feature = f'palm.{"e" if kind == geometry.VERTEX_EDGE else "v"}{hand}'
    else:
        features, letter = _finger_features(kind)
        named = features[hand] if hand < len(features) else f'{letter}{hand - len(features)}'
        feature = f'{SIDES[body - 1]}.{named}'
    return f'{"v" if kind == geometry.VERTEX_EDGE else "e"}{obj}:{feature}'


def pair_from_name(name: str) -> int:
    """The inverse of `pair_name`. Raises ValueError for anything else."""
    obj, hand = name.split(':')
    body, feature = hand.split('.')
    kind = {'v': geometry.VERTEX_EDGE, 'e': geometry.EDGE_CORNER}[obj[0]]
    if body == 'palm':
        return int(geometry.pair_code(kind, geometry.PALM, _index(feature[1:]), _index(obj[1:])))
    features, letter = _finger_features(kind)
    if feature in features:
        number = features.index(feature)
    elif feature[0] == letter:
        number = _index(feature[1:], len(features))
    else:
        raise ValueError(f'contact pair {name}: got {feature}; allowed: {letter}0, {letter}1, …')
    return int(geometry.pair_code(kind, 1 + SIDES.index(body), number, _index(obj[1:])))


def _finger_features(kind: int) -> tuple[tuple[str, ...], str]:
    """Names of a rectangle's features of that kind, and what those of other shapes begin with."""
    return (FINGER_EDGES, 'e') if kind == geometry.VERTEX_EDGE else (FINGER_CORNERS, 'c')


def _index(text: str, after: int = 0) -> int:
    """A feature's number, counted after so many, of which a pair code has room for one byte."""
    if not 0 <= int(text) < 256 - after:
        raise ValueError(f'contact pair: feature number {text}; allowed: 0 to {255 - after}')
    return after + int(text)


def pair_exists(world: World, code: int) -> bool:
    """Whether a world has that pair; kernels do not look before they read."""
    hand, mine = int(geometry.pair_hand_feature(code)), int(geometry.pair_object_feature(code))
    return mine < len(world.obj) and hand in _hand_features(world, code)


def _hand_features(world: World, code: int) -> range:
    """Numbers of the features that the pair's body has of the pair's kind."""
    on_edge = geometry.pair_kind(code) == geometry.VERTEX_EDGE
    body, features = int(geometry.pair_body(code)), world.features
    if body == geometry.PALM:
        return range(len(world.palm) - on_edge)
    side = body - geometry.LEFT_FINGER
    if side not in (LEFT, RIGHT):
        return range(0)
    rows, sides = features.corner_rows, features.corner_sides
    if on_edge:
        rows, sides = features.edge_rows, _edge_sides(world)
    own = np.flatnonzero(sides == side)
    return range(int(own[0] - rows[side]), int(own[-1] + 1 - rows[side]))


def _edge_sides(world: World) -> np.ndarray:
    """(e,) whose each of the fingers' edges is."""
    parts = world.features.parts
    return np.repeat(parts[:, 0], parts[:, 2] - parts[:, 1])


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
    """C (2n, h), bool: rows are the object's vertices then edges, columns the hand's features:
    edges then corners of the palm, of the left and of the right finger.
    """
    n, columns = len(world.obj), []
    for body in (geometry.PALM, geometry.LEFT_FINGER, geometry.RIGHT_FINGER):
        for kind in (geometry.VERTEX_EDGE, geometry.EDGE_CORNER):
            any_pair = int(geometry.pair_code(kind, body, 0, 0))
            columns += [(kind, body, hand) for hand in _hand_features(world, any_pair)]
    c = np.zeros((2 * n, len(columns)), dtype=bool)
    for code in pairs:
        kind, body = int(geometry.pair_kind(code)), int(geometry.pair_body(code))
        row = geometry.pair_object_feature(code) + (n if kind else 0)
        c[row, columns.index((kind, body, int(geometry.pair_hand_feature(code))))] = True
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


def _close_as_far_as_it_goes(world: World, pose: np.ndarray, side: int) -> float:
    """The `closing_angle`, or the closed limit."""
    angle = closing_angle(world, pose, side)
    return float(world.limits[side][int(CLOSING[side] > 0.0)]) if np.isnan(angle) else angle


def start_configuration(
    scenario: Scenario, world: World | None = None, in_truth: bool = False
) -> np.ndarray:
    """q (5,) at the start: the object at rest on the palm, the fingers closed on it.

    Of a start at a pose, what nearly touches touches: poses are written with few digits.
    in_truth: of an object on an edge that is not quite where it was told to be: it is set down
    above what it would penetrate of the palm, and a finger out of whose reach it is is closed as
    far as that goes.

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
        if in_truth:
            pose[1] += _height_missing(world, pose)
        close = _close_as_far_as_it_goes if in_truth else close_finger
        q = np.concatenate([pose, [close(world, pose, LEFT), close(world, pose, RIGHT)]])
    depth, pair = deepest_penetration(world, q)
    if depth > DEEPEST_START:
        raise ScenarioError(
            f'start: the object penetrates the hand by {1000 * depth:.2f} mm at {pair}; '
            f'allowed: at most {1000 * DEEPEST_START:.2f} mm'
        )
    return q


def _height_missing(world: World, pose: np.ndarray) -> float:
    """By how much [m] an object at `pose` (3,) has to rise so as not to be too deep in the palm."""
    height = 0.0
    for _ in range(len(world.palm)):
        q = np.array([pose[0], pose[1] + height, pose[2], *world.limits.mean(axis=1)])
        found = zip(*gap_table(world, q))
        deep = [(gap, code) for gap, code in found if geometry.pair_body(code) == geometry.PALM]
        gap, code = min(deep)
        if gap >= -DEEPEST_START:
            break
        height -= gap / geometry.contact(world, code, q).ny
    return height


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
