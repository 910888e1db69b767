"""The physics behind a stand-in of the hand: what there is, what is installed, and what is taken when none is asked for."""

from importlib.util import find_spec

from wholearm_ros.model.choices import Backend

BACKENDS = tuple(backend.value for backend in Backend)  # planar is our own and always there
JURY = 'jury'  # in place of a backend: every one that is installed, on the same run


def installed_backends() -> tuple[str, ...]:
    """Those of BACKENDS that this Python can import, in that order; nothing is imported."""
    return tuple(name for name in BACKENDS if name == 'planar' or _is_installed(name))


def _is_installed(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except ImportError:  # something that finds modules refuses this one
        return False


DEFAULT_BACKEND = installed_backends()[0]
