"""A band of the finger angles: where they were in the rollouts that ended at the goal."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from wholearm_ros.errors import DocumentError
from wholearm_ros.model.arrays import readonly


@dataclass(frozen=True, eq=False)
class Band:
    """low, high (k, 2) [rad] of the measured angles, left then right.

    Every `period` [s] from a trajectory's time 0, linear in between; patience [s]: how long a
    finger may be outside before the run counts as deviated.
    """

    period: float
    low: np.ndarray
    high: np.ndarray
    patience: float

    def __post_init__(self) -> None:
        for name in ('low', 'high'):
            object.__setattr__(self, name, readonly(getattr(self, name), (-1, 2)))
        if not (len(self.low) == len(self.high) >= 2 and (self.low <= self.high).all()):
            raise ValueError('band: needs two rows or more of low <= high, as many of either')
        if not (0.0 < self.period < np.inf and 0.0 <= self.patience < np.inf):
            raise ValueError('band: needs a finite period > 0 and a finite patience >= 0')

    @property
    def duration(self) -> float:
        """[s] that it covers."""
        return self.period * (len(self.low) - 1)

    def to_dict(self) -> dict[str, Any]:
        """For documents."""
        return {
            'period': self.period,
            'low': self.low.tolist(),
            'high': self.high.tolist(),
            'patience': self.patience,
        }

    @classmethod
    def from_dict(cls, d: dict[str, Any]) -> 'Band':
        """Raises DocumentError when something is missing or of the wrong kind."""
        try:
            return cls(float(d['period']), d['low'], d['high'], float(d['patience']))
        except (KeyError, ValueError, TypeError, AttributeError) as error:
            raise DocumentError(f'band is damaged: {error}') from error
