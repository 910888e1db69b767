"""The few compiled loops. Plain functions of arrays; each has a slow, obvious twin in
`test/kernels`.

Numba is imported when the first kernel is made, so that `kernels/control_law.py` costs a controller
node no compiler.
"""

from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from types import FunctionType

PACKAGE = Path(__file__).parents[1]
SOURCES = (
    'kernels',
    'model/configuration.py',
    'model/frame.py',
    'model/hand.py',
    'model/interpolation.py',
    'model/separation.py',
    'model/weight.py',
)  # compiled, or read by what is


def kernel(function):
    """Compile once, keep on disk: a second process starts without compiling. It runs beside other
    threads.

    It works on arrays that it is given and makes none, so nothing counts references to them: half
    of the time of a simulated step went into that. What makes arrays is an `allocating` kernel.
    """
    return _compiled(function, _nrt=False)


def allocating(function):
    """A kernel that makes arrays, for itself or to return them."""
    return _compiled(function, _nrt=True)


@cache
def inlined(function, **scalar):
    """A kernel that becomes part of those that call it: a small one, or one that takes a whole
    world in an inner loop.

    The plain functions that it calls are compiled with it. scalar: what it calls instead of a
    function of arrays, by name; `min` takes two thirds of the time of `np.minimum`.
    """
    plain = scalar | {
        name: inlined(called, **scalar)
        for name in function.__code__.co_names
        if isinstance(called := function.__globals__.get(name), FunctionType)
    }
    if plain:
        function = _with_globals(function, {**function.__globals__, **plain})
    return _compiled(function, _nrt=False, forceinline=True)


def _with_globals(function, names):
    twin = FunctionType(function.__code__, names, function.__name__, function.__defaults__)
    twin.__qualname__, twin.__module__ = function.__qualname__, function.__module__
    return twin


def _compiled(function, **options):
    from numba import njit

    forget_stale_code()
    options |= {'cache': True, 'error_model': 'numpy', 'fastmath': False, 'nogil': True}
    return njit(**options)(function)


@cache
def forget_stale_code() -> bool:
    """Delete what was compiled of other sources; whether there was any. Once a process.

    Numba looks at a kernel's own file only: a kernel that calls one of another file would go on
    with the old one.
    """
    files = [
        f
        for s in SOURCES
        for f in ([PACKAGE / s] if s.endswith('.py') else sorted((PACKAGE / s).glob('*.py')))
    ]
    now = sha256(b''.join(f.read_bytes() for f in files)).hexdigest()
    stamp = PACKAGE / 'kernels' / '__pycache__' / 'sources.sha256'
    with suppress(
        OSError
    ):  # a directory that cannot be written: numba keeps its cache elsewhere, or none
        if stamp.exists() and stamp.read_text() == now:
            return False
        for room in ('kernels', 'model'):
            for compiled in (PACKAGE / room / '__pycache__').glob('*.nb[ic]'):
                compiled.unlink(missing_ok=True)
        stamp.parent.mkdir(exist_ok=True)
        stamp.write_text(now)
    return True
