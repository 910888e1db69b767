"""Motion and torque along a segment: Make_JointTraj, FwdKinematics and GET_TORQUE (III-B.5, steps 5
to 7).
"""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.kernels.interpolation import slew_limited
from wholearm_ros.kernels.world import World
from wholearm_ros.model.configuration import ROTATION, SIZE, joint_index
from wholearm_ros.model.hand import CLOSING
from wholearm_ros.model.interpolation import quintic
from wholearm_ros.model.modes import CAGING, DYNAMIC
from wholearm_ros.trajectory.boundary_subgoals import MonotoneSegment
from wholearm_ros.trajectory.check_transition import check_dyn
from wholearm_ros.trajectory.execution_options import ExecutionOptions
from wholearm_ros.trajectory.get_torque import dynamic_torque, quasi_static_torque
from wholearm_ros.trajectory.monotone_segments import Followed, Piece, follow
from wholearm_ros.trajectory.timing import segment_duration


@dataclass(frozen=True, eq=False)
class SegmentMotion:
    """A segment sampled every period, from rest to rest.

    configurations: (m, 5) [m, rad]; efforts: (m, 2) [N m]; ranges: (m, 2) torque range of the
    torque finger [N m], NaN without one; of_piece: (m,) the piece in which each sample lies;
    dynamic: whether it begins by a dynamic transition instead of a dwell; holding: (2,) efforts
    [N m] after its end, None for those at its end. Of a motion primitive, which is simulated from
    where the hand stands, nothing is sampled.
    """

    segment: MonotoneSegment
    configurations: np.ndarray
    efforts: np.ndarray
    ranges: np.ndarray
    of_piece: np.ndarray
    dynamic: bool = False
    holding: np.ndarray | None = None


def motion_of(world: World, segment: MonotoneSegment, options: ExecutionOptions) -> SegmentMotion:
    """Steps 5 to 7 for a segment of any mode.

    Raises ValueError when its contacts cannot be kept closed (the plan is not of this scenario).
    """
    if segment.mode == DYNAMIC:
        none = np.empty((0, 2))
        return SegmentMotion(segment, np.empty((0, SIZE)), none, none, np.empty(0, int))
    if segment.mode == CAGING:
        return _descent(world, segment, options)
    return _quasi_static(world, segment, options)


def _quasi_static(
    world: World, segment: MonotoneSegment, options: ExecutionOptions
) -> SegmentMotion:
    side = segment.velocity_finger
    other = 1 - side
    start = segment.pieces[0].samples[0, joint_index(side)]
    fastest = max(_fastest(world, piece) for piece in segment.pieces)
    thetas = start + segment.turn * _rest_to_rest(segment.turn, fastest, options)  # step 5
    followed, of_piece = _follow_all(world, segment, thetas)  # step 6
    limit = world.torque_limits[other]
    torque = quasi_static_torque(followed.statics, other, options, limit)  # step 7
    first = _breaking_torque(world, segment, followed.configurations[0], options)
    if first is not None:
        torque = slew_limited(torque, first, options.slew * options.period)
    efforts = np.empty((len(thetas), 2))
    efforts[:, other] = torque
    efforts[:, side] = followed.gains[:, 0] + followed.gains[:, 1] * torque
    ranges = followed.statics[:, :2]
    dynamic = first is not None
    return SegmentMotion(segment, followed.configurations, efforts, ranges, of_piece, dynamic)


def _breaking_torque(
    world: World, segment: MonotoneSegment, q: np.ndarray, options: ExecutionOptions
) -> float | None:
    """GET_TORQUE step 4: the torque [N m] that breaks the equilibrium at the beginning q (5,) of
    the segment, None where there is no need, or where Check_Dyn does not agree.
    """
    report, other = segment.untransitable, 1 - segment.velocity_finger
    if report is None or options.transition != DYNAMIC:
        return None
    torque = dynamic_torque(report, other, options, world.torque_limits[other])
    breaks = check_dyn(world, q, report, other, torque, segment.pieces[0].direction)
    return torque if breaks else None


def _descent(world: World, segment: MonotoneSegment, options: ExecutionOptions) -> SegmentMotion:
    """Caging: the object descends at a limited speed between the fingers, then is held (III-B.3).

    The velocity finger stays closed on where the object should be; the other one has a small
    torque, τ_caging.
    """
    (piece,), side = segment.pieces, segment.velocity_finger
    other, rotation = 1 - side, piece.samples[:, ROTATION]
    turn = rotation[-1] - rotation[0]
    steps = np.abs(np.diff(piece.samples[:, joint_index(side)]))
    fastest = float(np.max(steps / np.maximum(np.diff(rotation), 1e-9)))
    angle = rotation[0] + turn * _rest_to_rest(turn, fastest, options)
    q = np.column_stack([np.interp(angle, rotation, piece.samples[:, j]) for j in range(SIZE)])
    efforts = world.bearing(q)
    holding = efforts[-1].copy()
    efforts[:, other] += CLOSING[other] * piece.torque
    holding[other] += CLOSING[other] * options.holding_torque
    none, of_piece = np.full((len(q), 2), np.nan), np.zeros(len(q), int)
    return SegmentMotion(segment, q, efforts, none, of_piece, holding=holding)


def _rest_to_rest(distance: float, fastest: float, options: ExecutionOptions) -> np.ndarray:
    """(m,) Make_JointTraj: from 0 to 1 by the fifth-order polynomial, every period; distance [rad]
    and fastest: see `segment_duration`.
    """
    duration = segment_duration(distance, fastest, options.speed, options.acceleration)
    count = int(np.ceil(duration / options.period))
    position: np.ndarray = quintic(np.linspace(0.0, 1.0, count + 1))[0]
    return position


def _follow_all(
    world: World, segment: MonotoneSegment, thetas: np.ndarray
) -> tuple[Followed, np.ndarray]:
    """FwdKinematics at the velocity finger's angles (m,), each by the piece in whose reach it lies;
    and (m,) which piece that is.
    """
    column, direction = joint_index(segment.velocity_finger), segment.pieces[0].direction
    ends = np.array([piece.samples[-1, column] for piece in segment.pieces[:-1]])
    of_piece = np.searchsorted(ends * direction, thetas * direction, side='left')
    parts = [follow(world, piece, thetas[of_piece == k]) for k, piece in enumerate(segment.pieces)]
    joined = (
        np.concatenate([getattr(part, name) for part in parts])
        for name in ('configurations', 'statics', 'gains')
    )
    return Followed(*joined), of_piece


def _fastest(world: World, piece: Piece) -> float:
    """Largest ratio, over the piece, of the speed of the fastest coordinate to that of the velocity
    finger, in scaled coordinates.
    """
    steps = np.abs(np.diff(piece.samples, axis=0) / world.scale)
    driven = np.maximum(steps[:, joint_index(piece.velocity_finger)], 1e-9)
    return float((steps.max(axis=1) / driven).max())
