"""The physics of a simulated hand: what exists, what is installed, which one is the default."""

from importlib.util import find_spec

from wholearm_ros.model.choices import Backend, values

BACKENDS = values(Backend)  # planar is our own and always there
JURY = 'jury'  # in place of a backend: every one that is installed, on the same run
JUDGES = (*BACKENDS, JURY)  # what a run without ROS may be judged by


def installed_backends() -> tuple[str, ...]:
    """Those of BACKENDS that this Python can import, in that order; nothing is imported."""
    return tuple(name for name in BACKENDS if name == Backend.planar.value or _is_installed(name))


def _is_installed(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except ImportError:  # a custom finder refuses this module
        return False


DEFAULT_BACKEND = installed_backends()[0]
