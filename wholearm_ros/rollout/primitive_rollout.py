"""Motion primitives: one finger turns from rest to rest while the other holds a torque; where that
leads, only forward dynamics can tell.

The contact state may change on the way as physics wants; no equilibrium of four contacts is needed.
This is the dynamic manipulation of III-B.2 as a step of the search.
"""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.kernels.control_law import PdGains
from wholearm_ros.kernels.rollout import Primitive, PrimitiveCourse, run_primitive
from wholearm_ros.kernels.switch_law import Course
from wholearm_ros.mechanics.world import World
from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.configuration import JOINTS, SIZE, joint_index
from wholearm_ros.model.hand import CLOSING
from wholearm_ros.model.interpolation import PEAK_SPEED
from wholearm_ros.model.motion_primitive import MotionPrimitive

STEP = 0.001  # [s]
PERIOD = 0.004  # [s] of the records
STIFF = PdGains(300.0, 6.0)  # of the velocity finger while its torque is being found
PATH_EVERY = 10  # of the records, kept in a leg
SHORTEST_RAMP = 0.04  # [s]
REST_SPEED = 0.01  # [1/s] in scaled coordinates, of anything at rest


@dataclass(frozen=True, eq=False)
class Rest:
    """Everything at rest: q (5,), and the efforts (2,) [N m] that keep it so."""

    q: np.ndarray
    efforts: np.ndarray


def released(world: World, q: np.ndarray) -> Rest:
    """At rest in q (5,), the fingers bearing only their own weight."""
    return Rest(q, world.bearing(q))


@dataclass(frozen=True, eq=False)
class PrimitiveRecord:
    """A simulated primitive every PERIOD: configurations, velocities (m, 5), efforts (m, 2) and the
    velocity finger's wanted angle (m,); ramp: how many of the samples the torque's ramp takes;
    whether it ended at rest; the LCP's residual; stops_met: (2, 2) bool, whether the left and
    the right finger came to bear on its low and high end stop.
    """

    move: MotionPrimitive
    configurations: np.ndarray
    velocities: np.ndarray
    efforts: np.ndarray
    wanted: np.ndarray
    ramp: int
    at_rest: bool
    residual: float
    stops_met: np.ndarray

    def rest(self) -> Rest:
        """Where it ended."""
        return Rest(self.configurations[-1], self.efforts[-1])

    def path(self, start: Rest) -> np.ndarray:
        """(m, 5) the start, some of the records and the last."""
        last = len(self.configurations) - 1
        places = [*range(PATH_EVERY, last, PATH_EVERY), last]
        return np.vstack([start.q[None], self.configurations[places]])

    def course(self, start: Rest) -> Course:
        """The setpoints that lead the fingers along it, for a rollout."""
        angles, velocities, efforts = self.setpoints(start)
        return Course(
            PERIOD,
            readonly(angles),
            readonly(velocities),
            readonly(efforts),
            readonly([PERIOD * len(self.wanted)]),
            readonly([self.move.velocity_finger], dtype=np.int64),
        )

    def setpoints(self, start: Rest) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(angles (m + 1, 2), velocities, efforts) to lead the fingers along it, the first of them
        at `start`.
        """
        side = self.move.velocity_finger
        angles = np.vstack([start.q[None, JOINTS], self.configurations[:, JOINTS]])
        angles[1:, side] = self.wanted
        velocities = np.zeros_like(angles)
        velocities[1:-1] = (angles[2:] - angles[:-2]) / (2.0 * PERIOD)
        return angles, velocities, np.vstack([start.efforts[None], self.efforts])


def simulate_primitive(world: World, start: Rest, move: MotionPrimitive) -> PrimitiveRecord:
    """Forward dynamics of a primitive from rest, without friction."""
    side = move.velocity_finger
    other = 1 - side
    torque = float(world.bearing(start.q)[other] + CLOSING[other] * move.torque)
    ramp = _steps(max(SHORTEST_RAMP, abs(torque - start.efforts[other]) / move.slew))
    turn = _steps(max(0.06, PEAK_SPEED * abs(move.turn) / move.speed)) if move.turn else 0
    total = ramp + turn + _steps(move.settle)
    every = int(round(PERIOD / STEP))
    size = total // every + 1
    record = PrimitiveCourse(
        np.empty((size, SIZE)),
        np.empty((size, SIZE)),
        np.empty((size, 2)),
        np.empty(size),
        every,
        np.empty(SIZE),
        np.empty(SIZE),
        np.zeros((2, 2), np.bool_),
    )
    settle = _steps(move.settle)
    primitive = Primitive(side, float(move.turn), torque, ramp, turn, settle, STIFF, STEP)
    count, residual = run_primitive(
        world, primitive, start.q, np.asarray(start.efforts, float), record
    )
    if count == 0:  # it left the hand at once
        record.q[0], record.v[0] = record.last_q, record.last_v
        record.efforts[0], record.wanted[0], count = start.efforts, start.q[joint_index(side)], 1
    whole = count == total // every
    at_rest = whole and bool(np.abs(record.last_v / world.scale).max() < REST_SPEED)
    return PrimitiveRecord(
        move,
        record.q[:count],
        record.v[:count],
        record.efforts[:count],
        record.wanted[:count],
        ramp // every,
        at_rest,
        residual,
        record.stops_met,
    )


def _steps(seconds: float) -> int:
    every = int(round(PERIOD / STEP))
    return every * int(np.ceil(seconds / PERIOD - 1e-9))
