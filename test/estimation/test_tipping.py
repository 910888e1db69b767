"""How hard an object may be pressed: against the torque range, and laws."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from wholearm_ros.estimation.squeeze import SqueezeModel
from wholearm_ros.estimation.tipping import (
    DOUBT,
    LESS_DOUBT,
    NEARLY,
    NO_DOUBT,
    Doubt,
    tipping_torque,
)
from wholearm_ros.kernels import geometry
from wholearm_ros.mechanics.contacts import closed_pairs, four_contact_subsets, gap_table
from wholearm_ros.mechanics.quasistatic import build_quasistatics
from wholearm_ros.mechanics.torque_range import build_torque_range, solve_torque_range
from wholearm_ros.model.hand import CLOSING, LEFT, RIGHT
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario import ManipulatedObject
from wholearm_ros.model.scenario_file import load_scenario

CONFIG = Path(__file__).parents[2] / 'config'
THETAS = np.linspace(1.0, 1.5, 6)


@pytest.fixture(scope='module')
def hexagon():
    return load_scenario(CONFIG / 'asymmetric_hexagon.yaml')


def squeezes(model, edge, held, thetas):
    """(resting, [q (5,), ...]) of the object on an edge between both fingers."""
    resting, told = model.resting(edge), []
    for theta, slide, angle in zip(thetas, *model.squeeze(resting, held, thetas)):
        q = np.array([*resting.pose_at(slide), 0.0, 0.0])
        q[3 + held], q[4 - held] = theta, angle
        told.append(q)
    return resting, told


def end_of_range(world, pairs, q):
    """[N m] at which the right finger, closing, lets go of a contact."""
    statics = build_quasistatics(world, pairs, q)
    known = solve_torque_range(build_torque_range(statics, RIGHT, np.full(2, 1e4)))
    return max(CLOSING[RIGHT] * (end - statics.g_h[RIGHT]) for end in (known.low, known.high))


def held_feature(model, edge, theta):
    """Which pair of features touches the held left finger at `theta` [rad]."""
    _, (q,) = squeezes(model, edge, LEFT, np.array([theta]))
    gaps, codes = gap_table(model.world, q)
    left = np.array([geometry.pair_body(code) == geometry.LEFT_FINGER for code in codes])
    return codes[left][np.argmin(np.abs(gaps[left]))]


def flush(model, edge, low, high):
    """q (5,) between two angles [rad] of the left finger, where it touches with both features."""
    first = held_feature(model, edge, low)
    while high - low > 1e-9:
        middle = (low + high) / 2
        low, high = (middle, high) if held_feature(model, edge, middle) == first else (low, middle)
    return squeezes(model, edge, LEFT, np.array([low]))


def test_a_flush_finger_holds_with_the_better_contact_and_no_more_than_both(hexagon):
    model, compared, thetas = SqueezeModel(hexagon), 0, np.linspace(1.0, 2.0, 21)
    for edge in hexagon.object.polygon.resting_edges:
        features = [held_feature(model, edge, theta) for theta in thetas]
        for k in np.flatnonzero(np.diff(features)):
            resting, (q,) = flush(model, edge, *thetas[k : k + 2])
            pairs = closed_pairs(model.world, q, 1e-6)
            if sorted(int(geometry.pair_body(c)) for c in pairs) != [0, 0, 1, 1, 2]:
                continue
            told = tipping_torque(model.world, resting, LEFT, q, NO_DOUBT, alone=False)
            both = end_of_range(model.world, pairs, q)
            fours = four_contact_subsets(pairs)
            flat = [f for f in fours if sum(geometry.pair_body(c) == 0 for c in f) == 2]
            known = [end_of_range(model.world, four, q) for four in flat]
            if max(known) < 20.0:
                assert told == pytest.approx(max(known), abs=1e-5) and told < both + 1e-5
                compared += 1
    assert compared > 2


def test_without_friction_it_is_the_end_of_the_torque_range(hexagon):
    model, compared = SqueezeModel(hexagon), 0
    for edge in hexagon.object.polygon.resting_edges:
        resting, places = squeezes(model, edge, LEFT, THETAS)
        for q in places:
            pairs = closed_pairs(model.world, q, NEARLY)
            if sorted(int(geometry.pair_body(c)) for c in pairs) != [0, 0, 1, 2]:
                continue
            known = end_of_range(model.world, pairs, q)
            told = tipping_torque(model.world, resting, LEFT, q, NO_DOUBT, alone=False)
            if known < 20.0:
                assert told == pytest.approx(known, abs=1e-6)
                compared += 1
            else:
                assert told > 20.0
    assert compared > 5


def test_doubt_never_allows_more(hexagon):
    model = SqueezeModel(hexagon)
    for edge in hexagon.object.polygon.resting_edges:
        for held in (LEFT, RIGHT):
            resting, places = squeezes(
                model, edge, held, THETAS if held == LEFT else np.pi - THETAS
            )
            for q in places:
                least = [
                    tipping_torque(model.world, resting, held, q, doubt)
                    for doubt in (NO_DOUBT, Doubt(0.0, 0.05), LESS_DOUBT, DOUBT)
                ]
                assert all(doubtful <= sure + 1e-9 for sure, doubtful in pairwise(least))


def test_the_mirrored_object_tips_at_the_same_torque(hexagon):
    model, mirror = SqueezeModel(hexagon), SqueezeModel(hexagon.mirrored())
    resting, places = squeezes(model, 0, LEFT, THETAS)
    mirrored, others = squeezes(mirror, 5, RIGHT, np.pi - THETAS)
    for q, other in zip(places, others):
        told = tipping_torque(model.world, resting, LEFT, q, DOUBT)
        assert tipping_torque(mirror.world, mirrored, RIGHT, other, DOUBT) == pytest.approx(told)


def test_a_push_that_friction_adds_to_tips_an_octagon(hexagon):
    """Felt at 0.032 N m, friction 0.046, it was tipped by the held finger that led it back."""
    outline = [[0.1, 0.6], [49.4, -10.5], [76.6, 20.4], [80.3, 52.7],
               [71.4, 97.6], [23, 117.2], [-26.4, 87.1], [-37.1, 40.9]]  # fmt: skip
    octagon = replace(hexagon, object=ManipulatedObject(Polygon(1e-3 * np.array(outline)), 0.322))
    model = SqueezeModel(octagon)
    resting, (q,) = squeezes(model, 2, LEFT, np.array([1.4027]))
    smooth = tipping_torque(model.world, resting, LEFT, q, NO_DOUBT)
    rough = tipping_torque(model.world, resting, LEFT, q, Doubt(0.0, 0.046))
    assert rough < 0.032 < smooth
