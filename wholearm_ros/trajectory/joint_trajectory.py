"""A trajectory while it is being put together: samples and segments, appended stroke by stroke."""

from dataclasses import replace

import numpy as np

from wholearm_ros.mechanics.contacts import pair_name
from wholearm_ros.mechanics.world import World
from wholearm_ros.model.motion_primitive import MotionPrimitive
from wholearm_ros.model.trajectory import (
    DWELL,
    DYNAMIC,
    QUASI_STATIC,
    ManipulationTrajectory,
    Segment,
)
from wholearm_ros.rollout.primitive_rollout import PERIOD, Rest, simulate_primitive
from wholearm_ros.trajectory.control_mode import control_mode
from wholearm_ros.trajectory.execution_options import ExecutionOptions

SHORTEST_RAMP = 0.02  # [s]


class TrajectoryBuilder:
    """Starts at rest in q (5,), both fingers carrying only themselves."""

    def __init__(self, world: World, q: np.ndarray, options: ExecutionOptions):
        self.world, self.options, self.transitions = world, options, []
        self._stands = np.asarray(q, float)
        self._q = [self._stands[None]]
        self._efforts = [(world.finger_moment * np.cos(q[3:]))[None]]
        self._ranges = [np.full((1, 2), np.nan)]
        self._segments, self._count = [], 1

    def ramp_to(self, efforts: np.ndarray, velocity_finger: int, pairs: tuple):
        """Dwell: at rest, the efforts (2,) change linearly. Both ends are equilibria of the closed contacts, and so,
        as equilibria are convex in the forces, is everything between."""
        before = self._efforts[-1][-1]
        ramp = max(SHORTEST_RAMP, float(np.abs(efforts - before).max()) / self.options.slew)
        count = int(np.ceil(ramp / self.options.period))
        rest = int(np.ceil(self.options.settle / self.options.period))
        u = np.concatenate([np.arange(1, count + 1) / count, np.ones(rest)])[:, None]
        values = (1.0 - u) * before + u * efforts
        self._append(
            np.repeat(self._q[-1][-1:], len(u), axis=0), values, np.full((len(u), 2), np.nan)
        )
        self._close(DWELL, velocity_finger, pairs, len(u))

    def break_equilibrium(self, efforts: np.ndarray, velocity_finger: int, pairs: tuple):
        """Dynamic manipulation: the efforts (2,) are reached, from `dynamic_lead` before the end of the last stroke on,
        where they are more than its contact state can carry, and kept until the object has come to rest in the next one."""
        period, lead = self.options.period, self._lead()
        before = self._efforts[-1][-lead - 1]
        ramp = max(1, int(np.ceil(np.abs(efforts - before).max() / (self.options.slew * period))))
        after = max(ramp - lead, 0) + int(np.ceil(self.options.dynamic_hold / period))
        u = np.minimum(np.arange(1, lead + after + 1) / ramp, 1.0)[:, None]
        values = (1.0 - u) * before + u * efforts
        self._efforts[-1][-lead:] = values[:lead]
        last = self._segments.pop()
        self._segments.append(replace(last, end=last.end - lead * period))
        self._append(
            np.repeat(self._q[-1][-1:], after, axis=0), values[lead:], np.full((after, 2), np.nan)
        )
        self._close(DYNAMIC, velocity_finger, pairs, lead + after)

    def _lead(self):
        """Samples of the last stroke, of which at least one is left to it."""
        segment = self._segments[-1]
        whole = int(round((segment.end - segment.start) / self.options.period))
        return max(
            1,
            min(
                int(round(self.options.dynamic_lead / self.options.period)),
                whole - 1,
                len(self._q[-1]) - 1,
            ),
        )

    def extend(
        self,
        mode: str,
        velocity_finger: int,
        q: np.ndarray,
        efforts: np.ndarray,
        ranges: np.ndarray,
        pieces: list,
        of_piece: np.ndarray,
    ):
        """Append a stroke whose first sample is where the trajectory stands; one segment for each piece of it."""
        self._append(q[1:], efforts[1:], ranges[1:])
        self._ranges[-2][-1] = ranges[0]
        for k, piece in enumerate(pieces):
            count = int((of_piece[1:] == k).sum())
            if count:
                self._close(mode, velocity_finger, piece.pairs, count)

    def extend_move(self, move: MotionPrimitive, pairs: tuple):
        """Append a move from where the hand stands: its torque ramp as a dwell, the rest of it as dynamic."""
        start = Rest(self._stands, self._efforts[-1][-1])
        record = simulate_primitive(self.world, start, move)
        if not record.at_rest:
            raise ValueError(f'move {move.to_dict()} does not end at rest')
        if abs(self.options.period - PERIOD) > 1e-12:
            raise ValueError(
                f'period {self.options.period} s; dynamic legs are made for {PERIOD} s'
            )
        q = record.configurations.copy()
        q[:, 3:] = record.setpoints(start)[0][1:]
        none = np.full((len(q), 2), np.nan)
        ramp = record.ramp
        self._append(q[:ramp], record.efforts[:ramp], none[:ramp])
        self._close(DWELL, move.velocity_finger, pairs, ramp)
        self._append(q[ramp:], record.efforts[ramp:], none[ramp:])
        self._close(DYNAMIC, move.velocity_finger, pairs, len(q) - ramp)
        self._stands = record.configurations[
            -1
        ]  # a stiff finger is not quite where it was told to be

    def hold(self, seconds: float):
        """Stay where it is; the fingers keep their torques."""
        count = int(np.ceil(seconds / self.options.period))
        self._append(
            np.repeat(self._q[-1][-1:], count, axis=0),
            np.repeat(self._efforts[-1][-1:], count, axis=0),
            np.full((count, 2), np.nan),
        )
        self._segments[-1] = replace(self._segments[-1], end=self._time())

    def finish(self, plan_id: str) -> ManipulationTrajectory:
        """The trajectory so far."""
        q, period = np.concatenate(self._q), self.options.period
        velocities = np.zeros((len(q), 2))
        velocities[1:-1] = (q[2:, 3:] - q[:-2, 3:]) / (2.0 * period)
        return ManipulationTrajectory(
            plan_id,
            period,
            q[:, 3:],
            velocities,
            np.concatenate(self._efforts),
            np.concatenate(self._ranges),
            q[:, :3],
            tuple(self._segments),
            tuple(self.transitions),
        )

    def _time(self):
        return (self._count - 1) * self.options.period

    def _append(self, q, efforts, ranges):
        self._q.append(q)
        self._stands = q[-1]
        self._efforts.append(efforts)
        self._ranges.append(ranges)
        self._count += len(q)

    def _close(self, mode, velocity_finger, pairs, count):
        start = self._segments[-1].end if self._segments else 0.0
        end = start + count * self.options.period
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
                end,
                mode,
                velocity_finger,
                tuple(map(pair_name, pairs)),
                tuple(m.degree_of_constraint for m in modes),
                tuple(m.conditioning for m in modes),
            )
        )
