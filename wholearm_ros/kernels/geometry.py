"""Contact pairs, their gaps and Jacobian rows, and the table of gaps that could close.

A configuration is q = (x, y, φ, θ_L, θ_R): centroid [m], rotation [rad], joint angles [rad]. A
contact pair is one integer, see `pair_code`. Geometry arrays ("world"):
    obj (n, 5) vertices about the centroid, palm (p, 5) polyline, both with rows (x, y, normal x, y
    and length of the edge that starts there; the normal points out of the object, and to the free
    side of the palm),
    fingers (2, 4) rows (axis x, axis y, length, half width),
    corners (c,) indices of the palm vertices that can touch an object edge.
Whoever asks for several pairs of one configuration finds its `frame_of` once and calls the
functions that end in `_in`.
"""

import numpy as np

from wholearm_ros.kernels import kernel

VERTEX_EDGE, EDGE_CORNER = 0, 1  # object vertex on hand edge; object edge on hand corner
PALM, LEFT_FINGER, RIGHT_FINGER = 0, 1, 2
INNER, TIP, OUTER, BASE = 0, 1, 2, 3  # edges of a finger
INNER_CORNER, OUTER_CORNER = 0, 1  # its two corners at the tip


@kernel
def pair_code(kind, body, hand_feature, object_feature):
    """One integer for a contact pair."""
    return (kind << 20) | (body << 16) | (hand_feature << 8) | object_feature


@kernel
def pair_kind(code):
    """VERTEX_EDGE or EDGE_CORNER."""
    return (code >> 20) & 1


@kernel
def pair_body(code):
    """PALM, LEFT_FINGER or RIGHT_FINGER."""
    return (code >> 16) & 15


@kernel
def pair_hand_feature(code):
    """Number of the hand's edge or corner."""
    return (code >> 8) & 255


@kernel
def pair_object_feature(code):
    """Number of the object's vertex or edge."""
    return code & 255


@kernel
def frame_of(q):
    """Cosine and sine of φ, θ_L and θ_R."""
    return np.cos(q[2]), np.sin(q[2]), np.cos(q[3]), np.sin(q[3]), np.cos(q[4]), np.sin(q[4])


@kernel
def finger_axes(side, frame):
    """Direction u and inner normal w (towards the other finger) of a finger."""
    ux, uy = frame[2 + 2 * side], frame[3 + 2 * side]
    if side == 0:
        return ux, uy, uy, -ux
    return ux, uy, -uy, ux


@kernel
def finger_edge(fingers, side, feature, frame):
    """(start x, y, direction x, y, outward normal x, y, length) of a finger's edge."""
    ax, ay, length, half = fingers[side, 0], fingers[side, 1], fingers[side, 2], fingers[side, 3]
    ux, uy, wx, wy = finger_axes(side, frame)
    if feature == 0:
        return ax + half * wx, ay + half * wy, ux, uy, wx, wy, length
    if feature == 1:
        return (
            ax + length * ux - half * wx,
            ay + length * uy - half * wy,
            wx,
            wy,
            ux,
            uy,
            2.0 * half,
        )
    if feature == 2:
        return ax - half * wx, ay - half * wy, ux, uy, -wx, -wy, length
    return ax - half * wx, ay - half * wy, wx, wy, -ux, -uy, 2.0 * half


@kernel
def finger_corner(fingers, side, feature, frame):
    """(x, y) of a finger's corner at the tip."""
    ux, uy, wx, wy = finger_axes(side, frame)
    h = fingers[side, 3] if feature == 0 else -fingers[side, 3]
    length = fingers[side, 2]
    return fingers[side, 0] + length * ux + h * wx, fingers[side, 1] + length * uy + h * wy


@kernel
def palm_edge(palm, k):
    """(start x, y, direction x, y, normal to the free side x, y, length) of a palm edge."""
    nx, ny = palm[k, 2], palm[k, 3]
    return palm[k, 0], palm[k, 1], ny, -nx, nx, ny, palm[k, 4]


