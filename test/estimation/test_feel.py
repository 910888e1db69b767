"""Feeling: laws of squeezes, and verdicts on pairs whose origin is known."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wholearm_ros.estimation.claim import claim
from wholearm_ros.estimation.feel import Feeler
from wholearm_ros.estimation.probe_plan import STRONGEST, WEAKEST, nearest_resting, plan_probe
from wholearm_ros.estimation.squeeze import SqueezeModel
from wholearm_ros.mechanics.contacts import gap_table
from wholearm_ros.model.hand import CLOSING, LEFT, RIGHT
from wholearm_ros.model.outcomes import AT_GOAL, ELSEWHERE, LOST, LYING, NOTHING, UNKNOWN
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario import GoalOnEdge, ManipulatedObject
from wholearm_ros.model.scenario_file import load_scenario

CONFIG = Path(__file__).parents[2] / 'config'


@pytest.fixture(scope='module')
def hexagon():
    return load_scenario(CONFIG / 'asymmetric_hexagon.yaml')


@pytest.fixture(scope='module')
def regular():
    return load_scenario(CONFIG / 'regular_hexagon.yaml')


def probe_of(feeler, edge, held=LEFT, end=1.2):
    place = [h.edge for h in feeler.hypotheses].index(edge)
    return plan_probe(feeler.model, feeler.hypotheses, place, held, end)


def pairs_of(truth, probe, edge):
    """What a frictionless hand would measure with the object of `truth` on an edge."""
    model = SqueezeModel(truth)
    thetas = probe.places
    _, angles = model.squeeze(model.resting(edge), probe.held, thetas)
    pairs = np.empty((len(thetas), 2))
    pairs[:, probe.held], pairs[:, probe.closing] = thetas, angles
    return pairs


def test_squeezed_object_touches_both_fingers_and_nothing_penetrates(hexagon):
    model = SqueezeModel(hexagon)
    for edge in (0, 1, 4, 5):
        resting, thetas = model.resting(edge), np.linspace(1.0, 1.5, 4)
        slides, angles = model.squeeze(resting, LEFT, thetas)
        for slide, left, right in zip(slides, thetas, angles):
            q = np.array([*resting.pose_at(slide), left, right])
            gaps, codes = gap_table(model.world, q)
            assert gaps.min() > -1e-9
            for body in (1, 2):
                assert np.abs(gaps[(codes >> 16) & 15 == body]).min() < 1e-6


def test_squeezes_of_the_mirrored_scenario_are_mirrored(hexagon):
    model, mirror = SqueezeModel(hexagon), SqueezeModel(hexagon.mirrored())
    thetas, n = np.linspace(1.0, 1.4, 3), 6
    slides, angles = model.squeeze(model.resting(0), LEFT, thetas)
    mirrored, mirrored_angles = mirror.squeeze(mirror.resting(n - 1), RIGHT, np.pi - thetas)
    assert mirrored_angles == pytest.approx(np.pi - angles, abs=1e-6)
    assert mirrored == pytest.approx(-slides, abs=1e-6)


def test_a_perturbed_object_is_felt_on_its_edge_and_at_its_place(hexagon):
    feeler, rng = Feeler(hexagon), np.random.default_rng(3)
    for edge in sorted({h.edge for h in feeler.hypotheses}):
        if not hexagon.object.polygon.can_rest_on(edge):
            continue
        probe = probe_of(feeler, edge)
        vertices = hexagon.object.polygon.vertices + rng.uniform(-5e-4, 5e-4, (6, 2))
        truth = replace(hexagon, object=ManipulatedObject(Polygon(vertices), 0.35))
        felt = feeler.feel(probe, pairs_of(truth, probe, edge))
        model = SqueezeModel(truth)
        slide = model.slide(model.resting(edge), probe.held, probe.places[-1])
        assert felt.kind == LYING and felt.best.edges == (edge,)
        assert felt.best.x == pytest.approx(model.resting(edge).pose_at(slide)[0], abs=2e-3)


def test_places_where_friction_kept_the_object_do_not_mislead(hexagon):
    feeler = Feeler(hexagon)
    probe = probe_of(feeler, 5)
    pairs = pairs_of(hexagon, probe, 5)
    pairs[2, probe.closing] -= 0.05 * CLOSING[probe.closing]
    felt = feeler.feel(probe, pairs)
    assert felt.kind == LYING and felt.best.edges == (5,)


def test_edges_of_a_regular_polygon_feel_alike_and_are_told_so(regular):
    feeler = Feeler(regular)
    probe = probe_of(feeler, 0)
    felt = feeler.feel(probe, pairs_of(regular, probe, 0))
    assert felt.kind == LYING and felt.best.edges == (0, 1, 2, 3, 4, 5)
    assert 'alike' in felt.describe()
    assert claim(feeler, regular, felt, tracked=True).outcome == AT_GOAL
    assert claim(feeler, regular, felt, tracked=False).outcome == UNKNOWN


def test_nothing_in_the_hand_is_lost(hexagon):
    feeler = Feeler(hexagon)
    probe = probe_of(feeler, 5)
    pairs = pairs_of(hexagon, probe, 5)
    pairs[:, probe.closing] = probe.stops[probe.closing]
    felt = feeler.feel(probe, pairs)
    assert felt.kind == NOTHING
    assert claim(feeler, hexagon, felt, True).outcome == LOST


def test_another_object_is_not_taken_for_that_of_the_scenario(hexagon, regular):
    feeler = Feeler(hexagon)
    probe = probe_of(feeler, 5)
    felt = feeler.feel(probe, pairs_of(regular, probe, 0))
    assert felt.kind == UNKNOWN and 'another object' in felt.reason


def test_a_probe_that_was_interrupted_says_nothing(hexagon):
    feeler = Feeler(hexagon)
    probe = probe_of(feeler, 5)
    pairs = pairs_of(hexagon, probe, 5)
    assert feeler.feel(probe, pairs[:3]).kind == UNKNOWN
    assert feeler.feel(probe, pairs, 'stopped').reason == 'stopped'


def test_another_edge_than_the_goal_is_elsewhere(hexagon):
    feeler = Feeler(hexagon)
    probe = probe_of(feeler, 0)
    felt = feeler.feel(probe, pairs_of(hexagon, probe, 0))
    told = claim(feeler, hexagon, felt, True)
    assert (told.outcome, told.edge) == (ELSEWHERE, 0)
    at_x = replace(hexagon, goal=GoalOnEdge(0, 'ccw', felt.best.x + 0.02, 0.01))
    assert claim(feeler, at_x, felt, True).outcome == ELSEWHERE
    here = replace(hexagon, goal=GoalOnEdge(0, 'ccw', felt.best.x, 0.01))
    assert claim(feeler, here, felt, True).outcome == AT_GOAL


def test_probes_are_gentle_and_inside_of_the_limits(hexagon):
    feeler = Feeler(hexagon)
    for held in (LEFT, RIGHT):
        probe = probe_of(feeler, 5, held, 1.2 if held == LEFT else 1.9)
        low, high = feeler.model.world.limits[held]
        assert WEAKEST <= probe.torque <= STRONGEST
        assert (np.diff(probe.places) * CLOSING[held] > 0.0).all()
        assert low < probe.places.min() and probe.places.max() < high
    assert nearest_resting(feeler.hypotheses, np.array([0.0, 0.05, 0.7])) == -1
