"""What a simulated hand must provide."""

from typing import Optional, Protocol

import numpy as np

from wholearm_ros.model.scenario import Scenario
from wholearm_ros.simulation.contact_point import ContactPoint


class HandBackend(Protocol):
    """A hand with an object between its fingers, advanced step by step.

    scenario: the truth, perturbations applied; period [s]: of one `step`; time [s]: since `reset`.
    """

    scenario: Scenario
    period: float
    time: float

    def reset(self, configuration: np.ndarray) -> None:
        """At rest at `configuration` (5,), with the drives holding the fingers.

        configuration: centroid x, y [m], rotation [rad], left and right joint angle [rad].
        """

    def step(self, efforts: Optional[np.ndarray]) -> None:
        """One period under motor torques (2,) [N m]; None: the fingers are held where they are.

        Raises HardwareError when the torques are not two finite numbers.
        """

    def joints(self) -> tuple[np.ndarray, np.ndarray]:
        """Measured angles (2,) [rad] and velocities (2,) [rad/s]."""

    def efforts(self) -> np.ndarray:
        """(2,) [N m]: what the drives were last asked for."""

    def object_pose(self) -> np.ndarray:
        """(3,) the truth: centroid x, y [m], rotation [rad], not wrapped. For evaluation only."""

    def object_velocity(self) -> np.ndarray:
        """(3,) [m/s, m/s, rad/s], the truth."""

    def contacts(self) -> list[ContactPoint]:
        """The object's contacts after the last step."""

    def disconnect(self) -> None:
        """Frees the engine; may be called twice."""
