"""Frames of bodies in the plane, as plain formulas: `kernels/` compiles these very functions."""

from typing import Any, NamedTuple

import numpy as np

# A number or an array of numbers; a formula gives what it is given.
Value = Any


class Frame(NamedTuple):
    """Of a body: its origin x, y [m], cosine and sine of its rotation."""

    x: Value
    y: Value
    cos: Value
    sin: Value


def frame_at(x: Value, y: Value, angle: Value) -> Frame:
    """The frame with its origin at x, y [m], turned by `angle` [rad]."""
    return Frame(x, y, np.cos(angle), np.sin(angle))


def in_world(frame: Frame, x: Value, y: Value) -> tuple[Value, Value]:
    """A point x, y [m] of the body."""
    return (
        frame.x + frame.cos * x - frame.sin * y,
        frame.y + frame.sin * x + frame.cos * y,
    )


def in_body(frame: Frame, x: Value, y: Value) -> tuple[Value, Value]:
    """A point x, y [m] of the world, in the body's frame."""
    dx, dy = x - frame.x, y - frame.y
    return frame.cos * dx + frame.sin * dy, frame.cos * dy - frame.sin * dx


def turned(frame: Frame, x: Value, y: Value) -> tuple[Value, Value]:
    """A direction x, y of the body, in the world."""
    return frame.cos * x - frame.sin * y, frame.sin * x + frame.cos * y


def seen_from(frame: Frame, other: Frame) -> Frame:
    """The other frame, as it is in the first one."""
    x, y = in_body(frame, other.x, other.y)
    cos = frame.cos * other.cos + frame.sin * other.sin
    sin = frame.cos * other.sin - frame.sin * other.cos
    return Frame(x, y, cos, sin)


def placed(vertices: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """(n, 2) [m]: vertices (n, 2) of a body at `pose` (3,) [m, m, rad]."""
    return np.column_stack(in_world(frame_at(*pose), vertices[:, 0], vertices[:, 1]))
