"""Mirror images: of a mirror image is the original, and mechanics does not know left from right."""

import numpy as np
import pytest
from problems import ASYMMETRIC, OF_SHAPES, ON_BENT_PALM, REGULAR, random_configuration

from wholearm_ros.mechanics.contacts import contact_rows, gap_table, pair_from_name, pair_name
from wholearm_ros.mechanics.mirror import mirror_configurations, mirror_contacts
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.scenario_file import scenario_to_dict

CASES = {'asymmetric': ASYMMETRIC, 'regular': REGULAR, 'bent': ON_BENT_PALM, **OF_SHAPES}
SCENARIOS = pytest.mark.parametrize('scenario', CASES.values(), ids=CASES)
RNG = np.random.default_rng(60)


@SCENARIOS
def test_a_scenario_mirrored_twice_is_itself(scenario):
    image, back = (
        scenario_to_dict(s) for s in (scenario.mirrored(), scenario.mirrored().mirrored())
    )
    assert image != scenario_to_dict(scenario)
    assert_close(back, scenario_to_dict(scenario))


def assert_close(a, b):
    """The same documents, numbers to rounding."""
    if isinstance(a, dict):
        assert a.keys() == b.keys()
        for key in a:
            assert_close(a[key], b[key])
    elif isinstance(a, (list, tuple)) or hasattr(a, 'shape'):
        assert len(a) == len(b)
        for x, y in zip(a, b):
            assert_close(x, y)
    elif isinstance(a, float):
        assert a == pytest.approx(b, abs=1e-14)
    else:
        assert a == b


def test_configurations_mirrored_twice_are_themselves():
    q = RNG.normal(size=(7, 3, 5))
    np.testing.assert_allclose(mirror_configurations(mirror_configurations(q)), q, atol=1e-15)


@SCENARIOS
def test_contact_names_mirrored_twice_are_themselves_and_no_two_share_an_image(scenario):
    world = build_world(scenario)
    names = tuple(
        sorted(
            {
                pair_name(c)
                for _ in range(40)
                for c in gap_table(world, random_configuration(RNG))[1]
            }
        )
    )
    images = mirror_contacts(names, scenario)
    assert mirror_contacts(images, scenario) == names and len(set(images)) == len(names)


@SCENARIOS
def test_a_pair_and_its_image_have_the_same_gap_and_mirrored_rows(scenario):
    """At 20 random configurations, for every pair of the table: rows change sign in x, φ and both θ, which change places."""
    world, other = build_world(scenario), build_world(scenario.mirrored())
    for _ in range(20):
        q = random_configuration(RNG)
        gaps, codes = gap_table(world, q)
        images = [
            pair_from_name(n) for n in mirror_contacts(tuple(map(pair_name, codes)), scenario)
        ]
        (rows, direct), (image_rows, mirrored) = (
            contact_rows(world, codes, q),
            contact_rows(other, images, mirror_configurations(q)),
        )
        np.testing.assert_allclose(mirrored, direct, atol=1e-13)
        np.testing.assert_allclose(
            image_rows, rows[:, [0, 1, 2, 4, 3]] * [-1, 1, -1, -1, -1], atol=1e-13
        )
        np.testing.assert_allclose(
            np.sort(gap_table(other, mirror_configurations(q))[0]), np.sort(gaps), atol=1e-13
        )
