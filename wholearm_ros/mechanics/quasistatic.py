"""The quasi-static model, equations (1)–(5), and the three conditions for a quasi-static
manipulation (II-B, II-C).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wholearm_ros.kernels import statics
from wholearm_ros.mechanics.contacts import contact_rows
from wholearm_ros.mechanics.world import World
from wholearm_ros.model.configuration import JOINTS, POSE, SIZE, joint_index

LEAST_CONDITIONING = 1e-6  # singular values below this part of the largest count as zero


@dataclass(frozen=True, eq=False)
class QuasiStatics:
    """Kinematics and statics of n closed contacts at one configuration.

    G_n: (3, n) normal contact wrench matrix; J_n: (n, 2) normal Jacobian; g_O: (3,) gravity on the
    object [N, N, N m]; g_h: (2,) joint torques that hold the fingers against gravity [N m]; scale:
    (5,) of the coordinates.
    """

    G_n: np.ndarray
    J_n: np.ndarray
    g_O: np.ndarray
    g_h: np.ndarray
    scale: np.ndarray

    def constraint(self) -> np.ndarray:
        """(n, 5) = [G_nᵀ, −J_n] of eq. (1)."""
        return np.hstack([self.G_n.T, -self.J_n])

    def square_block(self, torque_finger: int) -> np.ndarray:
        """(n, 4) = [G_nᵀ, −J_nT] of eq. (3)."""
        return np.hstack([self.G_n.T, -self.J_n[:, [torque_finger]]])

    def velocities(self, velocity_finger: int, rate: float) -> np.ndarray:
        """(5,) q̇ when the velocity finger turns at `rate` [rad/s], eq. (3); needs n = 4 and
        condition 1.

        Raises numpy.linalg.LinAlgError when the block is singular.
        """
        torque_finger = 1 - velocity_finger
        solved = np.linalg.solve(
            self.square_block(torque_finger), self.J_n[:, velocity_finger] * rate
        )
        q_dot = np.empty(SIZE)
        q_dot[POSE], q_dot[joint_index(torque_finger)] = solved[:3], solved[3]
        q_dot[joint_index(velocity_finger)] = rate
        return q_dot

    def joint_torques(self, f_n: np.ndarray) -> np.ndarray:
        """(2,) τ = J_nᵀ f_n + g_h, the lower half of eq. (2)."""
        return np.asarray(self.J_n.T @ f_n + self.g_h)

    def residual(self, f_n: np.ndarray, tau: np.ndarray) -> float:
        """Largest absolute residual of eq. (2) for forces (n,) [N] and torques (2,) [N m]."""
        return float(
            max(
                np.abs(self.G_n @ f_n + self.g_O).max(), np.abs(self.joint_torques(f_n) - tau).max()
            )
        )

    def velocity_is_unique(self, velocity_finger: int) -> bool:
        """Conditions 1 and 2 of II-C: [G_nᵀ, −J_nT] nonsingular, J_nV of full rank."""
        scale = np.delete(self.scale, joint_index(velocity_finger))
        block = self.square_block(1 - velocity_finger) * scale
        values = np.linalg.svd(block, compute_uv=False)
        driven = np.abs(self.J_n[:, velocity_finger]).max() > 0.0
        return bool(driven and len(values) == 4 and values[-1] > LEAST_CONDITIONING * values[0])


def build_quasistatics(world: World, pairs: Sequence[int], q: np.ndarray) -> QuasiStatics:
    """The model for closed pairs at q (5,)."""
    rows, _ = contact_rows(world, pairs, q)
    load = np.empty(SIZE)
    statics.load_at(world.load, world.finger_weights, q, load)
    G_n, J_n = rows[:, POSE].T.copy(), -rows[:, JOINTS]
    return QuasiStatics(G_n, J_n, -load[POSE], load[JOINTS], world.scale)
