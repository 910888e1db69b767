"""Monotone segments: pieces of a leg along which one velocity-controlled finger turns one way."""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.kernels import arc_tracing
from wholearm_ros.kernels.world import World
from wholearm_ros.mechanics.contacts import pair_from_name
from wholearm_ros.mechanics.torque_range import ROBUST_FRICTION
from wholearm_ros.model.configuration import JOINTS, SIZE, joint_index
from wholearm_ros.model.hand import LEFT, RIGHT
from wholearm_ros.model.modes import CAGING, DYNAMIC
from wholearm_ros.model.motion_primitive import MotionPrimitive
from wholearm_ros.model.plan import Leg
from wholearm_ros.trajectory.control_mode import control_mode
from wholearm_ros.trajectory.execution_options import AUTO, FRONT, ExecutionOptions

# Least part of the scaled motion that the velocity finger must have in every step of an arc.
SLOWEST_DRIVER = 0.02


@dataclass(frozen=True, eq=False)
class Piece:
    """Part of a leg with one velocity finger.

    mode: of the leg; pairs: closed contacts; samples: (m, 5) configurations [m, rad], along which
    θ_V is strictly monotone if quasi-static; move: the motion primitive of a dynamic piece;
    torque: τ_caging of a descent [N m].
    """

    mode: str
    pairs: tuple[int, ...]
    samples: np.ndarray
    velocity_finger: int
    move: MotionPrimitive | None = None
    torque: float = 0.0

    @property
    def direction(self) -> int:
        """Sign of that turn."""
        column = joint_index(self.velocity_finger)
        return 1 if self.samples[-1, column] > self.samples[0, column] else -1

    @property
    def turn(self) -> float:
        """Angle [rad] through which the velocity finger turns."""
        column = joint_index(self.velocity_finger)
        return float(self.samples[-1, column] - self.samples[0, column])


@dataclass(frozen=True, eq=False)
class Followed:
    """A piece at given angles of the velocity finger.

    configurations: (k, 5) [m, rad]; statics: (k, 4) [N m], τ_min and τ_max of the torque finger,
    and both ends of the friction-robust part of that range; gains: (k, 2), of the equilibrium
    τ_V = gains[:, 0] + gains[:, 1] τ_T.
    """

    configurations: np.ndarray
    statics: np.ndarray
    gains: np.ndarray


def pieces_of(world: World, leg: Leg, options: ExecutionOptions) -> list[Piece]:
    """A leg cut into pieces, each with a velocity finger that can drive it: the preferred one
    wherever it can (III-B.4).
    """
    options = options.of_leg(leg)
    pairs = tuple(pair_from_name(name) for name in leg.contacts)
    if leg.mode == DYNAMIC:
        move = MotionPrimitive.from_dict(leg.action)
        return [Piece(DYNAMIC, pairs, leg.configurations, move.velocity_finger, move)]
    if leg.mode == CAGING:
        side = LEFT if options.caging_finger == FRONT else RIGHT
        torque = options.caging_torque
        return [Piece(CAGING, pairs, leg.configurations, side, torque=torque)]
    pieces: list[Piece] = []
    samples, start = leg.configurations, 0
    steps = np.diff(samples, axis=0) / world.scale
    share = (
        steps[:, JOINTS] / np.maximum(np.linalg.norm(steps, axis=1), 1e-12)[:, None]
    )  # (m - 1, 2)
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


def _run(share: np.ndarray) -> int:
    """How many of the steps (k,), from the first on, go the same way, and far enough."""
    same = (np.sign(share) == np.sign(share[0])) & (np.abs(share) > SLOWEST_DRIVER)
    return len(share) if same.all() else int(np.argmin(same))


def _preference(
    world: World, pairs: tuple[int, ...], q: np.ndarray, options: ExecutionOptions
) -> tuple[int, int]:
    """Both fingers, the one that should be velocity-controlled first."""
    if options.velocity_finger != AUTO:
        first = LEFT if options.velocity_finger == FRONT else RIGHT
    else:
        modes = [control_mode(world, pairs, q, side) for side in (LEFT, RIGHT)]
        first = min(modes, key=lambda m: (m.degree_of_constraint, -m.conditioning)).velocity_finger
    return first, 1 - first


def follow(world: World, piece: Piece, thetas: np.ndarray) -> Followed:
    """Forward kinematics (3) and torque ranges (6) of a piece at the velocity finger's angles (k,).

    Raises ValueError when the contacts cannot be kept closed at one of them (the plan is not of
    this scenario).
    """
    k, driver = len(thetas), piece.velocity_finger
    course = arc_tracing.FollowedCourse(np.empty((k, SIZE)), np.empty((k, 2, 4)), np.empty((k, 2)))
    pairs = np.array(piece.pairs, dtype=np.int64)
    following = arc_tracing.Following(pairs, piece.samples, driver, ROBUST_FRICTION)
    done = arc_tracing.follow(world, following, thetas, course)
    if done < k:
        raise ValueError(f'contacts cannot be kept closed at θ_V = {thetas[done]:.4f} rad')
    return Followed(course.configurations, course.statics[:, 1 - driver], course.gains)
