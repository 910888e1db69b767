"""Contact pairs, gaps, rows and the gap table against plain half-plane geometry and finite differences."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_geometry import (
    finger_features,
    finger_outline,
    finger_parts,
    gap_of,
    object_outline,
    outside,
    separation,
)
from problems import ASYMMETRIC, HANDS, random_configuration, scenarios, task, worlds

from wholearm_ros.kernels import geometry
from wholearm_ros.mechanics.contacts import contact_rows, gap_table, start_configuration
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.finger_shape import ConvexParts
from wholearm_ros.model.hand import LEFT, RIGHT, Hand

STEP = 1e-6  # [m, rad] of the finite differences


every_hand = pytest.mark.parametrize('hand', HANDS.values(), ids=HANDS)


def cases(seed, count, hand=HANDS['rectangles']):
    return list(worlds(np.random.default_rng(seed), count, hand))


@pytest.mark.parametrize('kind', [geometry.VERTEX_EDGE, geometry.EDGE_CORNER])
@pytest.mark.parametrize('body', [geometry.PALM, geometry.LEFT_FINGER, geometry.RIGHT_FINGER])
def test_a_pair_code_gives_back_what_it_was_made_of(kind, body):
    for hand in (0, 3, 200):
        for mine in (0, 7, 255):
            code = geometry.pair_code(kind, body, hand, mine)
            assert (geometry.pair_kind(code), geometry.pair_body(code)) == (kind, body)
            assert (geometry.pair_hand_feature(code), geometry.pair_object_feature(code)) == (
                hand,
                mine,
            )


@every_hand
def test_gaps_of_pairs_are_heights_above_the_opposite_edge(hand):
    """Every pair that the table names, at 60 random configurations."""
    checked = 0
    for scenario, world, q in cases(1, 60, hand):
        _, codes = gap_table(world, q)
        _, gaps = contact_rows(world, codes, q)
        np.testing.assert_allclose(gaps, [gap_of(scenario, c, q) for c in codes], atol=1e-14)
        checked += len(codes)
    assert checked > 1000


@every_hand
def test_rows_are_the_gradients_of_the_gaps(hand):
    """rows = ∂gap/∂q by central differences: G_nᵀ and −J_n of eq. (1)."""
    for scenario, world, q in cases(2, 40, hand):
        _, codes = gap_table(world, q)
        rows, _ = contact_rows(world, codes, q)
        for j, step in enumerate(STEP * np.eye(5)):
            slope = [
                (gap_of(scenario, c, q + step) - gap_of(scenario, c, q - step)) / (2 * STEP)
                for c in codes
            ]
            np.testing.assert_allclose(rows[:, j], slope, atol=1e-8)


@every_hand
def test_sliding_rows_are_the_velocity_of_the_object_past_the_hand(hand):
    """tangent_rows @ q̇ is the velocity of the object's material point less the hand's, along the normal turned by +90°."""
    rng = np.random.default_rng(3)
    for scenario, world, q in cases(3, 40, hand):
        _, codes = gap_table(world, q)
        rows = np.empty((len(codes), 5))
        geometry.tangent_rows(world, codes, q, rows)
        rate = rng.normal(size=5)
        for row, code in zip(rows, codes):
            px, py, nx, ny, *_ = geometry.contact(world, code, q)
            body = geometry.pair_body(code)
            mine = rate[:2] + rate[2] * np.array([-(py - q[1]), px - q[0]])
            if body > 0:
                axis = scenario.hand[body - 1].axis
                mine = mine - rate[2 + body] * np.array([-(py - axis[1]), px - axis[0]])
            assert row @ rate == pytest.approx(mine @ [-ny, nx], abs=1e-12)


@every_hand
def test_the_gap_table_is_the_largest_height_over_the_opposite_outline(hand):
    """Vertices against fingers and hand corners against the object by half planes; against the palm beside its extent: inf."""
    for scenario, world, q in cases(4, 60, hand):
        gaps, codes = gap_table(world, q)
        mine, expected = object_outline(scenario, q), []
        palm = scenario.palm.vertices
        for a, b in zip(palm[:-1], palm[1:]):
            d = (b - a) / np.linalg.norm(b - a)
            for v in mine:
                along = (v - a) @ d
                inside = 0.0 <= along <= np.linalg.norm(b - a)
                expected.append(d[0] * (v - a)[1] - d[1] * (v - a)[0] if inside else np.inf)
        for side in (LEFT, RIGHT):
            for part in finger_parts(scenario, side, q[3 + side]):
                expected.extend(outside(v, part) for v in mine)
        for side in (LEFT, RIGHT):
            features = finger_features(scenario, side, q[3 + side])
            expected.extend(outside(f, mine) for f in features.values() if np.ndim(f) == 1)
        expected.extend(outside(palm[k], mine) for k in world.corners)
        np.testing.assert_allclose(gaps, expected, atol=1e-14)
        assert len(codes) == geometry.table_size(world)


@every_hand
def test_every_entry_of_the_table_knows_its_place(hand):
    for _, world, q in cases(5, 20, hand):
        _, codes = gap_table(world, q)
        assert [geometry.entry_of(world, c) for c in codes] == list(range(len(codes)))


@every_hand
def test_the_clearance_of_a_finger_is_the_separation_of_the_outlines(hand):
    """By the separating axis theorem on plain polygons; where outlines are apart, the table has positive gaps only."""
    apart = overlapping = 0
    for scenario, world, q in cases(6, 200, hand):
        gaps, codes = gap_table(world, q)
        for side in (LEFT, RIGHT):
            at = geometry.frame_of_object(q)
            found = geometry.finger_clearance(world, side, q[3 + side], at)
            expected = min(
                separation(object_outline(scenario, q), part)
                for part in finger_parts(scenario, side, q[3 + side])
            )
            assert found == pytest.approx(expected, abs=1e-14)
            if expected > 0.0:
                apart += 1
                assert (
                    min(g for g, code in zip(gaps, codes) if geometry.pair_body(code) == 1 + side)
                    > 0.0
                )
            else:
                overlapping += 1
    assert apart > 100 and overlapping > 50


@every_hand
@given(scenario=scenarios())
@settings(max_examples=25)
def test_a_finger_closes_until_it_touches_and_no_further(hand, scenario):
    """At the closing angle the outlines are apart by nothing; at 80 angles on the way there they are apart by something."""
    scenario = replace(scenario, hand=hand)
    world, q = build_world(scenario), start_configuration(scenario)
    mine = object_outline(scenario, q)

    def apart(side, angle):
        return min(separation(mine, part) for part in finger_parts(scenario, side, angle))

    for side in (LEFT, RIGHT):
        closing = geometry.closing_angle(world, side, q[:3])
        opened = world.limits[side, 1 if side == LEFT else 0]
        assert abs(apart(side, closing)) < 1e-9
        for angle in np.linspace(opened, closing, 80, endpoint=False):
            assert apart(side, angle) > 0.0


def test_a_finger_that_touches_nothing_or_touches_when_open_has_no_closing_angle():
    world = build_world(ASYMMETRIC)
    far, on_it, run_through = (0.0, 3.0, 0.0), (-0.25, -0.02, 0.0), (-0.17, -0.02, 0.0)
    for pose in (far, on_it, run_through):
        assert np.isnan(geometry.closing_angle(world, LEFT, pose))


def test_a_finger_whose_tip_grazes_an_apex_does_not_close_on_the_far_side():
    """The apex of a thin triangle at the finger's reach: passed between two steps of the sweep, found by hypothesis."""
    triangle = task(
        [[5.53610157e-03, 5.44542128e-02], [-1.64197794e-02, -5.25998399e-02], [0.06, 0.0]],
        2,
        1,
        x=0.015625,
    )
    q = start_configuration(triangle)
    assert abs(separation(object_outline(triangle, q), finger_outline(triangle, LEFT, q[3]))) < 1e-9


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=50)
def test_a_gap_does_not_change_when_object_and_finger_turn_together_about_the_finger_axis(seed):
    """Gaps are relative: turning object and finger as one about the finger's axis keeps every gap between them."""
    rng = np.random.default_rng(seed)
    ((scenario, world, q),) = worlds(rng, 1)
    q, turn, side = random_configuration(rng), rng.uniform(-1.0, 1.0), int(rng.integers(2))
    axis = scenario.hand[side].axis
    c, s = np.cos(turn), np.sin(turn)
    moved = q.copy()
    moved[:2] = axis + np.array([[c, -s], [s, c]]) @ (q[:2] - axis)
    moved[2] += turn
    moved[3 + side] += turn
    gaps, codes = gap_table(world, q)
    own = [k for k, code in enumerate(codes) if geometry.pair_body(code) == 1 + side]
    np.testing.assert_allclose(gap_table(world, moved)[0][own], gaps[own], atol=1e-13)


