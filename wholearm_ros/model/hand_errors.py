"""How the true hand differs from the one in the scenario: friction in its joints, encoder zeros,
axes, the direction of gravity, and where the object is set down.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.hand import Finger, Hand
from wholearm_ros.model.scenario import Scenario, StartAtPose

# At level 1; each is multiplied by the level.
MAX_JOINT_FRICTION = 0.02  # [N m] Coulomb friction of each joint
ENCODER_ZERO = 0.002  # [rad] each encoder's zero is off by up to this
AXIS_OFFSET = 0.0003  # [m] each coordinate of each axis is off by up to this
GRAVITY_TURN = float(np.radians(0.5))  # [rad] the direction of gravity, in the plane
START_X = 0.001  # [m] where the object is set down


@dataclass(frozen=True, eq=False)
class HandErrors:
    """joint_friction: (2,) [N m], left then right; encoder_zeros: (2,) [rad], read where the finger
    is at 0; axis_offsets: (2, 2) [m]; gravity_turn [rad], counter-clockwise; start_x [m].
    """

    joint_friction: np.ndarray = field(default_factory=lambda: np.zeros(2))
    encoder_zeros: np.ndarray = field(default_factory=lambda: np.zeros(2))
    axis_offsets: np.ndarray = field(default_factory=lambda: np.zeros((2, 2)))
    gravity_turn: float = 0.0
    start_x: float = 0.0

    def __post_init__(self) -> None:
        shapes = {'joint_friction': (2,), 'encoder_zeros': (2,), 'axis_offsets': (2, 2)}
        for name, shape in shapes.items():
            object.__setattr__(self, name, readonly(getattr(self, name), shape))

    def applied(self, scenario: Scenario) -> Scenario:
        """The scenario with the true hand, gravity and start; of the encoders it says nothing."""
        hand = Hand(*(self._true_finger(scenario.hand[side], side) for side in range(2)))
        gravity = replace(scenario.gravity, turn=self.gravity_turn)
        start = scenario.start
        if isinstance(start, StartAtPose):
            start = replace(start, pose=start.pose + [self.start_x, 0.0, 0.0])
        else:
            start = replace(start, x=start.x + self.start_x)
        return replace(scenario, hand=hand, gravity=gravity, start=start)

    def _true_finger(self, told: Finger, side: int) -> Finger:
        axis = told.axis + self.axis_offsets[side]
        return replace(told, axis=axis, joint_friction=float(self.joint_friction[side]))

    def to_dict(self) -> dict[str, Any]:
        """For documents."""
        return {
            'joint_friction': self.joint_friction.tolist(),
            'encoder_zeros': self.encoder_zeros.tolist(),
            'axis_offsets': self.axis_offsets.tolist(),
            'gravity_turn': self.gravity_turn,
            'start_x': self.start_x,
        }


def draw_hand_errors(rng: np.random.Generator, level: float) -> HandErrors:
    """One draw at `level` (1 as in the constants above), reproducible from the state of `rng`."""
    return HandErrors(
        joint_friction=level * MAX_JOINT_FRICTION * rng.uniform(size=2),
        encoder_zeros=level * ENCODER_ZERO * rng.uniform(-1.0, 1.0, size=2),
        axis_offsets=level * AXIS_OFFSET * rng.uniform(-1.0, 1.0, size=(2, 2)),
        gravity_turn=level * GRAVITY_TURN * rng.uniform(-1.0, 1.0),
        start_x=level * START_X * rng.uniform(-1.0, 1.0),
    )