@kernel
def object_vertex(obj, i, q, frame):
    """(x, y) of a vertex of the object [m]."""
    c, s = frame[0], frame[1]
    return q[0] + c * obj[i, 0] - s * obj[i, 1], q[1] + s * obj[i, 0] + c * obj[i, 1]


@kernel
def object_edge(obj, j, q, frame):
    """(start x, y, direction x, y, outward normal x, y, length) of an object edge."""
    c, s = frame[0], frame[1]
    ax, ay = object_vertex(obj, j, q, frame)
    nx, ny = c * obj[j, 2] - s * obj[j, 3], s * obj[j, 2] + c * obj[j, 3]
    return ax, ay, -ny, nx, nx, ny, obj[j, 4]


@kernel
def hand_edge(palm, fingers, body, feature, frame):
    """`palm_edge` or `finger_edge`."""
    if body == 0:
        return palm_edge(palm, feature)
    return finger_edge(fingers, body - 1, feature, frame)


@kernel
def hand_corner(palm, fingers, body, feature, frame):
    """(x, y) of a vertex of the palm or of a finger's corner [m]."""
    if body == 0:
        return palm[feature, 0], palm[feature, 1]
    return finger_corner(fingers, body - 1, feature, frame)


@kernel
def contact(obj, palm, fingers, code, q):
    """(point x, y, normal towards the object x, y, gap, position along the edge, edge length) of a
    pair [m].
    """
    return contact_in(obj, palm, fingers, code, q, frame_of(q))


@kernel
def contact_in(obj, palm, fingers, code, q, frame):
    """`contact`, the configuration's frame being known."""
    body, hand_feature, object_feature = (
        pair_body(code),
        pair_hand_feature(code),
        pair_object_feature(code),
    )
    if pair_kind(code) == 0:
        px, py = object_vertex(obj, object_feature, q, frame)
        ax, ay, dx, dy, nx, ny, length = hand_edge(palm, fingers, body, hand_feature, frame)
        rx, ry = px - ax, py - ay
        return px, py, nx, ny, nx * rx + ny * ry, dx * rx + dy * ry, length
    px, py = hand_corner(palm, fingers, body, hand_feature, frame)
    ax, ay, dx, dy, mx, my, length = object_edge(obj, object_feature, q, frame)
    rx, ry = px - ax, py - ay
    return px, py, -mx, -my, mx * rx + my * ry, dx * rx + dy * ry, length


@kernel
def fill_row(row, px, py, nx, ny, body, fingers, q):
    """Row of ∂(motion along n at p of object relative to hand)/∂q̇: [nᵀ, n·(p−o)^⊥, −n·(p−axis)^⊥
    in the finger's column].
    """
    row[0], row[1] = nx, ny
    row[2] = -nx * (py - q[1]) + ny * (px - q[0])
    row[3], row[4] = 0.0, 0.0
    if body > 0:
        ax, ay = fingers[body - 1, 0], fingers[body - 1, 1]
        row[2 + body] = -(-nx * (py - ay) + ny * (px - ax))


@kernel
def normal_rows(obj, palm, fingers, codes, q, rows, gaps):
    """Fill rows (k, 5) = ∂gap/∂q = [G_nᵀ, −J_n] of eq. (1), and gaps (k,)."""
    frame = frame_of(q)
    for i in range(codes.shape[0]):
        px, py, nx, ny, gap, _, _ = contact_in(obj, palm, fingers, codes[i], q, frame)
        fill_row(rows[i], px, py, nx, ny, pair_body(codes[i]), fingers, q)
        gaps[i] = gap


