"""The motors and encoders of every simulated hand: limits, delay, gain error, noise."""

from collections import deque
from typing import Optional

import numpy as np

from wholearm_ros.control.holding import Holding
from wholearm_ros.errors import HardwareError
from wholearm_ros.kernels.control_law import HOLD_GAINS
from wholearm_ros.model.perturbation import Perturbation
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.weight import bearing_torques


class Drives:
    """Two motor drives. Commands act `actuation_delay` later, rounded to whole physics steps.

    Before the first command, and whenever the command is None, the drives hold the fingers where
    they then are, their own weight compensated; what the last command made them bear, they go on
    bearing.
    """

    def __init__(self, scenario: Scenario, perturbation: Perturbation, dt: float) -> None:
        fingers = (scenario.hand.left, scenario.hand.right)
        self._limits = np.array([f.torque_limit for f in fingers])
        self._weights = scenario.finger_weights
        self._holding = Holding(self._weights)
        self._factors = perturbation.torque_factors
        self._delay = int(round(perturbation.actuation_delay / dt))
        self.reset(np.zeros(2))

    def reset(self, angles: np.ndarray) -> None:
        """angles: (2,) [rad] to hold."""
        self._holding.begin_at(angles)
        self._waiting: deque[Optional[np.ndarray]] = deque([None] * self._delay)
        self.asked: np.ndarray = bearing_torques(self._weights, angles)  # (2,) [N m]

    def torques(
        self, command: Optional[np.ndarray], angles: np.ndarray, velocities: np.ndarray
    ) -> np.ndarray:
        """(2,) [N m] at the joints now, for the command given now and the fingers' true state.

        command: (2,) [N m] or None; angles, velocities: (2,) [rad], [rad/s]. Raises HardwareError
        when the command is not two finite numbers.
        """
        if command is not None:
            command = np.array(command, dtype=float)  # the caller's may change while it waits
            if command.shape != (2,) or not np.isfinite(command).all():
                raise HardwareError(f'efforts: got {command.tolist()}; allowed: two finite numbers')
        self._waiting.append(command)
        acting = self._waiting.popleft()
        if acting is not None:
            self._holding.bear(acting)
        else:
            acting = self._holding.torques(HOLD_GAINS, angles, velocities)
        self.asked = np.clip(acting if command is None else command, -self._limits, self._limits)
        torques: np.ndarray = np.clip(acting, -self._limits, self._limits) * self._factors
        return torques


class Encoders:
    """Readings of the joints: the truth, errors of the zeros, and white noise drawn once a step.

    The noise is drawn from the perturbation's own seed, so a run can be repeated.
    """

    def __init__(self, perturbation: Perturbation) -> None:
        self._angle_noise = perturbation.encoder_noise
        self._velocity_noise = perturbation.velocity_noise
        self._seed, self._zeros = perturbation.noise_seed, perturbation.hand.encoder_zeros
        self.reset()

    def reset(self) -> None:
        """The same noise again, from its beginning."""
        self._rng = np.random.default_rng(self._seed)

    def read(self, angles: np.ndarray, velocities: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(2,) [rad], (2,) [rad/s]: what the encoders say of these true values."""
        if self._angle_noise == 0.0 and self._velocity_noise == 0.0:
            return angles + self._zeros, velocities.copy()
        noise = self._rng.standard_normal((2, 2))
        return (
            angles + self._zeros + self._angle_noise * noise[0],
            velocities + self._velocity_noise * noise[1],
        )
