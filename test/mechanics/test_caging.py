"""Cages against the height of the centroid on a fine grid: what gravity alone does to a frictionless polygon."""

import numpy as np
import pytest
from hypothesis import given, settings
from problems import ASYMMETRIC, REGULAR, polygons

from wholearm_ros.mechanics.caging import PAST_THE_TOP, cages_between

GRID = 20_000


def height(polygon, angles, floor=0.0):
    """(k,) [m] of the centroid when the lowest vertex touches a palm of direction `floor`, measured across the palm."""
    v = polygon.vertices_about_centroid
    return -(
        np.sin(angles - floor)[:, None] * v[:, 0] + np.cos(angles - floor)[:, None] * v[:, 1]
    ).min(axis=1)


@given(polygons())
@settings(max_examples=80)
def test_cages_end_at_every_minimum_of_the_height_and_nowhere_else(polygon):
    """Over one turn: as many as the grid shows, each within a step of the grid."""
    start, step = 0.1234, 2.0 * np.pi / GRID
    angles = start + step * np.arange(-1, GRID + 1)
    h = height(polygon, angles)
    minima = angles[1:-1][(h[1:-1] < h[:-2]) & (h[1:-1] <= h[2:])]
    cages = cages_between(polygon, start, start + 2.0 * np.pi)
    landings = np.array([c.landing for c in cages])
    assert len(landings) == len(minima)
    assert (np.abs((landings - minima + np.pi) % (2.0 * np.pi) - np.pi) <= 1.5 * step).all()


@given(polygons())
@settings(max_examples=80)
def test_from_the_top_the_height_falls_all_the_way_and_rises_beyond_the_landing(polygon):
    """So the object cannot come to rest before it lands, and does not tip over with less energy than the barrier."""
    for cage in cages_between(polygon, -1.0, -1.0 + 2.0 * np.pi):
        assert cage.top < cage.landing < cage.beyond
        down, up = (
            height(polygon, np.linspace(*ends, 500))
            for ends in ((cage.top, cage.landing), (cage.landing, cage.beyond))
        )
        assert (np.diff(down) < 1e-12).all() and (np.diff(up) > -1e-12).all()
        assert cage.drop == pytest.approx(down[0] - down[-1], abs=1e-12) and cage.drop > 0.0
        assert cage.barrier == pytest.approx(up[-1] - up[0], abs=1e-12) and cage.barrier > 0.0


@given(polygons())
@settings(max_examples=40)
def test_the_top_is_a_maximum_of_the_height(polygon):
    """Just before it, gravity turns the object back."""
    for cage in cages_between(polygon, 0.0, 2.0 * np.pi):
        before, top = height(polygon, np.array([cage.top - 1e-4, cage.top]))
        assert before < top


@given(polygons())
@settings(max_examples=40)
def test_a_tilted_palm_turns_the_cages_with_it(polygon):
    level = cages_between(polygon, 0.0, 6.0)
    tilted = cages_between(polygon, 0.2, 6.2, floor=0.2)
    assert len(level) == len(tilted)
    for a, b in zip(level, tilted):
        np.testing.assert_allclose(
            [b.top, b.landing, b.beyond], np.add([a.top, a.landing, a.beyond], 0.2), atol=1e-9
        )
        np.testing.assert_allclose([b.drop, b.barrier], [a.drop, a.barrier], atol=1e-12)


def test_a_regular_hexagon_has_six_equal_cages_a_side_apart():
    """From vertex up (30° before landing): drop r (1 − cos 30°)."""
    cages = cages_between(REGULAR.object.polygon, 0.001, 0.001 + 2.0 * np.pi)
    assert len(cages) == 6
    np.testing.assert_allclose(np.diff([c.landing for c in cages]), np.pi / 3, atol=1e-6)
    for c in cages:
        assert c.landing - c.top == pytest.approx(np.pi / 6, abs=1e-6)
        assert c.drop == pytest.approx(0.06 * (1.0 - np.sqrt(0.75)), abs=1e-7)


def test_cages_lie_in_the_stretch_asked_for_and_in_order():
    polygon = ASYMMETRIC.object.polygon
    cages = cages_between(polygon, 0.0, 2.5)
    landings = [c.landing for c in cages]
    assert landings == sorted(landings) and all(0.0 < a <= 2.5 + 1e-6 for a in landings)
    assert cages_between(polygon, 0.0, 0.5) == ()
    assert len(cages_between(polygon, 0.0, 2.5 + 2.0 * np.pi)) == len(cages) + len(
        cages_between(polygon, 2.5, 2.5 + 2.0 * np.pi)
    )
    assert 0.0 < PAST_THE_TOP < min(c.landing - c.top for c in cages)
