"""The few compiled loops. Plain functions of arrays; each has a slow, obvious twin in `test/kernels`."""

from numba import njit


def kernel(function):
    """Compile once, keep on disk: a second process starts without compiling. It runs beside other threads."""
    return njit(cache=True, error_model='numpy', fastmath=False, nogil=True)(function)
