"""What the drives do with the commands they get, and without: brake, driven, hold, limp,
stopped.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from wholearm_ros.model.hand import SIDES

BRAKE, DRIVEN, HOLD = 'brake', 'driven', 'hold'
ZERO_TORQUE, STOPPED = 'zero torque', 'stopped'
WAITING_FOR_RESET = {  # state → what is told of it
    ZERO_TORQUE: 'commands stopped: zero torque until hand_hardware/reset',
    STOPPED: 'stopped on request: the drives hold until hand_hardware/reset',
}
HOLDING = 'hold: no fresh commands, the drives hold the fingers where they are'


class CommandWatchdog:
    """Watches over both joints' commands. Times are stamps [ns] of the hardware's own clock.

    brake: no command yet, the drives hold the fingers; driven: both commands fresh; hold: a command
    is older than `timeout`, the drives hold the fingers where they are and take fresh commands
    again; limp: hold lasted `hold_time`, zero torque until the reset; stopped: on request, the
    drives hold the fingers and take no command until the reset.

    limits: (2,) largest torques [N m]; timeout [ns]; hold_time [ns]: None to hold as long as the
    drives run; tolerance [ns]: None where commands carry the stamps of the joint states they
    answer; else they count as stamped on arrival, and their own stamps, if not zero, must be within
    it of the clock. late, saturated, trips: commands dropped, commands cut to the limit, times on
    hold; taken: commands of each joint.
    """

    def __init__(
        self,
        limits: Sequence[float],
        timeout: int,
        hold_time: int | None = None,
        tolerance: int | None = None,
    ) -> None:
        self._limits, self._tolerance = limits, tolerance
        self._timeout, self._hold_time = timeout, hold_time
        self.late = self.saturated = self.trips = 0
        self.taken = [0, 0]
        self.reset(0)

    def reset(self, now: int) -> None:
        """Brakes; commands stamped before `now` are those of another run."""
        self.state = BRAKE
        self._since = now
        self.newest = [now - 1, now - 1]  # stamps of the newest commands
        self.efforts = np.zeros(2)  # [N m]

    def stop(self) -> None:
        """From the next period on, whatever was commanded."""
        self.state = STOPPED

    def command(self, joint: int, stamp: int, effort: float, now: int) -> bool:
        """Whether the command was taken: newer than the one before it and not from the future, or
        within the tolerance.

        stamp, now [ns]; effort [N m], cut to the joint's limit.
        """
        if self._tolerance is None:
            good = self.newest[joint] < stamp <= now
        else:
            good = stamp == 0 or abs(now - stamp) <= self._tolerance
        if not good or self.state in WAITING_FOR_RESET:
            self.late += 1
            return False
        limit = self._limits[joint]
        self.saturated += abs(effort) > limit
        self.newest[joint] = stamp if self._tolerance is None else now
        self.taken[joint] += 1
        self.efforts[joint] = min(max(effort, -limit), limit)
        return True

    def figures(self) -> dict[str, Any]:
        """For /diagnostics."""
        values: dict[str, Any] = {
            'state': self.state,
            'late commands': self.late,
            'commands at the limit': self.saturated,
            'watchdog trips': self.trips,
        }
        for side, taken, newest in zip(SIDES, self.taken, self.newest):
            values.update({f'{side} commands': taken, f'{side} newest': newest})
        return values

    @property
    def driven(self) -> bool:
        """Whether fresh commands drove in the last period."""
        return self.state == DRIVEN

    def both_at(self, stamp: int) -> bool:
        """Whether the newest command of either joint is the one of `stamp` [ns]."""
        return self.newest[0] == self.newest[1] == stamp

    def age(self, now: int) -> int:
        """Of the older one of both commands [ns]."""
        return now - min(self.newest)

    def decide(self, now: int) -> np.ndarray | None:
        """(2,) [N m] for the period that begins at `now` [ns]; None where the drives shall hold the
        fingers.
        """
        fresh = self.age(now) <= self._timeout and min(self.newest) >= self._since
        if self.state == STOPPED:
            return None
        if self.state == ZERO_TORQUE:
            return np.zeros(2)
        if fresh:
            self.state = DRIVEN
            return self.efforts
        if self.state == DRIVEN:
            self.state, self._tripped_at = HOLD, now
            self.trips += 1
        held = now - self._tripped_at if self.state == HOLD else 0
        if self._hold_time is not None and held > self._hold_time:
            self.state = ZERO_TORQUE
            return np.zeros(2)
        return None
