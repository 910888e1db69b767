"""Time spent in each stage of a planning call, and whether its budget is spent."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

PLAN, GENERATE, VERIFY = 'plan_ms', 'generate_ms', 'verify_ms'


class Stopwatch:
    """Runs from when it is made. budget: [s]; timings: milliseconds by stage."""

    def __init__(self, budget: float) -> None:
        self.budget = budget
        self.timings = dict.fromkeys((PLAN, GENERATE, VERIFY), 0.0)
        self._began = time.monotonic()

    def elapsed(self) -> float:
        """[s] since it was made."""
        return time.monotonic() - self._began

    def late(self) -> bool:
        """Whether no further candidate should be begun: what follows a search needs a tenth of the
        budget.
        """
        return self.elapsed() > 0.9 * self.budget

    def over(self) -> bool:
        """Whether all of the budget is spent."""
        return self.elapsed() > self.budget

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Adds the time spent inside to a stage."""
        began = time.perf_counter()
        try:
            yield
        finally:
            self.timings[name] += 1e3 * (time.perf_counter() - began)
