"""Equilibrium of four contacts: contact forces affine in the torque of one finger, and the
interval that keeps them compressive.
"""

import numpy as np

from wholearm_ros.kernels import allocating, inlined, kernel
from wholearm_ros.kernels.linear import solve_in_place
from wholearm_ros.kernels.world import joint
from wholearm_ros.model import weight
from wholearm_ros.model.configuration import ROTATION, SIZE, X, Y

bearing = inlined(weight.bearing)


@allocating
def equilibrium_forces(rows, load, torque_finger, forces):
    """Solve eq. (4) for f = a + b τ_T; forces (4, 2) receives columns a [N] and b [1/m]. Returns
    the pivot ratio.

    rows: (4, 5) = [G_nᵀ, −J_n] (or its friction-tilted copy); load: (5,) = (−g_O, g_h) [N, N, N m,
    N m, N m]. [G_n; −J_nTᵀ] f = [−g_O; g_T − τ_T].
    """
    m, column = np.empty((4, 4)), joint(torque_finger)
    for i in range(4):
        for k in range(3):
            m[k, i] = rows[i, k]
        m[3, i] = rows[i, column]
        forces[i, 0], forces[i, 1] = 0.0, 0.0
    for k in range(3):
        forces[k, 0] = load[k]
    forces[3, 0] = load[column]
    forces[3, 1] = -1.0
    return solve_in_place(m, forces)


@allocating
def torque_interval(rows, load, limits, torque_finger, forces):
    """(τ_min, τ_max) [N m] of the torque-controlled finger by (4), (5) and both motors' limits;
    (1, −1)-like when empty.

    f ≥ 0 is affine in τ_T, and so is τ_V = −rows[:, V]ᵀ f + g_V: the range of problem (6) is an
    interval, found by clipping. Returns (τ_min, τ_max, pivot ratio).
    """
    ratio = equilibrium_forces(rows, load, torque_finger, forces)
    low, high = -limits[torque_finger], limits[torque_finger]
    if ratio < 1e-9:
        return 1.0, -1.0, ratio
    for i in range(4):
        a, b = forces[i, 0], forces[i, 1]
        low, high = clip_interval(low, high, a, b)
    column = joint(1 - torque_finger)
    a, b = load[column], 0.0
    for i in range(4):
        a -= rows[i, column] * forces[i, 0]
        b -= rows[i, column] * forces[i, 1]
    limit = limits[1 - torque_finger]
    low, high = clip_interval(low, high, limit - a, -b)
    low, high = clip_interval(low, high, limit + a, b)
    return low, high, ratio


@inlined
def weight_at(weights, side, angle):
    """The torque [N m] that holds a finger at an angle [rad] against gravity."""
    return bearing(weights[side, 0], weights[side, 1], np.cos(angle), np.sin(angle))


@kernel
def load_at(load, weights, q, out):
    """Fill out (5,) = (−g_O, g_h): the fingers' entries are the torques that hold them against
    gravity, m g L/2 cos θ for rectangles. weights: (2, 2), see `World`.
    """
    out[X], out[Y], out[ROTATION] = load[X], load[Y], load[ROTATION]
    for side in range(2):
        out[joint(side)] = weight_at(weights, side, q[joint(side)])


@kernel
def clip_interval(low, high, a, b):
    """Keep of [low, high] what satisfies a + b τ ≥ 0."""
    if abs(b) < 1e-12:
        return (low, high) if a >= -1e-12 else (1.0, -1.0)
    if b > 0.0:
        return max(low, -a / b), high
    return low, min(high, -a / b)


@kernel
def tilt_rows(rows, tangents, velocity, friction, tilted):
    """Rows (k, 5) through which contact forces act when every contact slides with friction: N − μ
    sign(T q̇) T.
    """
    for i in range(rows.shape[0]):
        slip = 0.0
        for j in range(SIZE):
            slip += tangents[i, j] * velocity[j]
        sign = 0.0 if abs(slip) < 1e-9 else (1.0 if slip > 0.0 else -1.0)
        for j in range(SIZE):
            tilted[i, j] = rows[i, j] - friction * sign * tangents[i, j]
