"""Torque paths at rest: whether five contacts and more carry every torque between two, by a QP with
the constraints of problem (6).

The forces of five contacts are not determined by the torques, so forces that balance them are found
for either end of the path. Equilibria are convex in the forces: between the ends the same mixture
of both balances the same mixture of the torques, and every torque of the path is certified.
"""

from dataclasses import dataclass

import numpy as np
import osqp
import scipy.sparse as sp

from wholearm_ros.mechanics.quasistatic import QuasiStatics

RESIDUAL_TOLERANCE = 1e-6  # [N, N m] of the equilibrium, relative to 1 + the largest force
PRECISE = {'eps_abs': 1e-9, 'eps_rel': 1e-9, 'max_iter': 20_000, 'polishing': True}


@dataclass(frozen=True, eq=False)
class TorquePathProblem:
    """The model at a configuration, which finger is torque-controlled, its torque at both ends of
    the path (2,) [N m], and the limits (2,) of both motors [N m].
    """

    model: QuasiStatics
    torque_finger: int
    torques: np.ndarray
    limits: np.ndarray


@dataclass(frozen=True, eq=False)
class TorquePath:
    """forces: (2, n) of the contacts at both ends [N], NaN where none were found."""

    problem: TorquePathProblem
    forces: np.ndarray

    def residual(self) -> float:
        """Largest violation, over both ends, of eqs. (4), (5) [N, N m] and of the motors' limits,
        relative to 1 + the largest force; infinite where no forces were found.
        """
        if np.isnan(self.forces).any():
            return np.inf
        model, finger, worst = self.problem.model, self.problem.torque_finger, 0.0
        for tau, f in zip(self.problem.torques, self.forces):
            torques = model.joint_torques(f)
            violation = max(
                np.abs(model.G_n @ f + model.g_O).max(),
                abs(torques[finger] - tau),
                -f.min(),
                (np.abs(torques) - self.problem.limits).max(),
            )
            worst = max(worst, violation / (1.0 + np.abs(f).max()))
        return float(worst)

    @property
    def certified(self) -> bool:
        """Whether the contacts carry every torque of the path."""
        return self.residual() <= RESIDUAL_TOLERANCE


def build_torque_path(
    model: QuasiStatics, torque_finger: int, torques: np.ndarray, limits: np.ndarray
) -> TorquePathProblem:
    """The problem for a configuration; torques: (2,) at both ends, limits: (2,) τ_limit [N m]."""
    return TorquePathProblem(
        model, torque_finger, np.asarray(torques, float), np.asarray(limits, float)
    )


def solve_torque_path(problem: TorquePathProblem) -> TorquePath:
    """The least forces at both ends that satisfy the constraints of problem (6), by OSQP."""
    m, n = problem.model, problem.model.G_n.shape[1]
    rows = sp.csc_matrix(np.vstack([m.G_n, m.J_n.T, np.eye(n)]))
    solver, forces = osqp.OSQP(), np.full((2, n), np.nan)
    for k, tau in enumerate(problem.torques):
        low, high = -problem.limits - m.g_h, problem.limits - m.g_h
        low[problem.torque_finger] = high[problem.torque_finger] = (
            tau - m.g_h[problem.torque_finger]
        )
        lower = np.concatenate([-m.g_O, low, np.zeros(n)])
        upper = np.concatenate([-m.g_O, high, np.full(n, np.inf)])
        if k == 0:
            solver.setup(
                sp.eye(n, format='csc'), np.zeros(n), rows, lower, upper, verbose=False, **PRECISE
            )
        else:
            solver.update(l=lower, u=upper)
        answer = solver.solve(raise_error=False)
        if answer.info.status in ('solved', 'solved inaccurate'):
            forces[k] = np.maximum(answer.x, 0.0)
    return TorquePath(problem, forces)
