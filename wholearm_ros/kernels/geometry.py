"""Contact pairs, their gaps and Jacobian rows, and the table of gaps that could close.

A configuration is q = (x, y, φ, θ_L, θ_R), see `model/configuration.py`; a contact pair is one
integer, see `pair_code`. Whoever asks for several pairs of one configuration finds its `frames_of`
once and calls the functions that take them.
"""

from typing import NamedTuple

import numpy as np

from wholearm_ros.kernels import inlined, kernel
from wholearm_ros.kernels.world import joint
from wholearm_ros.model import frame, separation
from wholearm_ros.model.configuration import LEFT_JOINT, RIGHT_JOINT, ROTATION, X, Y
from wholearm_ros.model.frame import Frame
from wholearm_ros.model.hand import LEFT, RIGHT

VERTEX_EDGE, EDGE_CORNER = 0, 1  # object vertex on hand edge; object edge on hand corner
PALM, LEFT_FINGER, RIGHT_FINGER = 0, 1, 2
# How many features a rectangular finger has: its inner, tip, outer and base edge, and the two
# corners at its tip, the inner one first. Those of any other shape have the numbers after these.
RECTANGLE_EDGES, RECTANGLE_CORNERS = 4, 2
SWEEP, HALVINGS = 90, 50  # steps of a closing finger's sweep, and of the bisection of the last one

frame_at = inlined(frame.frame_at)
in_world = inlined(frame.in_world)
in_body = inlined(frame.in_body)
turned = inlined(frame.turned)
point_clearance = inlined(separation.point_clearance)
_rectangle_clearance = inlined(separation.rectangle_clearance, minimum=min, maximum=max)
part_clearance = inlined(separation.part_clearance, minimum=min, maximum=max)


class Frames(NamedTuple):
    """Of the moving bodies at a configuration. A finger's origin is its axis; x runs along it."""

    object: Frame
    left: Frame
    right: Frame


class Edge(NamedTuple):
    """An edge in the world: start x, y [m], unit direction dx, dy, unit normal nx, ny out of its
    body, length [m].
    """

    x: float
    y: float
    dx: float
    dy: float
    nx: float
    ny: float
    length: float


class Contact(NamedTuple):
    """A contact pair at a configuration: point x, y [m], unit normal nx, ny towards the object,
    gap [m], position along its edge and length of that edge [m].
    """

    x: float
    y: float
    nx: float
    ny: float
    gap: float
    along: float
    length: float


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


@inlined
def frames_of(world, q):
    """The `Frames` at q (5,)."""
    return Frames(
        frame_of_object(q),
        finger_frame(world, LEFT, q[LEFT_JOINT]),
        finger_frame(world, RIGHT, q[RIGHT_JOINT]),
    )


@inlined
def frame_of_object(pose):
    """At x, y [m] and rotation [rad], the first three coordinates."""
    return frame_at(pose[X], pose[Y], pose[ROTATION])


@inlined
def finger_frame(world, side, theta):
    """The frame of a finger at a joint angle [rad]."""
    return frame_at(world.fingers[side, 0], world.fingers[side, 1], theta)


@inlined
def frame_of_finger(frames, side):
    """That of the left or the right finger."""
    return frames.left if side == LEFT else frames.right


@inlined
def finger_edge(world, side, feature, at):
    """The `Edge` of a finger whose frame is `at`."""
    row = world.features.edge_rows[side] + feature
    edges = world.features.edges
    x, y = in_world(at, edges[row, 5], edges[row, 6])
    dx, dy = turned(at, edges[row, 7], edges[row, 8])
    nx, ny = turned(at, edges[row, 2], edges[row, 3])
    return Edge(x, y, dx, dy, nx, ny, edges[row, 4])


@inlined
def finger_corner(world, side, feature, at):
    """(x, y) [m] of a corner of a finger whose frame is `at`."""
    row = world.features.corner_rows[side] + feature
    return in_world(at, world.features.corners[row, 0], world.features.corners[row, 1])


@inlined
def palm_edge(world, k):
    """The `Edge` k of the palm; its normal points to the free side."""
    x, y, nx, ny = world.palm[k, 0], world.palm[k, 1], world.palm[k, 2], world.palm[k, 3]
    return Edge(x, y, ny, -nx, nx, ny, world.palm[k, 4])


@inlined
def object_vertex(world, i, at):
    """(x, y) [m] of a vertex of the object, whose frame is `at`."""
    return in_world(at, world.obj[i, 0], world.obj[i, 1])


@inlined
def object_edge(world, j, at):
    """The `Edge` j of the object, whose frame is `at`."""
    x, y = object_vertex(world, j, at)
    nx, ny = turned(at, world.obj[j, 2], world.obj[j, 3])
    return Edge(x, y, -ny, nx, nx, ny, world.obj[j, 4])


@inlined
def hand_edge(world, body, feature, frames):
    """`palm_edge` or `finger_edge`."""
    if body == PALM:
        return palm_edge(world, feature)
    side = body - LEFT_FINGER
    return finger_edge(world, side, feature, frame_of_finger(frames, side))


