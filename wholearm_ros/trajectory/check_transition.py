"""Check_Transition: whether the contact state can change while the hand keeps moving quasi-statically (III-B.1)."""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.mechanics.contacts import pair_from_name, pair_name
from wholearm_ros.mechanics.forward_dynamics import build_forward_dynamics, solve_forward_dynamics
from wholearm_ros.mechanics.world import World
from wholearm_ros.model.trajectory import QUASI_STATIC
from wholearm_ros.trajectory.control_mode import control_mode
from wholearm_ros.trajectory.monotone_segments import Piece, follow

LEAST_OVERLAP = 0.05  # [N m] of the ranges before and after, for a transition in motion
LEAST_CONDITIONING = 1e-4
SETTING_OUT = (
    1.0  # [rad/s²] of the velocity finger, for which Check_Dyn solves the forward dynamics
)
NEAREST = 4  # samples on either side of a singular transition among which a range is looked for


@dataclass(frozen=True)
class TransitionReport:
    """Conditions 1) and 2) of III-B.1 between two contact states, and the torque ranges before and after [N m]."""

    before: tuple
    after: tuple
    velocity_unique: bool
    range_before: tuple
    range_after: tuple

    @property
    def overlap(self) -> float:
        """[N m], negative when the ranges are apart."""
        return min(self.range_before[1], self.range_after[1]) - max(
            self.range_before[0], self.range_after[0]
        )

    @property
    def quasi_static(self) -> bool:
        return self.velocity_unique and self.overlap >= LEAST_OVERLAP

    def to_dict(self) -> dict:
        return {
            'before': list(self.before),
            'after': list(self.after),
            'condition_1': self.velocity_unique,
            'condition_2': self.quasi_static,
            'range_before': list(self.range_before),
            'range_after': list(self.range_after),
            'overlap': self.overlap,
        }


def check_transition(world: World, before: Piece, after: Piece) -> TransitionReport:
    """Judge the transition at the end of `before`, with the velocity finger of `after`; None unless both are quasi-static."""
    if {before.mode, after.mode} != {QUASI_STATIC}:
        return None
    side, q = after.velocity_finger, after.samples[0]
    unique = all(
        control_mode(world, p.pairs, q, side).conditioning > LEAST_CONDITIONING
        for p in (before, after)
    )
    ranges = [
        _last_range(world, Piece(p.mode, p.pairs, samples, side))
        for p, samples in ((before, before.samples[::-1]), (after, after.samples))
    ]
    return TransitionReport(
        tuple(map(pair_name, before.pairs)), tuple(map(pair_name, after.pairs)), unique, *ranges
    )


def check_dyn(
    world: World,
    q: np.ndarray,
    transition: TransitionReport,
    torque_finger: int,
    torque: float,
    direction: int,
) -> bool:
    """Check_Dyn: whether `torque` [N m] at q (5,), the velocity finger setting out in `direction`, breaks every contact that
    the transition shall break and none of those that shall be there after it. (What comes of it over time is for
    verification to see.)"""
    before, after = (
        tuple(map(pair_from_name, names)) for names in (transition.before, transition.after)
    )
    pairs = tuple(sorted({*before, *after}))
    solution = solve_forward_dynamics(
        build_forward_dynamics(
            world, pairs, q, np.zeros(5), torque_finger, torque, direction * SETTING_OUT
        )
    )
    breaking = set(solution.breaking())
    return set(before) - set(after) <= breaking and not breaking & set(after)


def _last_range(world, piece):
    """The torque range at the first sample of the piece, or, where that is singular, at the nearest one that has a range."""
    for i in range(min(NEAREST, len(piece.samples) - 1)):
        there = Piece(piece.mode, piece.pairs, piece.samples[i : i + 2], piece.velocity_finger)
        low, high = follow(
            world, there, there.samples[0, 3 + piece.velocity_finger : 4 + piece.velocity_finger]
        ).statics[0, :2]
        if i == 0:
            first = (float(low), float(high))
        if low <= high:
            return float(low), float(high)
    return first
