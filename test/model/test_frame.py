"""Frames and separations as plain formulas: there and back, and the very numbers of the compiled ones."""

import numpy as np
import pytest
from plain_geometry import finger_outline, object_outline, outside, separation
from problems import worlds

from wholearm_ros.kernels import geometry
from wholearm_ros.model.frame import frame_at, in_body, in_world, placed, turned
from wholearm_ros.model.separation import point_clearance, rectangle_clearance


def test_a_point_comes_back_and_a_direction_is_a_difference_of_points():
    rng = np.random.default_rng(0)
    frame = frame_at(*rng.normal(size=(3, 50)))
    x, y = rng.normal(size=(2, 50))
    np.testing.assert_allclose(in_body(frame, *in_world(frame, x, y)), [x, y], atol=1e-14)
    origin = in_world(frame, 0.0, 0.0)
    np.testing.assert_allclose(
        turned(frame, x, y), np.subtract(in_world(frame, x, y), origin), atol=1e-14
    )


def test_placed_vertices_and_separations_are_those_of_the_outlines():
    """Of a finger at several angles at once."""
    for scenario, world, q in worlds(np.random.default_rng(1), 30):
        outline = object_outline(scenario, q)
        np.testing.assert_allclose(placed(world.obj[:, :2], q[:3]), outline, atol=1e-15)
        at, f, angles = frame_at(*q[:3]), scenario.hand.left, np.linspace(0.1, 3.0, 9)
        fingers = frame_at(f.axis[0], f.axis[1], angles)
        found = rectangle_clearance(world.obj, at, fingers, f.shape.length, f.shape.half_width)
        expected = [separation(outline, finger_outline(scenario, 0, angle)) for angle in angles]
        np.testing.assert_allclose(found, expected, atol=1e-14)
        assert point_clearance(world.obj, at, *f.axis)[0] == pytest.approx(
            outside(f.axis, outline), abs=1e-14
        )


def test_the_compiled_formulas_give_the_same_bits():
    for scenario, world, q in worlds(np.random.default_rng(2), 30):
        at = frame_at(*q[:3])
        for side, f in enumerate((scenario.hand.left, scenario.hand.right)):
            finger = frame_at(f.axis[0], f.axis[1], q[3 + side])
            plain = rectangle_clearance(world.obj, at, finger, f.shape.length, f.shape.half_width)
            assert plain == geometry.finger_clearance(world, side, q[3 + side], at)
