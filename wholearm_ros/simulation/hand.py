"""What a stand-in of the hand must offer, and how one is made by name."""

from dataclasses import dataclass
from typing import List, Optional, Protocol, Tuple

import numpy as np

from wholearm_ros.errors import HardwareError
from wholearm_ros.model.backends import BACKENDS
from wholearm_ros.model.perturbation import Perturbation
from wholearm_ros.model.scenario import Scenario


@dataclass(frozen=True, eq=False)
class ContactPoint:
    """The object touching `other` ('left', 'right' or 'palm'). point: (2,) [m]; normal: (2,) towards the object;
    gap [m], negative in penetration; force [N] along the normal."""

    other: str
    point: np.ndarray
    normal: np.ndarray
    gap: float
    force: float


class HandBackend(Protocol):
    """A hand with an object between its fingers, advanced step by step.

    scenario: the truth, perturbations applied; period [s]: of one `step`; time [s]: since the reset.
    """

    scenario: Scenario
    period: float
    time: float

    def reset(self, configuration: np.ndarray) -> None:
        """At rest at `configuration` (5,): centroid x, y [m], rotation [rad], left and right joint angle [rad]."""

    def step(self, efforts: Optional[np.ndarray]) -> None:
        """One period under motor torques (2,) [N m]; None: the drives hold the fingers where they were reset."""

    def joints(self) -> Tuple[np.ndarray, np.ndarray]:
        """Measured angles (2,) [rad] and velocities (2,) [rad/s]."""

    def efforts(self) -> np.ndarray:
        """(2,) [N m]: what the drives were last asked for."""

    def object_pose(self) -> np.ndarray:
        """(3,) the truth: centroid x, y [m], rotation [rad], not wrapped. For evaluation only."""

    def object_velocity(self) -> np.ndarray:
        """(3,) [m/s, m/s, rad/s], the truth."""

    def contacts(self) -> List[ContactPoint]:
        """The object's contacts after the last step."""

    def disconnect(self) -> None:
        """Frees the stand-in; may be called twice."""


def make_hand(
    backend: str,
    scenario: Scenario,
    rate: float = 1000.0,
    perturbation: Optional[Perturbation] = None,
    view: bool = False,
) -> HandBackend:
    """A stand-in by name: 'pybullet', 'mujoco', or 'planar' (our own forward dynamics, no dependency).

    scenario: as told to the planner; perturbation: what is truly different; rate [Hz]: of `step`; view: PyBullet's window.
    The back ends are imported here, so that one that is not installed is only missed when it is asked for.
    """
    if backend not in BACKENDS:
        raise HardwareError(f'backend: got {backend!r}; allowed: {", ".join(BACKENDS)}')
    if backend == 'planar':
        from wholearm_ros.simulation.planar_hand import PlanarHand

        return PlanarHand(scenario, rate=rate, perturbation=perturbation)
    try:
        if backend == 'mujoco':
            from wholearm_ros.simulation.mujoco_hand import MuJoCoHand

            return MuJoCoHand(scenario, rate=rate, perturbation=perturbation)
        from wholearm_ros.simulation.pybullet_hand import PyBulletHand
    except ImportError as error:
        raise HardwareError(
            f'backend {backend}: {error}; allowed: pip install "wholearm_ros[{backend}]", or another backend'
        ) from error
    return PyBulletHand(scenario, rate=rate, perturbation=perturbation, view=view)