@kernel
def tangent_rows(obj, palm, fingers, codes, q, rows):
    """Fill rows (k, 5): sliding speed of the object on the hand is rows @ q̇, along the normal
    turned by +90°.
    """
    frame = frame_of(q)
    for i in range(codes.shape[0]):
        px, py, nx, ny, _, _, _ = contact_in(obj, palm, fingers, codes[i], q, frame)
        fill_row(rows[i], px, py, -ny, nx, pair_body(codes[i]), fingers, q)


@kernel
def table_size(obj, palm, corners):
    """Entries of the gap table: each object vertex with each palm edge and finger, each hand
    corner with the object.
    """
    return obj.shape[0] * (palm.shape[0] + 1) + corners.shape[0] + 4


@kernel
def entry_of(obj, palm, corners, code):
    """Index of the table's entry that a pair belongs to."""
    n, body, feature = obj.shape[0], pair_body(code), pair_hand_feature(code)
    p = palm.shape[0] - 1
    if pair_kind(code) == 0:
        column = feature if body == 0 else p + body - 1
        return column * n + pair_object_feature(code)
    base = n * (p + 2)
    if body > 0:
        return base + 2 * (body - 1) + feature
    for i in range(corners.shape[0]):
        if corners[i] == feature:
            return base + 4 + i
    return -1


@kernel
def corner_depth(obj, px, py, q, frame):
    """(signed distance of a point to the object's nearest edge line from outside, that edge): max
    over edges.
    """
    c, s = frame[0], frame[1]
    x, y = c * (px - q[0]) + s * (py - q[1]), c * (py - q[1]) - s * (px - q[0])
    best, edge = -np.inf, -1
    for j in range(obj.shape[0]):
        gap = obj[j, 2] * (x - obj[j, 0]) + obj[j, 3] * (y - obj[j, 1])
        if gap > best:
            best, edge = gap, j
    return best, edge


@kernel
def _vertex_on_palm(obj, palm, k, i, vx, vy):
    """A vertex beside the edge's extent has an infinite gap."""
    ax, ay, dx, dy, nx, ny, length = palm_edge(palm, k)
    inside = 0.0 <= dx * (vx - ax) + dy * (vy - ay) <= length
    return nx * (vx - ax) + ny * (vy - ay) if inside else np.inf, pair_code(0, 0, k, i)


@kernel
def _vertex_on_finger(fingers, side, i, vx, vy, frame):
    ux, uy, wx, wy = finger_axes(side, frame)
    rx, ry = vx - fingers[side, 0], vy - fingers[side, 1]
    along, across = ux * rx + uy * ry, wx * rx + wy * ry
    half = fingers[side, 3]
    best, feature = across - half, 0
    if along - fingers[side, 2] > best:
        best, feature = along - fingers[side, 2], 1
    if -across - half > best:
        best, feature = -across - half, 2
    if -along > best:
        best, feature = -along, 3
    return best, pair_code(0, 1 + side, feature, i)


