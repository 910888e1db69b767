"""The physics behind a stand-in of the hand: what there is, what is installed, and what is taken when none is asked for."""

from importlib.util import find_spec

BACKENDS = (
    'pybullet',
    'mujoco',
    'planar',
)  # in order of preference; planar is our own and always there


def installed_backends() -> tuple:
    """Those of BACKENDS that this Python can import, in that order; nothing is imported."""
    return tuple(name for name in BACKENDS if name == 'planar' or find_spec(name) is not None)


DEFAULT_BACKEND = installed_backends()[0]
