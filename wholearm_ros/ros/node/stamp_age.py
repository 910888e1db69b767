"""How old a stamped message is when it is acted on, whatever the clock of its sender."""

from wholearm_ros.ros.interface.joint_state_serialization import NANOSECONDS

# [ns]; the freshest message of this window and the one before counts as new.
WINDOW = NANOSECONDS // 2


class StampAge:
    """Age against the freshest message of the last while.

    Clocks of two machines differ, and stamps of a hand in real time may fall behind the clock for
    good; both shift all stamps alike. What is late beside its neighbours waited on its way or in
    this process.
    """

    def __init__(self) -> None:
        self._began = self._before = self._least = 0  # [ns] window's begin, least lags
        self._empty = True

    def __call__(self, stamp: int, now: int) -> float:
        """[s]; `stamp` [ns] of the sender's clock, `now` [ns] of ours."""
        lag = now - stamp
        if self._empty:
            self._began, self._before, self._least, self._empty = now, lag, lag, False
        elif now - self._began > WINDOW:
            self._began, self._before, self._least = now, self._least, lag
        self._least = min(self._least, lag)
        return (lag - min(self._before, self._least)) / NANOSECONDS
