"""The shape of a finger, in its frame: the origin is the joint's axis, x runs along the finger.

A shape is a `Rectangle` or `ConvexParts`; both have the same properties.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.union import below, union_moments, union_outline


@dataclass(frozen=True)
class Rectangle:
    """From the axis along x for `length` [m], `half_width` [m] to either side."""

    length: float
    half_width: float

    @property
    def outline(self) -> np.ndarray:
        """(4, 2) [m] its boundary, counter-clockwise."""
        length, half = self.length, self.half_width
        return np.array([[0.0, -half], [length, -half], [length, half], [0.0, half]])

    @property
    def parts(self) -> tuple[np.ndarray, ...]:
        """Convex polygons (n, 2) [m], counter-clockwise, of which it consists."""
        return (self.outline,)

    @property
    def centre(self) -> np.ndarray:
        """(2,) [m] of its area."""
        return np.array([self.length / 2, 0.0])

    def inertia(self, mass: float) -> float:
        """About the axis [kg m²], with a uniform mass [kg]."""
        about_centre = mass * (self.length**2 + (2 * self.half_width) ** 2) / 12.0
        return about_centre + mass * (self.length / 2) ** 2

    def mirrored(self) -> 'Rectangle':
        """The mirror image (y → -y)."""
        return self

    def scaled(self, factor: float) -> 'Rectangle':
        """So many times as large."""
        return Rectangle(factor * self.length, factor * self.half_width)

    def shortened(self, by: float) -> 'Rectangle':
        """With `by` [m] cut off its tip."""
        return Rectangle(self.length - by, self.half_width)


@dataclass(frozen=True, eq=False)
class ConvexParts:
    """Convex polygons that are fixed to one another and may overlap.

    parts: each (n, 2) [m], counter-clockwise.
    """

    parts: tuple[np.ndarray, ...]

    def __init__(self, parts: Sequence[np.ndarray]) -> None:
        object.__setattr__(self, 'parts', tuple(readonly(part, (-1, 2)) for part in parts))

    @property
    def length(self) -> float:
        """How far it reaches along x [m]."""
        return max(float(part[:, 0].max()) for part in self.parts)

    @cached_property
    def outline(self) -> np.ndarray:
        """(n, 2) [m] its outer boundary, counter-clockwise; not convex where parts meet."""
        return readonly(union_outline(self.parts), (-1, 2))

    @cached_property
    def _moments(self) -> np.ndarray:
        return readonly(union_moments(self.parts), (4,))

    @property
    def centre(self) -> np.ndarray:
        """(2,) [m] of its area."""
        centre: np.ndarray = self._moments[1:3] / self._moments[0]
        return centre

    def inertia(self, mass: float) -> float:
        """About the axis [kg m²], with a uniform mass [kg]."""
        return mass * float(self._moments[3] / self._moments[0])

    def mirrored(self) -> 'ConvexParts':
        """The mirror image (y → -y), counter-clockwise again."""
        return ConvexParts([(part * [1.0, -1.0])[::-1] for part in self.parts])

    def scaled(self, factor: float) -> 'ConvexParts':
        """So many times as large."""
        return ConvexParts([factor * part for part in self.parts])

    def shortened(self, by: float) -> 'ConvexParts':
        """With `by` [m] cut off its tip."""
        level, along = self.length - by, np.array([1.0, 0.0])
        cut = [below(part, along, level) for part in self.parts]
        return ConvexParts([part for part in cut if len(part) > 2])


FingerShape = Rectangle | ConvexParts
