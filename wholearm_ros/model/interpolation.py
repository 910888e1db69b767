"""Polynomials of motion. Plain formulas that numba can compile: `kernels/` compiles these very functions."""


def quintic(u):
    """(position, speed) at u in [0, 1] of the fifth-order polynomial from 0 to 1, at rest at both ends."""
    return u**3 * (10.0 - 15.0 * u + 6.0 * u**2), 30.0 * u**2 * (1.0 - u) ** 2


def fade(t: float, span: float) -> tuple[float, float]:
    """1 at t = 0, 0 from t = `span` [s] on, by the fifth-order polynomial at rest at both ends; and its rate [1/s]."""
    if t >= span:
        return 0.0, 0.0
    u = max(t, 0.0) / span
    return 1.0 - u**3 * (10.0 - 15.0 * u + 6.0 * u * u), -30.0 * (u * (1.0 - u)) ** 2 / span


def hermite(p0, p1, v0, v1, period, u):
    """The cubic through p0, p1 with velocities v0, v1 there, at the share u in [0, 1] of `period` [s]."""
    return (
        p0 * ((1 + 2 * u) * (1 - u) ** 2)
        + p1 * (u * u * (3 - 2 * u))
        + period * v0 * (u * (1 - u) ** 2)
        + period * v1 * (u * u * (u - 1))
    )
