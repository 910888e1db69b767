"""The few compiled loops. Plain functions of arrays; each has a slow, obvious twin in `test/kernels`.

Numba is imported when the first kernel is made, so that `kernels/control_law.py` costs a controller node no compiler.
"""


def kernel(function):
    """Compile once, keep on disk: a second process starts without compiling. It runs beside other threads."""
    return _compiled(function)


def inlined(function):
    """A kernel that becomes part of those that call it: a small one, or one that takes a whole world in an inner loop."""
    return _compiled(function, forceinline=True)


def _compiled(function, **options):
    from numba import njit

    return njit(cache=True, error_model='numpy', fastmath=False, nogil=True, **options)(function)
