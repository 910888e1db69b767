"""How old a stamped message is when it is acted on, whatever the clock of its sender."""

from wholearm_ros.ros.interface.joint_state_serialization import NANOSECONDS

SLOWEST = 0.5  # of real time: a sender whose stamps advance at least so fast is slow, not late


class StampAge:
    """Age against the freshest message so far, whose lag is taken to grow all the time.

    Clocks of two machines differ, which shifts all stamps alike; and the stamps of a simulated hand
    on a machine that cannot keep up fall behind the clock little by little, though every state is
    new when it is sent. A message that comes later than both explain has waited on its way or in
    this process.
    """

    def __init__(self) -> None:
        self._usual, self._before = float('inf'), 0  # [ns] lag that is explained; when that was

    def __call__(self, stamp: int, now: int) -> float:
        """[s]; `stamp` [ns] of the sender's clock, `now` [ns] of ours."""
        lag = now - stamp
        self._usual = min(lag, self._usual + (1.0 - SLOWEST) * (now - self._before))
        self._before = now
        return (lag - self._usual) / NANOSECONDS
