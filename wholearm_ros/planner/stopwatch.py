"""Time: milliseconds spent in each stage of a planning call, and when its budget is spent."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

PLAN, GENERATE, VERIFY = 'plan_ms', 'generate_ms', 'verify_ms'


class Stopwatch:
    """Begins when it is made. timings: milliseconds by stage; budget: [s]."""

    def __init__(self, budget: float):
        self.budget = budget
        self.timings = dict.fromkeys((PLAN, GENERATE, VERIFY), 0.0)
        self._began = time.monotonic()

    def late(self) -> bool:
        """Whether no further candidate is to be begun: what comes after a search needs a tenth of the budget."""
        return time.monotonic() - self._began > 0.9 * self.budget

    def over(self) -> bool:
        """Whether all of the budget is spent."""
        return time.monotonic() - self._began > self.budget

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Adds what is spent inside to a stage."""
        began = time.perf_counter()
        try:
            yield
        finally:
            self.timings[name] += 1e3 * (time.perf_counter() - began)