@kernel
def _object_on_corner(obj, palm, fingers, corners, k, q, frame):
    body, feature = (1 + k // 2, k % 2) if k < 4 else (0, corners[k - 4])
    px, py = hand_corner(palm, fingers, body, feature, frame)
    gap, edge = corner_depth(obj, px, py, q, frame)
    return gap, pair_code(1, body, feature, edge)


@kernel
def table_entry(obj, palm, fingers, corners, e, q, frame):
    """(signed gap [m] of an entry's feature to the nearest opposite edge, code of that pair);
    penetration is negative.
    """
    n, p = obj.shape[0], palm.shape[0] - 1
    if e >= n * (p + 2):
        return _object_on_corner(obj, palm, fingers, corners, e - n * (p + 2), q, frame)
    column, i = e // n, e % n
    vx, vy = object_vertex(obj, i, q, frame)
    if column < p:
        return _vertex_on_palm(obj, palm, column, i, vx, vy)
    return _vertex_on_finger(fingers, column - p, i, vx, vy, frame)


@kernel
def gap_table(obj, palm, fingers, corners, q, gaps, codes):
    """Fill gaps and codes of every `table_entry`."""
    n, p = obj.shape[0], palm.shape[0] - 1
    frame = frame_of(q)
    for i in range(n):
        vx, vy = object_vertex(obj, i, q, frame)
        for k in range(p):
            gaps[k * n + i], codes[k * n + i] = _vertex_on_palm(obj, palm, k, i, vx, vy)
        for side in range(2):
            e = (p + side) * n + i
            gaps[e], codes[e] = _vertex_on_finger(fingers, side, i, vx, vy, frame)
    for k in range(4 + corners.shape[0]):
        e = n * (p + 2) + k
        gaps[e], codes[e] = _object_on_corner(obj, palm, fingers, corners, k, q, frame)


@kernel
def finger_clearance(obj, fingers, side, theta, x, y, c, s):
    """Separation [m] of a finger and the object by the separating axis theorem: positive apart,
    negative where they overlap.

    Unlike the gap table, which knows vertices only, it sees a finger that runs right through the
    object.
    """
    u, v = np.cos(theta), np.sin(theta)
    frame = c, s, u, v, u, v
    ux, uy, wx, wy = finger_axes(side, frame)
    axis_x, axis_y, length, half = (
        fingers[side, 0],
        fingers[side, 1],
        fingers[side, 2],
        fingers[side, 3],
    )
    near_along, far_along, near_across, far_across = np.inf, -np.inf, np.inf, -np.inf
    greatest = -np.inf
    for i in range(obj.shape[0]):
        vx, vy, _, _, mx, my, _ = object_edge(obj, i, (x, y), frame)
        along, across = (
            ux * (vx - axis_x) + uy * (vy - axis_y),
            wx * (vx - axis_x) + wy * (vy - axis_y),
        )
        near_along, far_along = min(near_along, along), max(far_along, along)
        near_across, far_across = min(near_across, across), max(far_across, across)
        nearest = mx * (axis_x - vx) + my * (axis_y - vy) - half * abs(mx * wx + my * wy)
        greatest = max(greatest, nearest + min(0.0, length * (mx * ux + my * uy)))
    return max(
        greatest,
        max(max(near_across - half, -far_across - half), max(near_along - length, -far_along)),
    )


@kernel
def left_the_hand(palm, fingers, q):
    """Whether the object's centroid is where no finger brings it back from: a third of a finger's
    length beyond an end of the palm, below the palm, or two lengths above an axis.
    """
    length = max(fingers[0, 2], fingers[1, 2])
    lowest = palm[0, 1]
    for k in range(palm.shape[0]):
        lowest = min(lowest, palm[k, 1])
    return (
        q[0] < palm[0, 0] - length / 3.0
        or q[0] > palm[palm.shape[0] - 1, 0] + length / 3.0
        or q[1] < lowest
        or q[1] > max(fingers[0, 1], fingers[1, 1]) + 2.0 * length
    )


@kernel
def closing_angle(obj, fingers, limits, side, x, y, angle):
    """Joint angle at which a finger, swept closed from its open limit, first touches the object at
    (x, y, angle).

    NaN when it touches at its open limit already, or never.
    """
    c, s = np.cos(angle), np.sin(angle)
    opened, shut = (
        (limits[side, 1], limits[side, 0]) if side == 0 else (limits[side, 0], limits[side, 1])
    )
    if finger_clearance(obj, fingers, side, opened, x, y, c, s) <= 0.0:
        return np.nan
    steps = 90
    free = opened
    for k in range(1, steps + 1):
        theta = opened + (shut - opened) * k / steps
        if finger_clearance(obj, fingers, side, theta, x, y, c, s) <= 0.0:
            touching = theta
            for _ in range(50):
                middle = 0.5 * (free + touching)
                if finger_clearance(obj, fingers, side, middle, x, y, c, s) > 0.0:
                    free = middle
                else:
                    touching = middle
            return free
        free = theta
    return np.nan
