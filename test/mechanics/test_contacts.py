"""Contact names, the contact state matrix, and how the hand closes on the object."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from plain_geometry import finger_outline, object_outline, separation
from problems import ASYMMETRIC, ON_BENT_PALM, SHIPPED, scenarios

from wholearm_ros.errors import ScenarioError
from wholearm_ros.kernels import geometry
from wholearm_ros.mechanics.contacts import (
    close_finger,
    closed_pairs,
    contact_rows,
    contact_state_matrix,
    deepest_penetration,
    four_contact_subsets,
    gap_table,
    pair_from_name,
    pair_name,
    start_configuration,
)
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.scenario import StartAtPose


def every_pair(scenario):
    """Codes of every pair that object and hand can form."""
    n, p = len(scenario.object.polygon.vertices), len(scenario.palm.vertices)
    for k in range(n):
        yield from (geometry.pair_code(0, 0, edge, k) for edge in range(p - 1))
        yield from (geometry.pair_code(1, 0, corner, k) for corner in range(p))
        for body in (1, 2):
            yield from (geometry.pair_code(0, body, edge, k) for edge in range(4))
            yield from (geometry.pair_code(1, body, corner, k) for corner in range(2))


@pytest.mark.parametrize('scenario', [ASYMMETRIC, ON_BENT_PALM], ids=['flat', 'bent'])
def test_every_contact_has_a_name_of_its_own_that_leads_back_to_it(scenario):
    pairs = list(every_pair(scenario))
    names = [pair_name(c) for c in pairs]
    assert len(set(names)) == len(pairs) and [pair_from_name(n) for n in names] == pairs


@pytest.mark.parametrize(
    'name',
    [
        '',
        'v0',
        'v0:palm',
        'v0:middle.inner',
        'v0:left.c0',
        'e0:left.e0',
        'v0:left.e252',
        'vx:palm.e0',
        'v256:palm.e0',
        'v0:palm.e-1',
    ],
)
def test_what_is_not_a_name_is_refused(name):
    with pytest.raises((ValueError, KeyError)):
        pair_from_name(name)


@pytest.mark.parametrize('scenario', [ASYMMETRIC, ON_BENT_PALM], ids=['flat', 'bent'])
def test_the_contact_state_matrix_has_a_place_for_every_pair_and_no_two_share_one(scenario):
    """C of all pairs is full where a pair exists; each pair alone sets one entry, of the row of its object feature."""
    world, pairs = build_world(scenario), list(every_pair(scenario))
    n = len(world.obj)
    for code in pairs:
        rows, columns = np.nonzero(contact_state_matrix(world, (code,)))
        assert len(rows) == 1 and rows[0] == geometry.pair_object_feature(
            code
        ) + n * geometry.pair_kind(code)
    assert contact_state_matrix(world, pairs).sum() == len(pairs)
    assert not contact_state_matrix(world, ()).any()


def test_subsets_are_all_choices_of_four_that_touch_palm_and_both_fingers():
    names = ('v0:palm.e0', 'v1:palm.e0', 'v5:left.inner', 'v4:left.inner', 'v2:right.inner')
    subsets = four_contact_subsets(tuple(map(pair_from_name, names)))
    assert len(subsets) == 4  # of the five choices, the one without the right finger is missing
    assert all({int(geometry.pair_body(c)) for c in four} == {0, 1, 2} for four in subsets)


@given(scenarios())
@settings(max_examples=60)
def test_a_start_on_an_edge_touches_palm_and_fingers_and_penetrates_nothing(scenario):
    """The edge's two vertices on the palm and each finger on the object, all to 1e-9 m; no other gap below −1e-9."""
    world = build_world(scenario)
    q = start_configuration(scenario, world)
    gaps, codes = gap_table(world, q)
    bodies = np.array([geometry.pair_body(c) for c in codes])
    edge, n = scenario.start.edge, len(world.obj)
    on_palm = [pair_from_name(f'v{k}:palm.e0') for k in (edge, (edge + 1) % n)]
    assert np.abs(contact_rows(world, on_palm, q)[1]).max() <= 1e-9
    assert gaps.min() >= -1e-9
    assert all(gaps[bodies == body].min() <= 1e-9 for body in range(3))
    assert q[0] == scenario.start.x and {
        int(geometry.pair_body(c)) for c in closed_pairs(world, q)
    } == {0, 1, 2}
    for side in range(2):
        assert (
            abs(
                separation(object_outline(scenario, q), finger_outline(scenario, side, q[3 + side]))
            )
            < 1e-8
        )


@pytest.mark.parametrize('name', SHIPPED)
def test_the_shipped_starts_have_at_least_four_contacts(name):
    world = build_world(SHIPPED[name])
    assert len(closed_pairs(world, start_configuration(SHIPPED[name], world))) >= 4


def test_a_finger_that_cannot_touch_is_an_error_that_names_it():
    with pytest.raises(ScenarioError, match='hand.right'):
        close_finger(build_world(ASYMMETRIC), np.array([-0.3, 0.06, 0.0]), 1)


def test_a_start_that_penetrates_is_an_error_that_names_the_pair():
    q = start_configuration(ASYMMETRIC)
    sunk = replace(ASYMMETRIC, start=StartAtPose(q[:3] - [0.0, 0.002, 0.0], q[3:]))
    with pytest.raises(ScenarioError, match=r'2\.00 mm at v\d:palm'):
        start_configuration(sunk)


def test_penetration_is_the_depth_of_the_deepest_pair():
    world, q = build_world(ASYMMETRIC), start_configuration(ASYMMETRIC)
    assert deepest_penetration(world, q)[0] < 1e-9
    depth, pair = deepest_penetration(world, q - [0.0, 0.003, 0.0, 0.0, 0.0])
    assert depth == pytest.approx(0.003, abs=1e-9) and 'palm' in pair


@pytest.mark.parametrize('digits', [4, 5, 6])
def test_a_start_written_with_few_digits_is_in_contact(digits):
    """As a final pose is printed: it lies on its edge, and both fingers touch."""
    exact = start_configuration(ASYMMETRIC)
    q = np.round(exact, digits)
    told = replace(ASYMMETRIC, start=StartAtPose(q[:3], q[3:]))
    found = start_configuration(told)
    assert found == pytest.approx(exact, abs=10.0**-digits)
    assert len(closed_pairs(build_world(told), found)) == len(
        closed_pairs(build_world(ASYMMETRIC), exact)
    )
    assert np.array_equal(
        start_configuration(replace(told, start=StartAtPose(found[:3], found[3:]))), found
    )


def test_a_start_away_from_contact_stays_as_it_is():
    q = start_configuration(ASYMMETRIC) + [0.0, 4e-4, 5e-3, 0.02, -0.02]
    told = replace(ASYMMETRIC, start=StartAtPose(q[:3], q[3:]))
    assert np.array_equal(start_configuration(told), q)