@inlined
def hand_corner(world, body, feature, frames):
    """(x, y) [m] of a vertex of the palm or of a finger's corner."""
    if body == PALM:
        return world.palm[feature, 0], world.palm[feature, 1]
    side = body - LEFT_FINGER
    return finger_corner(world, side, feature, frame_of_finger(frames, side))


@inlined
def contact(world, code, q):
    """The `Contact` of a pair at q (5,)."""
    return contact_at(world, code, frames_of(world, q))


@inlined
def contact_at(world, code, frames):
    """The `Contact` of a pair where the bodies have these `Frames`."""
    body, hand, mine = pair_body(code), pair_hand_feature(code), pair_object_feature(code)
    if pair_kind(code) == VERTEX_EDGE:
        x, y = object_vertex(world, mine, frames.object)
        edge = hand_edge(world, body, hand, frames)
        nx, ny = edge.nx, edge.ny
    else:
        x, y = hand_corner(world, body, hand, frames)
        edge = object_edge(world, mine, frames.object)
        nx, ny = -edge.nx, -edge.ny
    rx, ry = x - edge.x, y - edge.y
    gap, along = edge.nx * rx + edge.ny * ry, edge.dx * rx + edge.dy * ry
    return Contact(x, y, nx, ny, gap, along, edge.length)


@inlined
def sliding(contact):
    """The contact with its normal turned by +90°: the direction in which the object slides."""
    x, y, nx, ny, gap, along, length = contact
    return Contact(x, y, -ny, nx, gap, along, length)


@inlined
def fill_row(contact, body, frames, row):
    """Row (5,) of ∂(motion of object relative to hand along n at p)/∂q̇: [nᵀ, n·(p−o)^⊥,
    −n·(p−axis)^⊥ in the finger's column].
    """
    row[X], row[Y] = contact.nx, contact.ny
    row[ROTATION] = _moment(contact, frames.object)
    row[LEFT_JOINT], row[RIGHT_JOINT] = 0.0, 0.0
    if body != PALM:
        side = body - LEFT_FINGER
        row[joint(side)] = -_moment(contact, frame_of_finger(frames, side))


@inlined
def _moment(contact, about):
    """n·(p − o)^⊥ [m] about a frame's origin."""
    return -contact.nx * (contact.y - about.y) + contact.ny * (contact.x - about.x)


@kernel
def normal_rows(world, codes, q, rows, gaps):
    """Fill rows (k, 5) = ∂gap/∂q = [G_nᵀ, −J_n] of eq. (1), and gaps (k,)."""
    frames = frames_of(world, q)
    for i in range(codes.shape[0]):
        found = contact_at(world, codes[i], frames)
        fill_row(found, pair_body(codes[i]), frames, rows[i])
        gaps[i] = found.gap


@kernel
def tangent_rows(world, codes, q, rows):
    """Fill rows (k, 5): sliding speed of the object on the hand is rows @ q̇, along the normal
    turned by +90°.
    """
    frames = frames_of(world, q)
    for i in range(codes.shape[0]):
        found = contact_at(world, codes[i], frames)
        fill_row(sliding(found), pair_body(codes[i]), frames, rows[i])


@inlined
def table_size(world):
    """Entries of the gap table: each object vertex with each palm edge and each part of a finger,
    each hand corner with the object.
    """
    return _first_corner(world) + world.features.corners.shape[0] + world.corners.shape[0]


@inlined
def _first_corner(world):
    """The table's first entry of a hand corner: after every vertex with every palm edge and all
    parts of both fingers.
    """
    return world.obj.shape[0] * (world.palm.shape[0] - 1 + world.features.parts.shape[0])


@kernel
def entry_of(world, code):
    """Index of the table's entry that a pair belongs to."""
    n, body, feature = world.obj.shape[0], pair_body(code), pair_hand_feature(code)
    if pair_kind(code) == VERTEX_EDGE:
        column = feature
        if body != PALM:
            column = world.palm.shape[0] - 1 + _part_of_edge(world, body - LEFT_FINGER, feature)
        return column * n + pair_object_feature(code)
    base = _first_corner(world)
    if body != PALM:
        return base + world.features.corner_rows[body - LEFT_FINGER] + feature
    for i in range(world.corners.shape[0]):
        if world.corners[i] == feature:
            return base + world.features.corners.shape[0] + i
    return -1


@inlined
def _part_of_edge(world, side, feature):
    """The part of both fingers' parts that has an edge."""
    parts, row, part = world.features.parts, world.features.edge_rows[side] + feature, 0
    while row >= parts[part, 2]:
        part += 1
    return part


@inlined
def _vertex_on_palm(world, k, i, x, y):
    """A vertex beside the edge's extent has an infinite gap."""
    edge = palm_edge(world, k)
    rx, ry = x - edge.x, y - edge.y
    inside = 0.0 <= edge.dx * rx + edge.dy * ry <= edge.length
    gap = edge.nx * rx + edge.ny * ry if inside else np.inf
    return gap, pair_code(VERTEX_EDGE, PALM, k, i)


