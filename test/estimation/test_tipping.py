"""How hard an object may be pressed: against the torque range, and laws."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from wholearm_ros.estimation.squeeze import SqueezeModel
from wholearm_ros.estimation.tipping import DOUBT, NO_DOUBT, Doubt, tipping_torque
from wholearm_ros.kernels import geometry
from wholearm_ros.mechanics.contacts import closed_pairs
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


def test_without_friction_it_is_the_end_of_the_torque_range(hexagon):
    model, compared = SqueezeModel(hexagon), 0
    for edge in hexagon.object.polygon.resting_edges:
        resting, places = squeezes(model, edge, LEFT, THETAS)
        for q in places:
            pairs = closed_pairs(model.world, q, 1e-6)
            if sorted(int(geometry.pair_body(c)) for c in pairs) != [0, 0, 1, 2]:
                continue
            statics = build_quasistatics(model.world, pairs, q)
            known = solve_torque_range(build_torque_range(statics, RIGHT, np.full(2, 1e4)))
            ends = [CLOSING[RIGHT] * (end - statics.g_h[RIGHT]) for end in (known.low, known.high)]
            told = tipping_torque(model.world, resting, LEFT, q, NO_DOUBT, alone=False)
            if max(ends) < 20.0:
                assert told == pytest.approx(max(ends), abs=1e-6)
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
                    for doubt in (NO_DOUBT, Doubt(0.0, 0.05), Doubt(0.0, 0.10), DOUBT)
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
