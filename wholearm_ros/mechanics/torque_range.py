"""Problem (6): the torques of the torque-controlled finger that keep every contact force
compressive.

With four contacts the forces are affine in τ_T, so the range is an interval, found by clipping
(exact). With five and more they are not determined by τ_T: a QP with the contact forces as further
unknowns, solved by OSQP. Both motors' limits bound it.
"""

from dataclasses import dataclass

import numpy as np
import osqp
import scipy.sparse as sp
from scipy.optimize import linprog

from wholearm_ros.errors import SolverError
from wholearm_ros.kernels import statics
from wholearm_ros.mechanics.quasistatic import QuasiStatics

ROBUST_FRICTION = 0.03  # coefficient for which a robust torque range must hold, too
RESIDUAL_TOLERANCE = 1e-7  # of the equilibrium, relative to the loads, that an answer must reach
TIGHT = {
    'eps_abs': 1e-10,
    'eps_rel': 1e-10,
    'max_iter': 100_000,
    'polishing': True,
    'verbose': False,
}


@dataclass(frozen=True, eq=False)
class TorqueRangeProblem:
    """The model at a configuration, which finger is torque-controlled, and the limits (2,) [N m]
    of both motors.
    """

    model: QuasiStatics
    torque_finger: int
    limits: np.ndarray


@dataclass(frozen=True, eq=False)
class TorqueRange:
    """τ_min, τ_max [N m] in joint coordinates, and contact forces (n,) [N] at either end; empty
    when low > high.
    """

    problem: TorqueRangeProblem
    low: float
    high: float
    forces_low: np.ndarray
    forces_high: np.ndarray

    @property
    def empty(self) -> bool:
        """Whether no torque holds the object."""
        return not self.low <= self.high

    @property
    def width(self) -> float:
        """[N m], negative when empty."""
        return self.high - self.low

    def equilibrium_error(self) -> float:
        """Largest violation, at both ends, of eqs. (4), (5) [N, N m] and of the motors' limits."""
        if self.empty:
            return 0.0
        model, finger = self.problem.model, self.problem.torque_finger
        worst = 0.0
        for tau, f in ((self.low, self.forces_low), (self.high, self.forces_high)):
            torques = model.joint_torques(f)
            worst = max(
                worst,
                np.abs(model.G_n @ f + model.g_O).max(),
                abs(torques[finger] - tau),
                -f.min(),
                (np.abs(torques) - self.problem.limits).max(),
            )
        return float(worst)


def build_torque_range(
    model: QuasiStatics, torque_finger: int, limits: np.ndarray
) -> TorqueRangeProblem:
    """The problem (6) for a configuration; limits: (2,) τ_limit of both motors [N m]."""
    return TorqueRangeProblem(model, torque_finger, np.asarray(limits, float))


def solve_torque_range(problem: TorqueRangeProblem) -> TorqueRange:
    """The range; closed form for four contacts, OSQP for more. Raises SolverError when neither
    OSQP nor HiGHS can certify.
    """
    if problem.model.G_n.shape[1] == 4:
        return _closed_form(problem)
    return _by_programming(problem)


def _closed_form(problem: TorqueRangeProblem) -> TorqueRange:
    m, finger = problem.model, problem.torque_finger
    forces = np.empty((4, 2))
    load = np.concatenate([-m.g_O, m.g_h])
    low, high, _ = statics.torque_interval(m.constraint(), load, problem.limits, finger, forces)
    return TorqueRange(
        problem, low, high, forces[:, 0] + forces[:, 1] * low, forces[:, 0] + forces[:, 1] * high
    )


def _by_programming(problem: TorqueRangeProblem) -> TorqueRange:
    """Ends of the range one by one: maximise ± τ_T over (f, τ_T)."""
    ends = []
    for sign in (1.0, -1.0):
        f = _end_by_osqp(problem, sign)
        if f is None:
            f = _end_by_linprog(problem, sign)
        if f is None:
            none = np.full(problem.model.G_n.shape[1], np.nan)
            return TorqueRange(problem, 1.0, -1.0, none, none)
        ends.append(f)
    torques = [float(problem.model.joint_torques(f)[problem.torque_finger]) for f in ends]
    answer = TorqueRange(problem, torques[0], torques[1], ends[0], ends[1])
    scale = 1.0 + max(np.abs(f).max() for f in ends)
    if answer.equilibrium_error() > RESIDUAL_TOLERANCE * scale:
        raise SolverError(
            f'torque range of {problem.model.G_n.shape[1]} contacts: residual '
            f'{answer.equilibrium_error():.1e}; allowed: {RESIDUAL_TOLERANCE * scale:.1e}'
        )
    return answer


def _end_by_osqp(problem: TorqueRangeProblem, sign: float) -> np.ndarray | None:
    """Forces at the least sign · τ_T, or None when OSQP does not certify them. A small ridge makes
    the QP strictly convex.
    """
    m, n = problem.model, problem.model.G_n.shape[1]
    rows = sp.csc_matrix(np.vstack([m.G_n, m.J_n.T, np.eye(n)]))
    low = np.concatenate([-m.g_O, -problem.limits - m.g_h, np.zeros(n)])
    high = np.concatenate([-m.g_O, problem.limits - m.g_h, np.full(n, np.inf)])
    solver = osqp.OSQP()
    solver.setup(
        sp.csc_matrix(1e-9 * np.eye(n)),
        sign * m.J_n[:, problem.torque_finger],
        rows,
        low,
        high,
        **TIGHT,
    )
    answer = solver.solve(raise_error=False)
    if answer.info.status not in ('solved', 'solved inaccurate'):
        return None
    f = np.maximum(answer.x, 0.0)
    residual = max(
        np.abs(m.G_n @ f + m.g_O).max(), (np.abs(m.joint_torques(f)) - problem.limits).max()
    )
    return f if residual <= RESIDUAL_TOLERANCE * (1.0 + np.abs(f).max()) else None


def _end_by_linprog(problem: TorqueRangeProblem, sign: float) -> np.ndarray | None:
    """The same as a linear programme by HiGHS; None when infeasible."""
    m = problem.model
    both = np.vstack([m.J_n.T, -m.J_n.T])
    bounds = np.concatenate([problem.limits - m.g_h, problem.limits + m.g_h])
    answer = linprog(
        sign * m.J_n[:, problem.torque_finger],
        A_ub=both,
        b_ub=bounds,
        A_eq=m.G_n,
        b_eq=-m.g_O,
        bounds=(0, None),
        method='highs',
    )
    return answer.x if answer.status == 0 else None
