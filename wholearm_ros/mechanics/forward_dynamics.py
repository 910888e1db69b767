"""Forward dynamics as a linear complementarity problem: which contacts a torque breaks, and how
everything accelerates (III-B.2).

The motion equations of the object and of the torque-controlled finger and the acceleration
kinematics of the contacts, the velocity-controlled finger's motion being prescribed:
    M q̈_d = F + N_dᵀ f,    a_n = N_d q̈_d + N_V θ̈_V + Ṅ q̇,    0 ≤ f ⟂ a_n ≥ 0,
with q_d = (x, y, φ, θ_T) and N = [G_nᵀ, −J_n]. Motion over time is `kernels/time_stepping.py`, its
velocity-level relative.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wholearm_ros.errors import SolverError
from wholearm_ros.kernels import statics
from wholearm_ros.kernels.lcp import new_lcp, solve_lcp
from wholearm_ros.mechanics.contacts import contact_rows
from wholearm_ros.mechanics.world import World
from wholearm_ros.model.configuration import ROTATION, SIZE, X, Y, joint_index

RESIDUAL_TOLERANCE = 1e-9  # of the complementarity, relative to the largest bias
BREAKS = 1e-6  # [m/s²] a contact that separates faster than this breaks
RATE_STEP = 1e-7  # [s] over which Ṅ is differenced


@dataclass(frozen=True)
class Inputs:
    """What the fingers are given: torque [N m] of `torque_finger` (LEFT or RIGHT), acceleration
    θ̈_V [rad/s²] of the other one.
    """

    torque_finger: int
    torque: float
    acceleration: float = 0.0


@dataclass(frozen=True, eq=False)
class ForwardDynamics:
    """0 ≤ f ⟂ A f + b ≥ 0 for n closed pairs: A = N M⁻¹ Nᵀ (n, n) [1/kg], N (n, 4), b (n,) [m/s²];
    free: (4,) accelerations without contact; scale: (4,) M^−½; pairs: their codes.
    """

    N: np.ndarray
    b: np.ndarray
    free: np.ndarray
    scale: np.ndarray
    pairs: tuple[int, ...]

    @property
    def response(self) -> np.ndarray:
        """(4, n) = M⁻¹ Nᵀ, of the accelerations to the forces."""
        return np.asarray((self.N * self.scale**2).T)

    @property
    def A(self) -> np.ndarray:
        """(n, n) [1/kg], of the separations to the forces."""
        return np.asarray(self.N @ self.response)


@dataclass(frozen=True, eq=False)
class ForwardDynamicsSolution:
    """forces (n,) [N]; accelerations (4,) of x, y, φ, θ_T; separations (n,) [m/s²] of the
    contacts.
    """

    problem: ForwardDynamics
    forces: np.ndarray
    accelerations: np.ndarray
    separations: np.ndarray

    def residual(self) -> float:
        """max |min(f, a_n)|."""
        return float(np.abs(np.minimum(self.forces, self.separations)).max())

    def breaking(self) -> tuple[int, ...]:
        """Codes of the pairs that separate."""
        return tuple(c for c, a in zip(self.problem.pairs, self.separations) if a > BREAKS)


def build_forward_dynamics(
    world: World, pairs: Sequence[int], q: np.ndarray, q_dot: np.ndarray, inputs: Inputs
) -> ForwardDynamics:
    """The problem of these pairs (codes) at q, q_dot (5,)."""
    rows, _ = contact_rows(world, pairs, q)
    ahead, _ = contact_rows(world, pairs, q + RATE_STEP * q_dot)
    turned = joint_index(inputs.torque_finger)
    driven = joint_index(1 - inputs.torque_finger)
    moving = np.array([X, Y, ROTATION, turned])
    load = np.empty(SIZE)
    statics.load_at(world.load, world.finger_weights, q, load)
    force = -load
    force[turned] += inputs.torque
    free = (force / world.inertias)[moving]
    N = np.ascontiguousarray(rows[:, moving])
    scale = 1.0 / np.sqrt(world.inertias[moving])
    bias = rows[:, driven] * inputs.acceleration + (ahead - rows) @ q_dot / RATE_STEP
    return ForwardDynamics(N, N @ free + bias, free, scale, tuple(pairs))


def solve_forward_dynamics(problem: ForwardDynamics) -> ForwardDynamicsSolution:
    """Forces and accelerations. Raises SolverError when the complementarity is not met to
    RESIDUAL_TOLERANCE.
    """
    n = len(problem.b)
    lcp = new_lcp(n)
    lcp.rows[:, : len(problem.free)] = problem.N * problem.scale
    lcp.b[:], lcp.guess[:] = problem.b, True
    solve_lcp(lcp, n)
    forces = lcp.z
    answer = ForwardDynamicsSolution(
        problem, forces, problem.free + problem.response @ forces, problem.A @ forces + problem.b
    )
    allowed = RESIDUAL_TOLERANCE * max(1.0, np.abs(problem.b).max())
    if answer.residual() > allowed:
        raise SolverError(
            f'forward dynamics of {n} contacts: complementarity residual {answer.residual():.1e}; '
            f'allowed: {allowed:.1e}'
        )
    return answer
