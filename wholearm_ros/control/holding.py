"""Holding: what drives do without a command, in every simulated and every torque-driven hand."""

import numpy as np

from wholearm_ros.control.setpoints import PdGains
from wholearm_ros.kernels.control_law import holding_angle, holding_effort
from wholearm_ros.model.weight import bearing_torques


class Holding:
    """PD feedback keeps both fingers where they were when holding began, their weight compensated;
    it begins with the torques that were borne until then.

    weights: of the fingers, as `Scenario.finger_weights`.
    """

    def __init__(self, weights: np.ndarray) -> None:
        self._weights = weights
        self._held: np.ndarray | None = None
        self._borne: np.ndarray | None = None

    def begin_at(self, angles: np.ndarray | None = None) -> None:
        """From now on at angles (2,) [rad], without a load; None: where the fingers then are."""
        self._held = None if angles is None else np.array(angles, dtype=float)
        self._borne = None

    def bear(self, torques: np.ndarray) -> None:
        """Commands drive: torques (2,) [N m] are what the next hold begins with."""
        self._held, self._borne = None, torques.copy()

    def torques(self, gains: PdGains, angles: np.ndarray, velocities: np.ndarray) -> np.ndarray:
        """(2,) [N m] at angles (2,) [rad] and velocities (2,) [rad/s]."""
        weight = bearing_torques(self._weights, angles)
        if self._held is None:
            borne = weight if self._borne is None else self._borne
            self._held = holding_angle(gains, weight, borne, angles)
        torques: np.ndarray = holding_effort(gains, weight, self._held, angles, velocities)
        return torques
