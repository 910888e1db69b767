"""Drives that know nothing but a torque, behind the command watchdog: holding is done here."""

import numpy as np

from wholearm_ros.control.command_watchdog import CommandWatchdog
from wholearm_ros.control.setpoints import Joints, PdGains
from wholearm_ros.kernels.control_law import holding_angle, holding_effort
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.weight import bearing_torques


class TorqueDrives:
    """Torques for both joints, whatever the watchdog decides.

    Where it says hold, PD feedback keeps the fingers where they were at that moment, their weight
    compensated. It begins with the torques of the last command, if there was one.
    """

    def __init__(self, scenario: Scenario, gains: PdGains, guard: CommandWatchdog) -> None:
        fingers = (scenario.hand.left, scenario.hand.right)
        self.gains, self.guard = gains, guard
        self._limits = np.array([f.torque_limit for f in fingers])
        self._weights = scenario.finger_weights
        self.release()

    def release(self) -> None:
        """The next hold is where the fingers then are, without a load."""
        self._held: np.ndarray | None = None
        self._borne: np.ndarray | None = None

    def torques(self, now: int, joints: Joints | None) -> np.ndarray:
        """(2,) [N m] at `now` [ns]; zero where `joints` are not known."""
        asked = self.guard.decide(now)
        if joints is None or not joints.finite:
            self.release()
            return np.zeros(2)
        if asked is not None:
            self._held, self._borne = None, asked.copy() if self.guard.driven else None
            return asked
        weight = bearing_torques(self._weights, joints.angles)
        if self._held is None:
            borne = weight if self._borne is None else self._borne
            self._held = holding_angle(self.gains, weight, borne, joints.angles)
        holding = holding_effort(self.gains, weight, self._held, joints.angles, joints.velocities)
        torques: np.ndarray = np.clip(holding, -self._limits, self._limits)
        return torques
