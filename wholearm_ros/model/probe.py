"""A probing motion: where one finger is held while the other one closes gently on whatever lies between them."""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.errors import DocumentError
from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.hand import SIDES


@dataclass(frozen=True, eq=False)
class Probe:
    """held: LEFT or RIGHT, the finger that is led from place to place; the other one closes.

    places (k,) [rad]: angles of the held finger at which the pair of angles is read, each further closed than the one
    before; end [rad]: where the held finger stands in the end; opened (2,) [rad]: how far each finger opens first;
    torque [N m]: of the closing finger, beyond its own weight; weights (2,) [N m]: torque that bears each finger when it
    lies level; stops (2,) [rad]: the angles beyond which no finger is sent.
    """

    held: int
    places: np.ndarray
    opened: np.ndarray
    torque: float
    weights: np.ndarray
    stops: np.ndarray

    def __post_init__(self) -> None:
        object.__setattr__(self, 'places', readonly(self.places, (-1,)))
        for name in ('opened', 'weights', 'stops'):
            object.__setattr__(self, name, readonly(getattr(self, name), (2,)))

    @property
    def closing(self) -> int:
        """The finger that closes."""
        return 1 - self.held

    def to_dict(self) -> dict:
        """For documents."""
        return {
            'held': SIDES[self.held],
            'places': self.places.tolist(),
            'opened': self.opened.tolist(),
            'torque': self.torque,
            'weights': self.weights.tolist(),
            'stops': self.stops.tolist(),
        }

    @classmethod
    def from_dict(cls, d: dict) -> 'Probe':
        """Raises DocumentError when something is missing or of the wrong kind."""
        try:
            probe = cls(
                SIDES.index(d['held']),
                d['places'],
                d['opened'],
                float(d['torque']),
                d['weights'],
                d['stops'],
            )
        except (KeyError, ValueError, TypeError, AttributeError) as error:
            raise DocumentError(f'trajectory document: probe is damaged: {error}') from error
        if not len(probe.places) or not 0.0 < probe.torque < np.inf:
            raise DocumentError('trajectory document: probe: needs a place and a torque above zero')
        return probe
