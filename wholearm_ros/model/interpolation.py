"""Polynomials of motion, as plain formulas: `kernels/` compiles these very functions with numba."""

from typing import Any

# A number or an array of numbers; a formula gives what it is given.
Value = Any


# Of the fifth-order polynomial from rest to rest, per unit of distance and time.
PEAK_SPEED = 15.0 / 8.0
PEAK_ACCELERATION = 10.0 / 3.0**0.5


def quintic(u: Value) -> tuple[Value, Value]:
    """(position, speed) of the fifth-order polynomial from 0 to 1 at u in [0, 1], at rest at both
    ends.
    """
    return u**3 * (10.0 - 15.0 * u + 6.0 * u**2), 30.0 * u**2 * (1.0 - u) ** 2


def rise(t: float, span: float) -> tuple[float, float]:
    """The same from 0 at t = 0 to 1 at t = `span` [s], held at both ends; and its rate [1/s]."""
    if t >= span:
        return 1.0, 0.0
    u = max(t, 0.0) / span
    # Not `quintic(u)`: its last bits differ, and with them those of every simulated run.
    return u**3 * (10.0 - 15.0 * u + 6.0 * u * u), 30.0 * (u * (1.0 - u)) ** 2 / span


def fade(t: float, span: float) -> tuple[float, float]:
    """The same from 1 to 0."""
    position, rate = rise(t, span)
    return 1.0 - position, -rate


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
