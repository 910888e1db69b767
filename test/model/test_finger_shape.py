"""Shapes of fingers: area, centre and inertia against sums over a fine grid, outlines, weights against energy."""

from dataclasses import replace

import numpy as np
import pytest
from plain_geometry import outside
from problems import ASYMMETRIC, HANDS

from wholearm_ros.model.finger_shape import ConvexParts, Rectangle
from wholearm_ros.model.hand import Hand
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.union import union_moments, union_outline
from wholearm_ros.model.weight import bearing_torques

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
HOOKED = HANDS['hooked'].left.shape
# Overlapping, side by side with a common edge, three of which all overlap, and one inside another.
UNIONS = {
    'crossing': [SQUARE, SQUARE + [0.4, 0.3]],
    'butt': [SQUARE, SQUARE + [1.0, 0.0]],
    'three': [SQUARE, SQUARE + [0.5, 0.2], SQUARE + [0.2, 0.6]],
    'inside': [SQUARE, 0.3 * SQUARE + [0.2, 0.2]],
    'flush': [SQUARE, SQUARE * [1.0, 0.5] + [0.5, 0.0]],
    'hooked': list(HOOKED.parts),
}


def grid(parts, n=1200):
    """(points (m, 2) of a fine grid that lie in any of the parts, area of one)."""
    everything = np.vstack(parts)
    low, size = everything.min(axis=0), np.ptp(everything, axis=0)
    steps = (np.arange(n) + 0.5) / n
    points = low + size * np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    inside = np.zeros(len(points), bool)
    for part in parts:
        edges = np.roll(part, -1, axis=0) - part
        away = points[:, None] - part
        inside |= (edges[:, 0] * away[..., 1] - edges[:, 1] * away[..., 0] >= 0.0).all(axis=1)
    return points[inside], size.prod() / n**2


@pytest.mark.parametrize('parts', UNIONS.values(), ids=UNIONS)
def test_moments_of_a_union_are_sums_over_its_points(parts):
    points, cell = grid(parts)
    size = np.ptp(points, axis=0).max()
    squares = (points**2).sum()
    sums = cell * np.array([len(points), *points.sum(axis=0), squares])
    np.testing.assert_allclose(
        union_moments(parts) / size ** np.array([2, 3, 3, 4]),
        sums / size ** np.array([2, 3, 3, 4]),
        atol=2e-3,
    )


@pytest.mark.parametrize('parts', UNIONS.values(), ids=UNIONS)
def test_the_outline_of_a_union_holds_its_area_and_passes_no_part_s_inside(parts):
    outline = union_outline(parts)
    assert Polygon(outline).area == pytest.approx(union_moments(parts)[0], rel=1e-6)
    for start, end in zip(outline, np.roll(outline, -1, axis=0)):
        heights = [outside((start + end) / 2, part) for part in parts]
        assert min(heights) == pytest.approx(0.0, abs=1e-8)


def test_a_rectangle_drawn_is_a_rectangle_told():
    told = Rectangle(0.15, 0.006)
    drawn = ConvexParts([told.outline])
    split = ConvexParts([[[0, -0.006], [0.1, -0.006], [0.1, 0.006], [0, 0.006]], told.outline])
    for shape in (drawn, split):
        assert shape.length == told.length
        np.testing.assert_allclose(shape.centre, told.centre, atol=1e-15)
        assert shape.inertia(0.2) == pytest.approx(told.inertia(0.2), rel=1e-12)


@pytest.mark.parametrize('name', HANDS)
def test_mirrored_scaled_and_shortened_shapes(name):
    shape = HANDS[name].left.shape
    image, large, short = shape.mirrored(), shape.scaled(2.0), shape.shortened(0.005)
    np.testing.assert_allclose(image.centre, shape.centre * [1.0, -1.0], atol=1e-15)
    assert image.inertia(1.0) == pytest.approx(shape.inertia(1.0))
    assert all(Polygon(part).area > 0.0 for part in image.parts)
    np.testing.assert_allclose(large.centre, 2.0 * shape.centre)
    assert large.inertia(1.0) == pytest.approx(4.0 * shape.inertia(1.0))
    assert short.length == pytest.approx(shape.length - 0.005)
    for point in np.vstack(short.parts):
        assert min(outside(point, part) for part in shape.parts) < 1e-12


@pytest.mark.parametrize('turn', [0.0, 0.03])
@pytest.mark.parametrize('name', HANDS)
def test_what_bears_a_finger_is_the_slope_of_its_potential_energy(name, turn):
    """Its centre of mass may lie beside the line along which its angle is counted."""
    scenario = replace(ASYMMETRIC, hand=HANDS[name])
    scenario = replace(scenario, gravity=replace(scenario.gravity, turn=turn))
    pull, step = scenario.gravity.pull, 1e-6

    def energy(side, angle):
        finger = scenario.hand[side]
        c, s = np.cos(angle), np.sin(angle)
        return -finger.mass * pull @ (np.array([[c, -s], [s, c]]) @ finger.shape.centre)

    for angles in np.random.default_rng(3).uniform(0.0, 3.1, (10, 2)):
        slopes = [
            (energy(side, a + step) - energy(side, a - step)) / (2 * step)
            for side, a in enumerate(angles)
        ]
        weights = scenario.finger_weights
        lean = np.tan(turn)
        along, across = weights[:, 0], weights[:, 1]
        found = bearing_torques(weights, angles)
        found = found + lean * (along * np.sin(angles) + across * np.cos(angles))
        np.testing.assert_allclose(found, slopes, atol=1e-8)


def test_a_finger_and_its_image_weigh_the_same_on_their_motors():
    hand = HANDS['hooked']
    one, other = (
        replace(ASYMMETRIC, hand=h) for h in (hand, Hand(hand.right.mirrored(), hand.right))
    )
    angles = np.array([0.7, 1.3])
    mirrored = bearing_torques(other.finger_weights, np.array([np.pi - angles[1], angles[1]]))
    assert mirrored[0] == pytest.approx(-bearing_torques(one.finger_weights, angles)[1])
