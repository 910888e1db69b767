"""Simulations on all processors: compiled kernels run beside one another in threads."""

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

PROCESSORS = os.cpu_count() or 1
Item = TypeVar('Item')
Result = TypeVar('Result')


def parallel_map(work: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """work(item) for every item, in their order, as many at once as there are processors.

    No more is begun than the results that were asked for and those computed with them, so that one
    can stop early.
    """
    items = list(items)
    for k in range(0, len(items), PROCESSORS):
        yield from _threads().map(work, items[k : k + PROCESSORS])


@cache
def _threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(PROCESSORS, 'simulation')
