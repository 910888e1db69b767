"""Simulations on all processors: compiled kernels run beside one another in threads."""

import os
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Callable, Iterable, Iterator

PROCESSORS = os.cpu_count() or 1


def parallel_map(work: Callable, items: Iterable) -> Iterator:
    """work(item) for every item, in their order, as many at once as there are processors.

    No more is begun than the results that were asked for and those computed with them, so that one can stop early.
    """
    items = list(items)
    for k in range(0, len(items), PROCESSORS):
        yield from _threads().map(work, items[k : k + PROCESSORS])


@cache
def _threads():
    return ThreadPoolExecutor(PROCESSORS, 'simulation')
