"""Strokes: the stretches of a route on which one velocity-controlled finger turns one way without a stop."""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.kernels import arc_tracing
from wholearm_ros.mechanics.contacts import pair_from_name
from wholearm_ros.mechanics.torque_range import ROBUST_FRICTION
from wholearm_ros.mechanics.world import World
from wholearm_ros.model.hand import LEFT, RIGHT
from wholearm_ros.model.motion_primitive import MotionPrimitive
from wholearm_ros.model.plan import Leg
from wholearm_ros.model.trajectory import CAGING, DYNAMIC
from wholearm_ros.trajectory.control_mode import control_mode
from wholearm_ros.trajectory.execution_options import AUTO, FRONT, ExecutionOptions

SLOWEST_DRIVER = 0.02  # least part of the scaled motion that the velocity finger must have in every step of an arc


@dataclass(frozen=True, eq=False)
class Piece:
    """Part of a leg with one velocity finger: its pairs and samples (m, 5); θ_V is strictly monotone along a quasi-static
    one. move: of a dynamic one."""

    mode: str
    pairs: tuple
    samples: np.ndarray
    velocity_finger: int
    move: MotionPrimitive = None

    @property
    def direction(self) -> int:
        column = 3 + self.velocity_finger
        return 1 if self.samples[-1, column] > self.samples[0, column] else -1

    @property
    def turn(self) -> float:
        """Angle [rad] through which the velocity finger turns."""
        column = 3 + self.velocity_finger
        return float(self.samples[-1, column] - self.samples[0, column])


@dataclass(frozen=True, eq=False)
class Followed:
    """A piece at given angles of the velocity finger: configurations (k, 5), statics (k, 4) of the torque finger
    (τ_min, τ_max, and the part good with friction, too), gains (k, 2): equilibrium τ_V = gains[:, 0] + gains[:, 1] τ_T."""

    configurations: np.ndarray
    statics: np.ndarray
    gains: np.ndarray


def pieces_of(world: World, leg: Leg, options: ExecutionOptions) -> list:
    """Cut a leg into pieces, each with a velocity finger that can drive it; the preferred one wherever it can."""
    pairs = tuple(pair_from_name(name) for name in leg.contacts)
    if leg.mode == DYNAMIC:
        move = MotionPrimitive.from_dict(leg.action)
        return [Piece(DYNAMIC, pairs, leg.configurations, move.velocity_finger, move)]
    if leg.mode == CAGING:
        return [
            Piece(
                CAGING, pairs, leg.configurations, LEFT if options.caging_finger == FRONT else RIGHT
            )
        ]
    samples, start, pieces = leg.configurations, 0, []
    steps = np.diff(samples, axis=0) / world.scale
    share = steps[:, 3:] / np.maximum(np.linalg.norm(steps, axis=1), 1e-12)[:, None]  # (m - 1, 2)
    preference = _preference(world, pairs, samples[len(samples) // 2], options)
    while start < len(steps):
        side, stop = max(
            ((side, _run(share[start:, side])) for side in preference), key=lambda c: c[1]
        )
        first = preference[0]
        if _run(share[start:, first]) == len(steps) - start:
            side, stop = first, len(steps) - start
        stop = max(stop, 1)
        pieces.append(Piece(leg.mode, pairs, samples[start : start + stop + 1], side))
        start += stop
    return pieces


def _run(share):
    """How many steps from the first on go the same way, and far enough."""
    same = (np.sign(share) == np.sign(share[0])) & (np.abs(share) > SLOWEST_DRIVER)
    return len(share) if same.all() else int(np.argmin(same))


def _preference(world, pairs, q, options):
    if options.velocity_finger != AUTO:
        first = LEFT if options.velocity_finger == FRONT else RIGHT
    else:
        modes = [control_mode(world, pairs, q, side) for side in (LEFT, RIGHT)]
        first = min(modes, key=lambda m: (m.degree_of_constraint, -m.conditioning)).velocity_finger
    return first, 1 - first


def follow(world: World, piece: Piece, thetas: np.ndarray) -> Followed:
    """Forward kinematics (3) and torque ranges (6) of a piece at the velocity finger's angles (k,).

    Raises ValueError when the contacts cannot be kept closed at one of them (the plan is not of this scenario).
    """
    k, driver = len(thetas), piece.velocity_finger
    out, statics, gains = np.empty((k, 5)), np.empty((k, 2, 4)), np.empty((k, 2))
    done = arc_tracing.follow(
        *world.geometry,
        np.array(piece.pairs, dtype=np.int64),
        piece.samples,
        driver,
        thetas,
        world.load,
        world.finger_moment,
        world.torque_limits,
        ROBUST_FRICTION,
        out,
        statics,
        gains,
    )
    if done < k:
        raise ValueError(f'contacts cannot be kept closed at θ_V = {thetas[done]:.4f} rad')
    return Followed(out, statics[:, 1 - driver], gains)
