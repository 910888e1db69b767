"""Drives that know nothing but a torque, behind the command watchdog: holding is done here."""

import numpy as np

from wholearm_ros.control.command_watchdog import CommandWatchdog
from wholearm_ros.control.holding import Holding
from wholearm_ros.control.setpoints import Joints, PdGains
from wholearm_ros.model.scenario import Scenario


class TorqueDrives:
    """Torques for both joints, whatever the watchdog decides.

    Where it says hold, the fingers are kept where they were at that moment (`Holding`).
    """

    def __init__(self, scenario: Scenario, gains: PdGains, guard: CommandWatchdog) -> None:
        fingers = (scenario.hand.left, scenario.hand.right)
        self.gains, self.guard = gains, guard
        self._limits = np.array([f.torque_limit for f in fingers])
        self._holding = Holding(scenario.finger_weights)

    def release(self) -> None:
        """The next hold is where the fingers then are, without a load."""
        self._holding.begin_at()

    def torques(self, now: int, joints: Joints | None) -> np.ndarray:
        """(2,) [N m] at `now` [ns]; zero where `joints` are not known."""
        asked = self.guard.decide(now)
        if joints is None or not joints.finite:
            self.release()
            return np.zeros(2)
        if asked is not None:
            if self.guard.driven:
                self._holding.bear(asked)
            else:
                self.release()
            return asked
        holding = self._holding.torques(self.gains, joints.angles, joints.velocities)
        torques: np.ndarray = np.clip(holding, -self._limits, self._limits)
        return torques
