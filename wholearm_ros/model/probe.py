"""A probing motion: one finger is held while the other closes gently on what lies between them."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from wholearm_ros.errors import DocumentError
from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.hand import SIDES


@dataclass(frozen=True, eq=False)
class Probe:
    """held: LEFT or RIGHT, the finger that moves from place to place; the other one closes.

    places: (k,) angles of the held finger at which the pair of angles is read [rad], each further
    closed than the one before; opened: (2,) how far each finger opens first [rad]; torque: of the
    closing finger [N m], beyond its own weight; weights: (2, 2) [N m] of the fingers, see
    `weight.bearing_torques`; stops: (2,) angles beyond which no finger is sent [rad]; acceleration:
    of the held finger at most [rad/s²].
    """

    held: int
    places: np.ndarray
    opened: np.ndarray
    torque: float
    weights: np.ndarray
    stops: np.ndarray
    acceleration: float = 3.0

    def __post_init__(self) -> None:
        object.__setattr__(self, 'places', readonly(self.places, (-1,)))
        for name, shape in (('opened', (2,)), ('weights', (2, 2)), ('stops', (2,))):
            object.__setattr__(self, name, readonly(getattr(self, name), shape))

    @property
    def closing(self) -> int:
        """The finger that closes."""
        return 1 - self.held

    def to_dict(self) -> dict[str, Any]:
        """For documents."""
        return {
            'held': SIDES[self.held],
            'places': self.places.tolist(),
            'opened': self.opened.tolist(),
            'torque': self.torque,
            'weights': self.weights.tolist(),
            'stops': self.stops.tolist(),
            'acceleration': self.acceleration,
        }

    @classmethod
    def from_dict(cls, d: dict[str, Any]) -> 'Probe':
        """Raises DocumentError when something is missing or of the wrong kind."""
        try:
            weights = np.array(d['weights'], dtype=float)
            if weights.shape == (2,):  # older documents: their fingers are rectangles
                weights = np.column_stack([weights, np.zeros(2)])
            probe = cls(
                SIDES.index(d['held']),
                d['places'],
                d['opened'],
                float(d['torque']),
                weights,
                d['stops'],
                float(d.get('acceleration', 3.0)),
            )
        except (KeyError, ValueError, TypeError, AttributeError) as error:
            raise DocumentError(f'trajectory document: probe is damaged: {error}') from error
        driven = 0.0 < probe.torque < np.inf and 0.0 < probe.acceleration < np.inf
        if not len(probe.places) or not driven:
            raise DocumentError(
                'trajectory document: probe: needs a place, and a torque and an acceleration above '
                'zero'
            )
        return probe
