"""A motion primitive: one finger turns from rest to rest while the other holds a torque."""

from dataclasses import dataclass, replace
from typing import Any

from wholearm_ros.errors import DocumentError
from wholearm_ros.model.hand import SIDES


@dataclass(frozen=True)
class MotionPrimitive:
    """velocity_finger: LEFT or RIGHT; turn: its rotation [rad]; torque: of the other finger towards
    closing [N m], beyond what holds it against gravity; speed: peak of the turn [rad/s];
    settle: time after the turn to come to rest [s]; slew: rate limit of the torque [N m/s].
    """

    velocity_finger: int
    turn: float
    torque: float
    speed: float = 1.2
    settle: float = 0.16
    slew: float = 20.0

    def to_dict(self) -> dict[str, Any]:
        """For documents."""
        return {
            'velocity_finger': SIDES[self.velocity_finger],
            'turn': self.turn,
            'torque': self.torque,
            'speed': self.speed,
            'settle': self.settle,
            'slew': self.slew,
        }

    @classmethod
    def from_dict(cls, d: dict[str, Any]) -> 'MotionPrimitive':
        """Raises DocumentError when something is missing or of the wrong kind."""
        try:
            return cls(
                SIDES.index(d['velocity_finger']),
                float(d['turn']),
                float(d['torque']),
                float(d['speed']),
                float(d['settle']),
                float(d['slew']),
            )
        except (KeyError, ValueError, TypeError, AttributeError) as error:
            raise DocumentError(
                f'plan document: action {d!r} of a dynamic leg is damaged: {error}'
            ) from error

    def mirrored(self) -> 'MotionPrimitive':
        """The mirror image (x → -x)."""
        return replace(self, velocity_finger=1 - self.velocity_finger, turn=-self.turn)
