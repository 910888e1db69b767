"""A trajectory while it is being put together, from one monotone segment to the next."""

from dataclasses import replace
from typing import Any

import numpy as np

from wholearm_ros.kernels.world import World
from wholearm_ros.mechanics.contacts import pair_name
from wholearm_ros.model.configuration import JOINTS, POSE
from wholearm_ros.model.modes import DWELL, DYNAMIC, QUASI_STATIC
from wholearm_ros.model.motion_primitive import MotionPrimitive
from wholearm_ros.model.trajectory import ManipulationTrajectory, Segment
from wholearm_ros.rollout.primitive_rollout import PERIOD, Rest, simulate_primitive
from wholearm_ros.trajectory.control_mode import control_mode
from wholearm_ros.trajectory.execution_options import ExecutionOptions
from wholearm_ros.trajectory.segment_motion import SegmentMotion

SHORTEST_RAMP = 0.02  # [s]
NONE = np.full(2, np.nan)  # the torque range of a sample that has none


class TrajectoryBuilder:
    """Goes on from where everything is at rest.

    A dynamic transition takes up the end of the segment before it, so that every segment is
    appended with the one that follows; what has been appended stays as it is.
    """

    def __init__(self, world: World, start: Rest, options: ExecutionOptions) -> None:
        self.world, self.options = world, options
        self._stands = np.asarray(start.q, float)  # (5,) configuration at the end
        self._q = [self._stands[None]]
        self._efforts = [np.asarray(start.efforts, float)[None]]
        self._ranges = [NONE[None]]
        self._segments: list[Segment] = []

    def append(self, motion: SegmentMotion, following: SegmentMotion | None) -> None:
        """Get_NewConfig: a segment, with the dwell before it and the dynamic transition after it,
        if `following` begins with one.
        """
        first, side = motion.segment.pieces[0], motion.segment.velocity_finger
        if first.move is not None:
            self._append_primitive(first.move, first.pairs)
            return
        if not motion.dynamic:
            self._ramp_to(motion.efforts[0], side, first.pairs, motion.ranges[0])
        if following is not None and following.dynamic:
            self._append_into(motion, following)
        else:
            self._append_samples(motion.configurations[1:], motion.efforts[1:], motion.ranges[1:])
            self._close_pieces(motion)
        if motion.holding is not None:
            self._ramp_to(motion.holding, side, first.pairs)

    def _append_into(self, motion: SegmentMotion, following: SegmentMotion) -> None:
        """Dynamic manipulation: the first efforts of `following`, more than the contact state of
        this segment can carry, are reached from `dynamic_lead` before its end on, and kept until
        the object has come to rest in the next contact state.
        """
        period, efforts = self.options.period, following.efforts[0]
        lead = self._lead(motion)
        before = motion.efforts[-lead - 1]
        ramp = max(1, int(np.ceil(np.abs(efforts - before).max() / (self.options.slew * period))))
        after = max(ramp - lead, 0) + int(np.ceil(self.options.dynamic_hold / period))
        u = np.minimum(np.arange(1, lead + after + 1) / ramp, 1.0)[:, None]
        values = (1.0 - u) * before + u * efforts
        changed = np.vstack([motion.efforts[1:-lead], values[:lead]])
        self._append_samples(motion.configurations[1:], changed, motion.ranges[1:])
        self._close_pieces(motion)
        cut = self._segments[-1]
        self._segments[-1] = replace(cut, end=cut.end - lead * period)
        self._append_rest(values[lead:], following.ranges[0])
        first = following.segment.pieces[0]
        self._close(DYNAMIC, following.segment.velocity_finger, first.pairs, lead + after)

    def _lead(self, motion: SegmentMotion) -> int:
        """Samples at the end of a segment that a dynamic transition takes up; at least one is left
        to the last piece.
        """
        wanted = int(round(self.options.dynamic_lead / self.options.period))
        of_last_piece = int((motion.of_piece[1:] == motion.of_piece[-1]).sum())
        return max(1, min(wanted, of_last_piece - 1))

    def _ramp_to(
        self,
        efforts: np.ndarray,
        velocity_finger: int,
        pairs: tuple[int, ...],
        last_range: np.ndarray = NONE,
    ) -> None:
        """Dwell: at rest, the efforts (2,) change linearly. Both ends are equilibria of the closed
        contacts, and so is everything between, as equilibria are convex in the forces.

        last_range: (2,) of the last sample [N m].
        """
        before = self._efforts[-1][-1]
        ramp = max(SHORTEST_RAMP, float(np.abs(efforts - before).max()) / self.options.slew)
        count = int(np.ceil(ramp / self.options.period))
        rest = int(np.ceil(self.options.settle / self.options.period))
        u = np.concatenate([np.arange(1, count + 1) / count, np.ones(rest)])[:, None]
        self._append_rest((1.0 - u) * before + u * efforts, last_range)
        self._close(DWELL, velocity_finger, pairs, len(u))

    def _append_primitive(self, move: MotionPrimitive, pairs: tuple[int, ...]) -> None:
        """A motion primitive from where the hand stands: its torque ramp as a dwell, the rest of it
        as dynamic.
        """
        start = Rest(self._stands, self._efforts[-1][-1])
        record = simulate_primitive(self.world, start, move)
        if not record.at_rest:
            raise ValueError(f'primitive {move.to_dict()} does not end at rest')
        if abs(self.options.period - PERIOD) > 1e-12:
            raise ValueError(
                f'period {self.options.period} s; dynamic legs are made for {PERIOD} s'
            )
        q = record.configurations.copy()
        q[:, JOINTS] = record.setpoints(start)[0][1:]
        none, ramp = np.full((len(q), 2), np.nan), record.ramp
        self._append_samples(q[:ramp], record.efforts[:ramp], none[:ramp])
        self._close(DWELL, move.velocity_finger, pairs, ramp)
        self._append_samples(q[ramp:], record.efforts[ramp:], none[ramp:])
        self._close(DYNAMIC, move.velocity_finger, pairs, len(q) - ramp)
        self._stands = record.configurations[-1]  # even a stiff finger is not quite at its setpoint

    def hold(self, seconds: float) -> None:
        """Stay there; the fingers keep their torques."""
        count = int(np.ceil(seconds / self.options.period))
        self._append_rest(np.repeat(self._efforts[-1][-1:], count, axis=0), NONE)
        end = (sum(map(len, self._q)) - 1) * self.options.period
        self._segments[-1] = replace(self._segments[-1], end=end)

    def finish(
        self, plan_id: str, transitions: tuple[dict[str, Any], ...]
    ) -> ManipulationTrajectory:
        """The trajectory so far; transitions: reports of Check_Transition, for its document."""
        q, period = np.concatenate(self._q), self.options.period
        velocities = np.zeros((len(q), 2))
        velocities[1:-1] = (q[2:, JOINTS] - q[:-2, JOINTS]) / (2.0 * period)
        return ManipulationTrajectory(
            plan_id,
            period,
            q[:, JOINTS],
            velocities,
            np.concatenate(self._efforts),
            np.concatenate(self._ranges),
            q[:, POSE],
            tuple(self._segments),
            transitions,
        )

    def _append_rest(self, efforts: np.ndarray, last_range: np.ndarray) -> None:
        """Samples at the configuration reached, with efforts (k, 2) and no ranges but the last."""
        ranges = np.full((len(efforts), 2), np.nan)
        ranges[-1] = last_range
        self._append_samples(np.repeat(self._q[-1][-1:], len(efforts), axis=0), efforts, ranges)

    def _append_samples(self, q: np.ndarray, efforts: np.ndarray, ranges: np.ndarray) -> None:
        """Samples (k, 5), (k, 2), (k, 2), of no segment yet."""
        self._q.append(q)
        self._stands = q[-1]
        self._efforts.append(efforts)
        self._ranges.append(ranges)

    def _close_pieces(self, motion: SegmentMotion) -> None:
        """A segment of the document for each piece of what was appended."""
        for k, piece in enumerate(motion.segment.pieces):
            count = int((motion.of_piece[1:] == k).sum())
            if count:
                self._close(piece.mode, piece.velocity_finger, piece.pairs, count)

    def _close(self, mode: str, velocity_finger: int, pairs: tuple[int, ...], count: int) -> None:
        """The segment of the document for the last `count` samples, which belong to none yet."""
        start = self._segments[-1].end if self._segments else 0.0
        modes = (
            [
                control_mode(self.world, pairs, self._q[-1][-1], side)
                for side in (velocity_finger, 1 - velocity_finger)
            ]
            if len(pairs) == 4 and mode == QUASI_STATIC
            else []
        )
        self._segments.append(
            Segment(
                start,
                start + count * self.options.period,
                mode,
                velocity_finger,
                tuple(map(pair_name, pairs)),
                tuple(m.degree_of_constraint for m in modes),
                tuple(m.conditioning for m in modes),
            )
        )
