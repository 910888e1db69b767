"""A contact of the object, as an engine reports it."""

from dataclasses import dataclass

import numpy as np

SAME_POINT = 1e-4  # [m] within which two points of one pair are one


@dataclass(frozen=True, eq=False)
class ContactPoint:
    """The object touching `other` ('left', 'right' or 'palm').

    point: (2,) [m]; normal: (2,) towards the object; gap [m], negative in penetration; force [N]
    along the normal.
    """

    other: str
    point: np.ndarray
    normal: np.ndarray
    gap: float
    force: float


def merged(points: list[ContactPoint]) -> list[ContactPoint]:
    """Points of one pair within SAME_POINT are one: the deepest gap, the forces added."""
    kept: list[ContactPoint] = []
    for p in points:
        for k, q in enumerate(kept):
            if q.other == p.other and np.linalg.norm(q.point - p.point) < SAME_POINT:
                gap, force = min(q.gap, p.gap), q.force + p.force
                kept[k] = ContactPoint(q.other, q.point, q.normal, gap, force)
                break
        else:
            kept.append(p)
    return kept
