"""Polynomials of motion, as plain formulas: `kernels/` compiles these very functions with numba."""

from typing import Any

# A number or an array of numbers; a formula gives what it is given.
Value = Any


def quintic(u: Value) -> tuple[Value, Value]:
    """(position, speed) of the fifth-order polynomial from 0 to 1 at u in [0, 1], at rest at both
    ends.
    """
    return u**3 * (10.0 - 15.0 * u + 6.0 * u**2), 30.0 * u**2 * (1.0 - u) ** 2


def fade(t: float, span: float) -> tuple[float, float]:
    """Fifth-order polynomial from 1 at t = 0 to 0 at t = `span` [s], at rest at both ends and 0
    thereafter; and its rate [1/s].
    """
    if t >= span:
        return 0.0, 0.0
    u = max(t, 0.0) / span
    return 1.0 - u**3 * (10.0 - 15.0 * u + 6.0 * u * u), -30.0 * (u * (1.0 - u)) ** 2 / span


def hermite(p0: Value, p1: Value, v0: Value, v1: Value, period: float, u: float) -> Value:
    """The cubic through p0 and p1 with velocities v0 and v1, `period` [s] apart, at the fraction u
    in [0, 1] of the way.
    """
    return (
        p0 * ((1 + 2 * u) * (1 - u) ** 2)
        + p1 * (u * u * (3 - 2 * u))
        + period * v0 * (u * (1 - u) ** 2)
        + period * v1 * (u * u * (u - 1))
    )