@every_hand
def test_edges_end_in_the_corners_that_they_are_said_to_meet_in(hand):
    """Two edges a corner, each with an end there that names the corner."""
    world = build_world(replace(ASYMMETRIC, hand=hand))
    known, at = world.features, geometry.frame_at(0.3, -0.2, 0.7)
    for side in (LEFT, RIGHT):
        own = np.flatnonzero(known.corner_sides == side)
        for row in own:
            number = row - known.corner_rows[side]
            place = geometry.finger_corner(world, side, number, at)
            assert len(set(known.edges_at[row])) == 2 and (known.edges_at[row] >= 0).all()
            for feature in known.edges_at[row]:
                edge = geometry.finger_edge(world, side, feature, at)
                named = known.edge_ends[known.edge_rows[side] + feature] == number
                assert named.sum() == 1
                along = edge.length if named[1] else 0.0
                end = (edge.x + along * edge.dx, edge.y + along * edge.dy)
                np.testing.assert_allclose(place, end, atol=1e-15)


def test_parts_that_meet_along_an_edge_have_one_corner_at_each_end_of_it():
    """A rectangle cut across: the cut's edges are hidden, the halves of its sides follow each other."""
    halves = [[[0, -0.006], [0.1, -0.006], [0.1, 0.006], [0, 0.006]]]
    halves.append([[0.1, -0.006], [0.15, -0.006], [0.15, 0.006], [0.1, 0.006]])
    finger = replace(ASYMMETRIC.hand.left, shape=ConvexParts(halves))
    known = build_world(replace(ASYMMETRIC, hand=Hand(finger, finger.mirrored()))).features
    for side in (LEFT, RIGHT):
        corners = known.corners[known.corner_sides == side]
        assert len(corners) == 6
        edges = known.edges_at[known.corner_sides == side] - geometry.RECTANGLE_EDGES
        met = {tuple(np.round(c, 9)): set(e) for c, e in zip(corners.tolist(), edges.tolist())}
        inner = -0.006 if side == LEFT else 0.006
        assert met[0.1, inner] == {0, 4} and met[0.1, -inner] == {2, 6}
