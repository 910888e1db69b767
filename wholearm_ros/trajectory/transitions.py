"""Check_Transition: whether the contact state can change while the hand keeps moving quasi-statically (III-B.1)."""
from dataclasses import dataclass

import numpy as np

from ..mechanics.contacts import pair_name
from ..mechanics.world import World
from ..model.trajectory import QUASI_STATIC
from .control_mode import control_mode
from .strokes import Piece, follow

LEAST_OVERLAP = 0.05     # [N m] of the ranges before and after, for a transition in motion
LEAST_CONDITIONING = 1e-4


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
        return min(self.range_before[1], self.range_after[1]) - max(self.range_before[0], self.range_after[0])

    @property
    def quasi_static(self) -> bool:
        return self.velocity_unique and self.overlap >= LEAST_OVERLAP

    def to_dict(self) -> dict:
        return {'before': list(self.before), 'after': list(self.after), 'condition_1': self.velocity_unique,
                'condition_2': self.quasi_static, 'range_before': list(self.range_before),
                'range_after': list(self.range_after), 'overlap': self.overlap}


def check_transition(world: World, before: Piece, after: Piece) -> TransitionReport:
    """Judge the transition at the end of `before`, with the velocity finger of `after`; None unless both are quasi-static."""
    if {before.mode, after.mode} != {QUASI_STATIC}:
        return None
    side, q = after.velocity_finger, after.samples[0]
    unique = all(control_mode(world, p.pairs, q, side).conditioning > LEAST_CONDITIONING for p in (before, after))
    ranges = [_range_at(world, Piece(p.mode, p.pairs, np.array([s, e]), side), s)
              for p, s, e in ((before, before.samples[-1], before.samples[-2]), (after, after.samples[0], after.samples[1]))]
    return TransitionReport(tuple(map(pair_name, before.pairs)), tuple(map(pair_name, after.pairs)), unique, *ranges)


def _range_at(world, piece, q):
    statics = follow(world, piece, q[3 + piece.velocity_finger:4 + piece.velocity_finger]).statics[0]
    return float(statics[0]), float(statics[1])
