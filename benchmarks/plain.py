"""Plain NumPy twins of the kernels, written as one would write them first: what a kernel's time is set against."""

import numpy as np

from wholearm_ros.kernels import geometry


def object_at(world, q) -> np.ndarray:
    """(n, 2) vertices in the palm frame."""
    c, s = np.cos(q[2]), np.sin(q[2])
    return q[:2] + world.obj[:, :2] @ np.array([[c, s], [-s, c]])


def outlines(vertices: np.ndarray) -> tuple:
    """Unit directions and outward normals (n, 2) of a counter-clockwise outline's edges, and their lengths (n,)."""
    d = np.roll(vertices, -1, axis=0) - vertices
    length = np.linalg.norm(d, axis=1)
    d = d / length[:, None]
    return d, np.column_stack([d[:, 1], -d[:, 0]]), length


def finger_frame(world, side, theta) -> tuple:
    """Axis, direction along the finger, and normal of its inner face."""
    u = np.array([np.cos(theta), np.sin(theta)])
    w = np.array([u[1], -u[0]]) if side == 0 else np.array([-u[1], u[0]])
    return world.fingers[side, :2], u, w


def gap_table(world, q) -> np.ndarray:
    """(m,) gaps [m] in the kernel's order."""
    vertices = object_at(world, q)
    _, normals, _ = outlines(vertices)
    gaps = []
    d = np.diff(world.palm[:, :2], axis=0)
    for start, along, length in zip(
        world.palm[:, :2], d / np.linalg.norm(d, axis=1)[:, None], np.linalg.norm(d, axis=1)
    ):
        across = (vertices - start) @ np.array([-along[1], along[0]])
        place = (vertices - start) @ along
        gaps.append(np.where((place >= 0) & (place <= length), across, np.inf))
    tips = []
    for side in range(2):
        axis, u, w = finger_frame(world, side, q[3 + side])
        length, half = world.rectangles[side]
        along, across = (vertices - axis) @ u, (vertices - axis) @ w
        gaps.append(np.max([across - half, along - length, -across - half, -along], axis=0))
        tips += [axis + length * u + half * w, axis + length * u - half * w]
    points = np.vstack([tips, world.palm[world.corners, :2]])
    heights = np.einsum('pni,ni->pn', points[:, None] - vertices[None], normals)
    return np.concatenate([*gaps, heights.max(axis=1)])


def rows_and_gaps(world, codes, q) -> tuple:
    """(rows (k, 5), gaps (k,)) of pairs."""
    vertices = object_at(world, q)
    d, normals, _ = outlines(vertices)
    rows, gaps = np.zeros((len(codes), 5)), np.empty(len(codes))
    for i, code in enumerate(codes):
        kind, body, hand, mine = (code >> 20) & 1, (code >> 16) & 15, (code >> 8) & 255, code & 255
        if kind == geometry.VERTEX_EDGE:
            point = vertices[mine]
            start, n = (
                _palm_edge(world, hand)
                if body == 0
                else _finger_edge(world, body - 1, hand, q[2 + body])
            )
            gaps[i] = n @ (point - start)
        else:
            point = (
                world.palm[hand, :2]
                if body == 0
                else _finger_corner(world, body - 1, hand, q[2 + body])
            )
            n = -normals[mine]
            gaps[i] = normals[mine] @ (point - vertices[mine])
        r = point - q[:2]
        rows[i, :3] = n[0], n[1], n[1] * r[0] - n[0] * r[1]
        if body > 0:
            r = point - world.fingers[body - 1, :2]
            rows[i, 2 + body] = -(n[1] * r[0] - n[0] * r[1])
    return rows, gaps


def _palm_edge(world, k):
    d = world.palm[k + 1, :2] - world.palm[k, :2]
    d = d / np.linalg.norm(d)
    return world.palm[k, :2], np.array([-d[1], d[0]])


def _finger_edge(world, side, feature, theta):
    axis, u, w = finger_frame(world, side, theta)
    length, half = world.rectangles[side]
    return [(axis + half * w, w), (axis + length * u, u), (axis - half * w, -w), (axis, -u)][
        feature
    ]


def _finger_corner(world, side, feature, theta):
    axis, u, w = finger_frame(world, side, theta)
    return axis + world.fingers[side, 2] * u + (1 - 2 * feature) * world.rectangles[side, 1] * w


def load_at(world, q) -> np.ndarray:
    """(5,) (−g_O, g_h)."""
    return np.concatenate([world.load[:3], world.bearing(q)])


def torque_range(rows, load, limits, column) -> tuple:
    """(τ_min, τ_max) [N m] of problem (6) for four contacts; (1, −1) when they bear nothing."""
    matrix = np.vstack([rows[:, :3].T, rows[:, column]])
    try:
        a, b = np.linalg.solve(matrix, np.array([[*load[:3], load[column]], [0, 0, 0, -1]]).T).T
    except np.linalg.LinAlgError:
        return 1.0, -1.0
    other, limit = 7 - column, limits[4 - column]
    torque = load[other] - rows[:, other] @ a, -rows[:, other] @ b
    offset = np.concatenate([a, [limit - torque[0], limit + torque[0]]])
    slope = np.concatenate([b, [-torque[1], torque[1]]])
    flat = np.abs(slope) < 1e-12
    if (offset[flat] < -1e-12).any():
        return 1.0, -1.0
    ends = -offset[~flat] / slope[~flat]
    low = np.max(ends[slope[~flat] > 0], initial=-limits[column - 3])
    return low, np.min(ends[slope[~flat] < 0], initial=limits[column - 3])


def project(world, codes, q, hold) -> np.ndarray:
    """q (5,) moved onto gap = 0 of four pairs, orthogonally to `hold` (5,); None when Newton does not get there."""
    for _ in range(12):
        rows, gaps = rows_and_gaps(world, codes, q)
        if np.abs(gaps).max() < 1e-10:
            return q
        q = q + np.linalg.solve(np.vstack([rows, hold]), np.append(-gaps, 0.0))
    return None


def follow_arc(world, codes, q, direction, length, step=np.radians(1.0)) -> np.ndarray:
    """Along the arc from q towards `direction` (5,) for a length [rad, scaled], in steps of one degree, with the gap table and
    both torque ranges at each; the last configuration. The obvious way: no control of the step, no location of events."""
    count = max(1, int(np.ceil(length / step)))
    for _ in range(count):
        rows, _ = rows_and_gaps(world, codes, q)
        tangent = np.linalg.svd(rows * world.scale)[2][-1] * world.scale
        tangent *= np.sign(tangent / world.scale @ (direction / world.scale)) or 1.0
        q = project(world, codes, q + length / count * tangent, tangent / world.scale**2)
        direction = tangent
        gap_table(world, q)
        load = load_at(world, q)
        for column in (3, 4):
            torque_range(rows_and_gaps(world, codes, q)[0], load, world.torque_limits, column)
    return q
