"""Versions of what a result depends on."""

import platform
from importlib.metadata import PackageNotFoundError, version
from typing import Any

PACKAGES = ('wholearm_ros', 'numpy', 'scipy', 'numba', 'osqp', 'pybullet', 'mujoco-core')


def versions() -> dict[str, Any]:
    """package → version, of those installed; and Python's own."""
    found = {}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return {**found, 'Python': platform.python_version()}
