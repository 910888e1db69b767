"""Times as rows of a result: a name, a unit, median, 95th percentile, how many, and the ratio to a plain version."""

import time
from collections.abc import Callable

import numpy as np


def row(seconds, scale: float = 1e3, unit: str = 'ms', plain=None) -> dict:
    """Of times [s], shown in `unit` = 1 s / scale; plain: times [s] of the plain version of the same work."""
    values = scale * np.asarray(seconds, dtype=float)
    told = {
        'unit': unit,
        'median': float(np.median(values)),
        'p95': float(np.percentile(values, 95)),
        'n': len(values),
    }
    if plain is not None:
        told |= {
            'plain': scale * float(np.median(plain)),
            'ratio': float(np.median(plain) / np.median(seconds)),
        }
    return told


def value(number: float, unit: str) -> dict:
    """One number."""
    return {'unit': unit, 'median': float(number), 'p95': float(number), 'n': 1}


def seconds(work: Callable, repeats: int) -> list:
    """[s] of each of `repeats` calls."""
    return [timed(work)[1] for _ in range(repeats)]


def timed(work: Callable) -> tuple:
    """(what `work()` returns, seconds)."""
    began = time.perf_counter()
    result = work()
    return result, time.perf_counter() - began
