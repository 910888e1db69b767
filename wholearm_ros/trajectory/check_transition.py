"""Check_Transition: whether the contact state can change while the hand keeps moving
quasi-statically (III-B.1).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from wholearm_ros.kernels.world import World
from wholearm_ros.mechanics.contacts import pair_from_name, pair_name
from wholearm_ros.mechanics.forward_dynamics import (
    Inputs,
    build_forward_dynamics,
    solve_forward_dynamics,
)
from wholearm_ros.model.configuration import SIZE, joint_index
from wholearm_ros.model.modes import QUASI_STATIC
from wholearm_ros.trajectory.control_mode import control_mode
from wholearm_ros.trajectory.monotone_segments import Piece, follow

LEAST_OVERLAP = 0.05  # [N m] of the ranges before and after, for a transition in motion
LEAST_CONDITIONING = 1e-4
SETTING_OUT = 1.0  # [rad/s²] of the velocity finger when Check_Dyn solves the forward dynamics
NEAREST = 4  # samples on either side of a singular transition among which a range is looked for


@dataclass(frozen=True)
class TransitionReport:
    """Conditions 1) and 2) of III-B.1 between two contact states.

    before, after: names of their closed pairs; velocity_unique: condition 1; range_before,
    range_after: torque ranges (τ_min, τ_max) on either side [N m].
    """

    before: tuple[str, ...]
    after: tuple[str, ...]
    velocity_unique: bool
    range_before: tuple[float, float]
    range_after: tuple[float, float]

    @property
    def overlap(self) -> float:
        """Width [N m] of what both ranges share, negative when they are apart."""
        high = min(self.range_before[1], self.range_after[1])
        return high - max(self.range_before[0], self.range_after[0])

    @property
    def quasi_static(self) -> bool:
        """Whether both conditions hold, the second with LEAST_OVERLAP."""
        return self.velocity_unique and self.overlap >= LEAST_OVERLAP

    def to_dict(self) -> dict[str, Any]:
        """For documents."""
        return {
            'before': list(self.before),
            'after': list(self.after),
            'condition_1': self.velocity_unique,
            'condition_2': self.quasi_static,
            'range_before': list(self.range_before),
            'range_after': list(self.range_after),
            'overlap': self.overlap,
        }


def check_transition(world: World, before: Piece, after: Piece) -> TransitionReport | None:
    """The transition at the end of `before`, with the velocity finger of `after`; None unless both
    are quasi-static.
    """
    if {before.mode, after.mode} != {QUASI_STATIC}:
        return None
    side, q = after.velocity_finger, after.samples[0]
    unique = all(
        control_mode(world, p.pairs, q, side).conditioning > LEAST_CONDITIONING
        for p in (before, after)
    )
    before_ends = Piece(before.mode, before.pairs, before.samples[::-1], side)
    after_begins = Piece(after.mode, after.pairs, after.samples, side)
    return TransitionReport(
        tuple(map(pair_name, before.pairs)),
        tuple(map(pair_name, after.pairs)),
        unique,
        _first_range(world, before_ends),
        _first_range(world, after_begins),
    )


def check_dyn(
    world: World,
    q: np.ndarray,
    transition: TransitionReport,
    torque_finger: int,
    torque: float,
    direction: int,
) -> bool:
    """Check_Dyn: whether `torque` [N m] at q (5,), while the velocity finger sets out in
    `direction`, breaks every contact that the transition must break and none that it must keep.

    This is the instant only; what follows over time is decided by verification.
    """
    before, after = (
        tuple(map(pair_from_name, names)) for names in (transition.before, transition.after)
    )
    pairs = tuple(sorted({*before, *after}))
    inputs = Inputs(torque_finger, torque, direction * SETTING_OUT)
    problem = build_forward_dynamics(world, pairs, q, np.zeros(SIZE), inputs)
    solution = solve_forward_dynamics(problem)
    breaking = set(solution.breaking())
    return set(before) - set(after) <= breaking and not breaking & set(after)


def _first_range(world: World, piece: Piece) -> tuple[float, float]:
    """Torque range at the first sample of the piece, or, where that one is singular, at the nearest
    sample that has a range.
    """
    column, ranges = joint_index(piece.velocity_finger), []
    for i in range(min(NEAREST, len(piece.samples) - 1)):
        there = Piece(piece.mode, piece.pairs, piece.samples[i : i + 2], piece.velocity_finger)
        low, high = follow(world, there, there.samples[0, column : column + 1]).statics[0, :2]
        ranges.append((float(low), float(high)))
        if low <= high:
            return ranges[-1]
    return ranges[0]
