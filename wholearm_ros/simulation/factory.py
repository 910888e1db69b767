"""Simulated hands by name."""

from typing import Optional

from wholearm_ros.errors import HardwareError
from wholearm_ros.model.backends import BACKENDS
from wholearm_ros.model.choices import Backend
from wholearm_ros.model.perturbation import Perturbation
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.simulation.hand import HandBackend


def make_hand(
    backend: str,
    scenario: Scenario,
    rate: float = 1000.0,
    perturbation: Optional[Perturbation] = None,
    view: bool = False,
) -> HandBackend:
    """A simulated hand by name: 'pybullet', 'mujoco', or 'planar' (our own forward dynamics).

    scenario: as planned; perturbation: what is truly different; rate [Hz]: of `step`;
    view: PyBullet's window. The engines are imported here, so that one that is not installed is
    only missed when it is asked for. Raises HardwareError when it is, or has another name.
    """
    if backend not in BACKENDS:
        raise HardwareError(f'backend: got {backend!r}; allowed: {", ".join(BACKENDS)}')
    if backend == Backend.planar.value:
        from wholearm_ros.simulation.planar_hand import PlanarHand

        return PlanarHand(scenario, rate=rate, perturbation=perturbation)
    try:
        if backend == Backend.mujoco.value:
            from wholearm_ros.simulation.mujoco_hand import MuJoCoHand

            return MuJoCoHand(scenario, rate=rate, perturbation=perturbation)
        from wholearm_ros.simulation.pybullet_hand import PyBulletHand
    except ImportError as error:
        raise HardwareError(
            f'backend {backend}: {error}; '
            f'allowed: pip install "wholearm_ros[{backend}]", or another backend'
        ) from error
    return PyBulletHand(scenario, rate=rate, perturbation=perturbation, view=view)
