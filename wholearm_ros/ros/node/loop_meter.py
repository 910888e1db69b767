"""How long the loop takes: from the sending of a joint state to the commands that answer it."""

import time
from collections import OrderedDict, deque

import numpy as np

KEPT = 64  # states that may wait for their answer
WINDOW = 2000  # the figures are those of the last so many


class LoopMeter:
    """Notified when the joint state of a stamp [ns] is sent, answered by commands, and acted on."""

    def __init__(self) -> None:
        self._sent: OrderedDict[int, int] = OrderedDict()
        self._acted_on = -1
        self._answers: deque[int] = deque(maxlen=WINDOW)  # [ns]
        self._actions: deque[int] = deque(maxlen=WINDOW)  # [ns]

    def sent(self, stamp: int) -> None:
        """The joint state of `stamp` goes out now."""
        self._sent[stamp] = time.monotonic_ns()
        if len(self._sent) > KEPT:
            self._sent.popitem(last=False)

    def answered(self, stamp: int) -> None:
        """A command for `stamp` has come."""
        self._note(stamp, self._answers)

    def acts(self, stamp: int) -> None:
        """The period that begins now is under the commands for `stamp`; the first one counts."""
        if stamp != self._acted_on:
            self._acted_on = stamp
            self._note(stamp, self._actions)

    def _note(self, stamp: int, times: deque[int]) -> None:
        if stamp in self._sent:
            times.append(time.monotonic_ns() - self._sent[stamp])

    def figures(self) -> dict[str, float]:
        """p50 and p99 in ms, of those there are."""
        found = {}
        for name, times in (('command latency', self._answers), ('command applied', self._actions)):
            if times:
                p50, p99 = np.percentile(list(times), (50, 99)) / 1e6
                found.update({f'{name} p50 ms': p50, f'{name} p99 ms': p99})
        return found
