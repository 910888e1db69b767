"""The hand by our own forward dynamics, LCP time stepping: planar, nothing but kernels."""

from typing import Optional

import numpy as np

from wholearm_ros.kernels import geometry, time_stepping
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.configuration import JOINTS, POSE, SIZE
from wholearm_ros.model.hand import SIDES
from wholearm_ros.model.perturbation import NOMINAL, Perturbation
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.simulation.actuation import Drives, Encoders
from wholearm_ros.simulation.contact_point import ContactPoint

PHYSICS_RATE = 1000.0  # [Hz] at least; that of the rollouts by which trajectories are verified
TOUCHING = 1e-5  # [m] a pair with a smaller gap is reported as a contact


class PlanarHand:
    """See HandBackend; `scenario` is the truth, with the perturbation applied.

    The forces of `contacts()` are not kept by the time stepping: they are NaN.
    """

    def __init__(
        self, scenario: Scenario, rate: float = 1000.0, perturbation: Optional[Perturbation] = None
    ) -> None:
        perturbation = perturbation or NOMINAL
        self.scenario = perturbation.applied(scenario)
        self.period = 1.0 / rate
        self._substeps = max(1, int(np.ceil(PHYSICS_RATE / rate - 1e-9)))
        self._dt = self.period / self._substeps
        self._world = build_world(self.scenario)
        self._friction = float(perturbation.friction)
        self._work = time_stepping.new_workspace(self._world, self._friction, self._dt)
        self._drives = Drives(self.scenario, perturbation, self._dt)
        self._encoders = Encoders(perturbation)
        self._q, self._v, self.time = np.zeros(SIZE), np.zeros(SIZE), 0.0
        self._reading = (np.zeros(2), np.zeros(2))
        self.largest_residual = 0.0  # [m/s] of the complementarity problem, since the reset

    def reset(self, configuration: np.ndarray) -> None:
        """At rest at `configuration` (5,) [m, m, rad, rad, rad]."""
        self._q, self._v, self.time = np.array(configuration, dtype=float), np.zeros(SIZE), 0.0
        self._work = time_stepping.new_workspace(self._world, self._friction, self._dt)
        self.largest_residual = 0.0
        self._drives.reset(self._q[JOINTS])
        self._encoders.reset()
        self._reading = self._encoders.read(self._q[JOINTS], self._v[JOINTS])

    def step(self, efforts: Optional[np.ndarray]) -> None:
        """One period under motor torques (2,) [N m]; None: the fingers are held."""
        for _ in range(self._substeps):
            q, v = self._q, self._v
            torques = self._drives.torques(efforts, q[JOINTS], v[JOINTS])
            _, residual = time_stepping.step(self._world, self._work, torques, q, v)
            self.largest_residual = max(self.largest_residual, residual)
        self.time += self.period
        self._reading = self._encoders.read(self._q[JOINTS], self._v[JOINTS])

    def joints(self) -> tuple[np.ndarray, np.ndarray]:
        """Measured angles (2,) [rad] and velocities (2,) [rad/s]."""
        return self._reading

    def efforts(self) -> np.ndarray:
        """(2,) [N m]: what the drives were last asked for."""
        return self._drives.asked

    def object_pose(self) -> np.ndarray:
        """(3,) [m, m, rad], the truth."""
        return self._q[POSE].copy()

    def object_velocity(self) -> np.ndarray:
        """(3,) [m/s, m/s, rad/s], the truth."""
        return self._v[POSE].copy()

    def contacts(self) -> list[ContactPoint]:
        """Pairs closer than TOUCHING; force is NaN."""
        w = self._world
        gaps, codes = self._work.gaps.copy(), self._work.codes.copy()
        geometry.gap_table(w, self._q, gaps, codes)
        found = []
        for code, gap in zip(codes[gaps < TOUCHING], gaps[gaps < TOUCHING]):
            px, py, nx, ny, *_ = geometry.contact(w, code, self._q)
            body = int(geometry.pair_body(code))
            found.append(
                ContactPoint(
                    'palm' if body == 0 else SIDES[body - 1],
                    np.array([px, py]),
                    np.array([nx, ny]),
                    float(gap),
                    float('nan'),
                )
            )
        return found

    def disconnect(self) -> None:
        """Does nothing: there is nothing to free."""
