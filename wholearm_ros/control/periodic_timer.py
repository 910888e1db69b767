"""The wall clock of a motor loop: absolute deadlines, so that the mean rate is the one asked
for.
"""

import time
from collections.abc import Callable

SHORTEST = 0.9  # of a period, while lateness is worked off
MOST_BEHIND = 100_000_000  # [ns]; what is beyond is worked off slowly
SLOWLY = 0.99  # of a period, while that is worked off


class PeriodicTimer:
    """`wait()` returns once a period. A loop that came late works it off by periods a tenth
    shorter: every one of them is still a step under control, while a burst of steps would be
    physics without any. Lateness beyond MOST_BEHIND is worked off by periods a hundredth shorter,
    so that stamps that count the ticks come back to the clock.

    period [ns]; now: a clock [ns]; sleep: waits for so many seconds. overruns: ticks that were due
    before the loop asked for them; worst_late, slipped, behind [ns]: the largest lateness, all that
    was beyond MOST_BEHIND, and what of it is still to be worked off.
    """

    def __init__(
        self,
        period: int,
        now: Callable[[], int] = time.monotonic_ns,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._period, self._now, self._sleep = period, now, sleep
        self._due = self._ticked = now()
        self.overruns = self.worst_late = self.slipped = self.behind = 0

    def wait(self) -> None:
        """Returns at the next tick; at once when it is due already."""
        caught_up = min(self.behind, self._period - round(SLOWLY * self._period))
        self._due, self.behind = self._due + self._period - caught_up, self.behind - caught_up
        at = max(self._due, self._ticked + round(SHORTEST * self._period))
        ahead = at - self._now()
        if ahead > 0:
            self._sleep(ahead * 1e-9)
        else:
            self.overruns += 1
        self._ticked = self._now()
        late = self._ticked - self._due
        self.worst_late = max(self.worst_late, late)
        if late > MOST_BEHIND:
            self._due += late
            self.slipped, self.behind = self.slipped + late, self.behind + late