@inlined
def _vertex_on_finger(world, part, i, x, y, at):
    """`at`: the frame of the finger that has the part."""
    edges, parts = world.features.edges, world.features.parts
    along, across = in_body(at, x, y)
    best, nearest, side = -np.inf, 0, parts[part, 0]
    for row in range(parts[part, 1], parts[part, 2]):
        gap = edges[row, 2] * along + edges[row, 3] * across - edges[row, 9]
        if gap > best:
            best, nearest = gap, row
    feature = nearest - world.features.edge_rows[side]
    return best, pair_code(VERTEX_EDGE, LEFT_FINGER + side, feature, i)


@inlined
def _object_on_corner(world, k, frames):
    """The corners of the left finger, of the right one, then those of the palm."""
    features = world.features
    count = features.corners.shape[0]
    if k < count:
        side = features.corner_sides[k]
        body, feature = LEFT_FINGER + side, k - features.corner_rows[side]
    else:
        body, feature = PALM, world.corners[k - count]
    x, y = hand_corner(world, body, feature, frames)
    gap, edge = point_clearance(world.obj, frames.object, x, y)
    return gap, pair_code(EDGE_CORNER, body, feature, edge)


@kernel
def table_entry(world, e, frames):
    """(signed gap [m] of an entry's feature to the nearest opposite edge, code of that pair);
    penetration is negative.
    """
    n, p = world.obj.shape[0], world.palm.shape[0] - 1
    if e >= _first_corner(world):
        return _object_on_corner(world, e - _first_corner(world), frames)
    column, i = e // n, e % n
    x, y = object_vertex(world, i, frames.object)
    if column < p:
        return _vertex_on_palm(world, column, i, x, y)
    at = frame_of_finger(frames, world.features.parts[column - p, 0])
    return _vertex_on_finger(world, column - p, i, x, y, at)


@kernel
def gap_table(world, q, gaps, codes):
    """Fill gaps and codes of every `table_entry`."""
    n, p, frames = world.obj.shape[0], world.palm.shape[0] - 1, frames_of(world, q)
    for i in range(n):
        x, y = object_vertex(world, i, frames.object)
        for k in range(p):
            gaps[k * n + i], codes[k * n + i] = _vertex_on_palm(world, k, i, x, y)
        for part in range(world.features.parts.shape[0]):
            e, at = (p + part) * n + i, frame_of_finger(frames, world.features.parts[part, 0])
            gaps[e], codes[e] = _vertex_on_finger(world, part, i, x, y, at)
    for k in range(world.features.corners.shape[0] + world.corners.shape[0]):
        e = _first_corner(world) + k
        gaps[e], codes[e] = _object_on_corner(world, k, frames)


@inlined
def finger_clearance(world, side, theta, at):
    """Separation [m] of a finger at a joint angle [rad] and the object, whose frame is `at`:
    positive apart, negative where they overlap.

    Unlike the gap table, which knows vertices only, it sees a finger that runs right through the
    object.
    """
    finger, length = finger_frame(world, side, theta), world.rectangles[side, 0]
    if length > 0.0:
        half = world.rectangles[side, 1]
        return _rectangle_clearance(world.obj, at, finger, length, half)
    least = np.inf
    for part in range(world.features.parts.shape[0]):
        if world.features.parts[part, 0] == side:
            least = min(least, _part_clearance(world, part, at, finger))
    return least


@inlined
def _part_clearance(world, part, at, finger):
    first, last = world.features.parts[part, 1], world.features.parts[part, 2]
    return part_clearance(world.obj, at, world.features.edges[first:last], finger)


@inlined
def left_the_hand(world, q):
    """Whether the object's centroid is where no finger brings it back from: a third of a finger's
    length beyond an end of the palm, below the palm, or two lengths above an axis.
    """
    palm, fingers = world.palm, world.fingers
    length = max(fingers[LEFT, 2], fingers[RIGHT, 2])
    lowest = palm[0, 1]
    for k in range(palm.shape[0]):
        lowest = min(lowest, palm[k, 1])
    return (
        q[X] < palm[0, 0] - length / 3.0
        or q[X] > palm[palm.shape[0] - 1, 0] + length / 3.0
        or q[Y] < lowest
        or q[Y] > max(fingers[LEFT, 1], fingers[RIGHT, 1]) + 2.0 * length
    )


@kernel
def closing_angle(world, side, pose):
    """Joint angle at which a finger, swept closed from its open limit, first touches the object at
    `pose` (3,) x, y, rotation.

    NaN when it touches at its open limit already, or never.
    """
    at, low, high = frame_of_object(pose), world.limits[side, 0], world.limits[side, 1]
    opened, shut = (high, low) if side == LEFT else (low, high)
    if finger_clearance(world, side, opened, at) <= 0.0:
        return np.nan
    free = opened
    for k in range(1, SWEEP + 1):
        theta = opened + (shut - opened) * k / SWEEP
        if finger_clearance(world, side, theta, at) <= 0.0:
            touching = theta
            for _ in range(HALVINGS):
                middle = 0.5 * (free + touching)
                if finger_clearance(world, side, middle, at) > 0.0:
                    free = middle
                else:
                    touching = middle
            return free
        free = theta
    return np.nan
