"""Moves that only forward dynamics can predict: one finger turns from rest to rest while the other holds a torque.

The contact state may change on the way as physics wants; no equilibrium of four contacts is needed. This is the dynamic
manipulation of III-B.2 as a step of the search.
"""
from dataclasses import dataclass, replace

import numpy as np

from ..errors import DocumentError
from ..kernels import stepping
from ..model.hand import CLOSING, SIDES
from .world import World

STEP = 0.001            # [s]
PERIOD = 0.004          # [s] of the records
STIFF = (300.0, 6.0)    # PD gains of the velocity finger while its torque is being found [N m/rad, N m s/rad]
SHORTEST_RAMP = 0.04    # [s]
REST_SPEED = 0.01       # [rad/s], [0.1 m/s] of anything at rest
PEAK_SPEED = 15.0 / 8.0


@dataclass(frozen=True)
class Move:
    """velocity_finger: LEFT or RIGHT; turn [rad] of it; torque [N m] of the other one towards closing, beyond what holds it
    against gravity; speed [rad/s]: greatest of the turn; settle [s]: time to come to rest after it; slew [N m/s]: of the torque."""

    velocity_finger: int
    turn: float
    torque: float
    speed: float = 1.2
    settle: float = 0.16
    slew: float = 20.0

    def to_dict(self) -> dict:
        return {'velocity_finger': SIDES[self.velocity_finger], 'turn': self.turn, 'torque': self.torque,
                'speed': self.speed, 'settle': self.settle, 'slew': self.slew}

    @classmethod
    def from_dict(cls, d: dict) -> 'Move':
        """Raises DocumentError when something is missing or of the wrong kind."""
        try:
            return cls(SIDES.index(d['velocity_finger']), float(d['turn']), float(d['torque']), float(d['speed']),
                       float(d['settle']), float(d['slew']))
        except (KeyError, ValueError, TypeError, AttributeError) as error:
            raise DocumentError(f'plan document: action {d!r} of a dynamic leg is damaged: {error}') from error

    def mirrored(self) -> 'Move':
        return replace(self, velocity_finger=1 - self.velocity_finger, turn=-self.turn)


@dataclass(frozen=True, eq=False)
class Rest:
    """Everything at rest: q (5,), and the efforts (2,) [N m] that keep it so."""

    q: np.ndarray
    efforts: np.ndarray


@dataclass(frozen=True, eq=False)
class MoveRecord:
    """A simulated move every PERIOD: configurations, velocities (m, 5), efforts (m, 2) and the velocity finger's wanted
    angle (m,); ramp: how many of the samples the torque's ramp takes; whether it ended at rest; the LCP's residual."""

    move: Move
    configurations: np.ndarray
    velocities: np.ndarray
    efforts: np.ndarray
    wanted: np.ndarray
    ramp: int
    at_rest: bool
    residual: float

    def rest(self) -> Rest:
        """Where it ended."""
        return Rest(self.configurations[-1], self.efforts[-1])

    def setpoints(self, start: Rest) -> tuple:
        """(angles (m + 1, 2), velocities, efforts) to lead the fingers along it, the first of them at `start`."""
        side = self.move.velocity_finger
        angles = np.vstack([start.q[None, 3:], self.configurations[:, 3:]])
        angles[1:, side] = self.wanted
        velocities = np.zeros_like(angles)
        velocities[1:-1] = (angles[2:] - angles[:-2]) / (2.0 * PERIOD)
        return angles, velocities, np.vstack([start.efforts[None], self.efforts])


def simulate_move(world: World, start: Rest, move: Move) -> MoveRecord:
    """Forward dynamics of a move from rest, without friction."""
    side = move.velocity_finger
    other = 1 - side
    torque = float(world.finger_moment[other] * np.cos(start.q[3 + other]) + CLOSING[other] * move.torque)
    ramp = _steps(max(SHORTEST_RAMP, abs(torque - start.efforts[other]) / move.slew))
    turn = _steps(max(0.06, PEAK_SPEED * abs(move.turn) / move.speed)) if move.turn else 0
    total = ramp + turn + _steps(move.settle)
    every = int(round(PERIOD / STEP))
    size = total // every + 1
    q, v = start.q.copy(), np.zeros(5)
    qs, vs, efforts, wanted = np.empty((size, 5)), np.empty((size, 5)), np.empty((size, 2)), np.empty(size)
    count, residual = stepping.run_move(
        *world.geometry, world.corners, world.inertias, world.load, world.finger_moment, world.torque_limits, side,
        float(move.turn), torque, np.asarray(start.efforts, float), ramp, turn, _steps(move.settle), *STIFF, STEP, every, q, v,
        qs, vs, efforts, wanted)
    whole = count == total // every
    at_rest = whole and bool(np.abs(v / world.scale).max() < REST_SPEED)
    return MoveRecord(move, qs[:count], vs[:count], efforts[:count], wanted[:count], ramp // every, at_rest, residual)


def _steps(seconds):
    every = int(round(PERIOD / STEP))
    return every * int(np.ceil(seconds / PERIOD - 1e-9))
