"""Feeling: laws of squeezes, and verdicts on pairs whose origin is known."""

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from problems import HANDS

from wholearm_ros.estimation.claim import claim
from wholearm_ros.estimation.feel import Feeler
from wholearm_ros.estimation.probe_plan import CAUTIONS, nearest_resting, plan_probe
from wholearm_ros.estimation.squeeze import SqueezeModel
from wholearm_ros.mechanics.contacts import gap_table, start_configuration
from wholearm_ros.model.hand import CLOSING, LEFT, RIGHT
from wholearm_ros.model.outcomes import AT_GOAL, ELSEWHERE, LOST, LYING, NOTHING, UNKNOWN
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario import GoalOnEdge, ManipulatedObject, StartOnEdge
from wholearm_ros.model.scenario_file import load_scenario

CONFIG = Path(__file__).parents[2] / 'config'


@pytest.fixture(scope='module')
def hexagon():
    return load_scenario(CONFIG / 'asymmetric_hexagon.yaml')


@pytest.fixture(scope='module')
def regular():
    return load_scenario(CONFIG / 'regular_hexagon.yaml')


def probe_of(feeler, edge, held=LEFT, ends=(1.2, 1.9)):
    place = [h.edge for h in feeler.hypotheses].index(edge)
    return plan_probe(feeler.model, feeler.hypotheses, place, held, np.array(ends))


def is_gentle(probe):
    return any(
        probe.acceleration == caution.acceleration
        and caution.weakest <= probe.torque <= caution.strongest
        for caution in CAUTIONS
    )


def pairs_of(truth, probe, edge):
    """What a frictionless hand would measure with the object of `truth` on an edge."""
    model = SqueezeModel(truth)
    thetas = probe.places
    _, angles = model.squeeze(model.resting(edge), probe.held, thetas)
    pairs = np.empty((len(thetas), 2))
    pairs[:, probe.held], pairs[:, probe.closing] = thetas, angles
    return pairs


@pytest.mark.parametrize('hand', HANDS)
def test_squeezed_object_touches_both_fingers_and_nothing_penetrates(hexagon, hand):
    model = SqueezeModel(replace(hexagon, hand=HANDS[hand]))
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


def test_places_tell_edges_apart_that_feel_nearly_alike(hexagon):
    outline = 1e-3 * np.array([[0, 0], [2, -72], [85, -82], [110, -21], [57, 26]])
    pentagon = replace(hexagon, object=ManipulatedObject(Polygon(outline), 0.379))
    feeler = Feeler(pentagon)
    for edge in (1, 3):
        for held in (LEFT, RIGHT):
            probe = probe_of(feeler, edge, held, (1.07, 1.86))
            felt = feeler.feel(probe, pairs_of(pentagon, probe, edge))
            assert felt.best.edges == (edge,) and felt.best.probability > 0.95


def test_an_object_that_friction_would_tip_is_led_on_between_both_fingers(hexagon):
    outline = [[0, 0], [-27, 41], [-91, 56], [-123, 29], [-115, -27], [-96, -64], [-37, -64]]
    heptagon = replace(hexagon, object=ManipulatedObject(Polygon(1e-3 * np.array(outline)), 0.39))
    feeler, ends = Feeler(heptagon), np.array([1.43, 2.119])
    for held in (LEFT, RIGHT):
        probe = probe_of(feeler, 4, held, ends)
        assert probe.held == LEFT and not probe.opened.any()
        assert (CLOSING[LEFT] * (probe.places - ends[LEFT]) > -1e-9).all()


@pytest.mark.parametrize(
    ('outline', 'mass', 'edge', 'held', 'ends'),
    [
        # One of its edges hardly carries it: wherever that is squeezed, it would tip.
        (
            [[0, 0], [17, -36], [63, -56], [103, -45], [117, -12], [100, 39], [70, 66], [37, 47]],
            0.241, 1, RIGHT, (1.335, 2.229),
        ),
        # At the end of the palm, where the other finger must give way twice as fast.
        (
            [[0, 0], [-48, -33], [-64, -88], [-36, -122], [16, -116], [56, -85], [41, -32]],
            0.382, 1, LEFT, (2.546, 2.695),
        ),
    ],
)  # fmt: skip
@pytest.mark.parametrize('again', [False, True])
def test_what_may_tip_otherwise_is_felt_gently(hexagon, outline, mass, edge, held, ends, again):
    shape = ManipulatedObject(Polygon(1e-3 * np.array(outline)), mass)
    feeler = Feeler(replace(hexagon, object=shape))
    place = [h.edge for h in feeler.hypotheses].index(edge)
    probe = plan_probe(feeler.model, feeler.hypotheses, place, held, np.array(ends), again=again)
    assert len(probe.places) > 1 and probe.acceleration < 3.0
    felt = feeler.feel(probe, pairs_of(feeler.model.scenario, probe, edge))
    assert felt.best.edges == (edge,) and felt.best.probability > 0.9


@pytest.mark.parametrize('again', [False, True])
@pytest.mark.parametrize('x', [-0.0465, -0.03, 0.0, 0.03])
@pytest.mark.parametrize(
    ('outline', 'mass', 'edge'),
    [
        (None, 0.353, 2),  # the hexagon's own, its centroid 12 mm inside of one end
        # An octagon with its centroid 3 mm inside of one end.
        (
            [[0, 0], [-32, -39], [-15, -76], [19, -105], [68, -99], [105, -52], [68, -11], [43, 4]],
            0.21, 1,
        ),
    ],
)  # fmt: skip
def test_an_object_near_tipping_is_felt_wherever_it_lies(hexagon, outline, mass, edge, x, again):
    polygon = Polygon(1e-3 * np.array(outline)) if outline else hexagon.object.polygon
    there = replace(hexagon, object=ManipulatedObject(polygon, mass), start=StartOnEdge(edge, x))
    feeler, ends = Feeler(there), start_configuration(there)[3:]
    place = [h.edge for h in feeler.hypotheses].index(edge)
    for held in (LEFT, RIGHT):
        probe = plan_probe(feeler.model, feeler.hypotheses, place, held, ends, again=again)
        felt = feeler.feel(probe, pairs_of(there, probe, edge))
        assert felt.kind == LYING and felt.best.edges == (edge,)


def test_where_only_one_place_is_safe_nothing_is_told_and_why_is_said(hexagon):
    feeler = Feeler(hexagon)
    probe = probe_of(feeler, 5)
    probe = replace(probe, places=probe.places[-1:])
    felt = feeler.feel(probe, pairs_of(hexagon, probe, 5))
    assert felt.kind == UNKNOWN and 'tip' in felt.reason


@pytest.mark.parametrize('again', [False, True])
@pytest.mark.parametrize('expected', [-1, 0])
def test_a_probe_is_planned_wherever_the_fingers_stand(hexagon, expected, again):
    """Also where they have no room: at their end stops."""
    feeler = Feeler(hexagon)
    limits = feeler.model.world.limits
    for ends in itertools.product(*(np.linspace(*row, 3) for row in limits)):
        for held in (LEFT, RIGHT):
            probe = plan_probe(
                feeler.model, feeler.hypotheses, expected, held, np.array(ends), again=again
            )
            low, high = limits[probe.held]
            assert ((probe.places > low) & (probe.places < high)).all()
            assert is_gentle(probe)


def test_probes_are_gentle_and_inside_of_the_limits(hexagon):
    feeler = Feeler(hexagon)
    for held in (LEFT, RIGHT):
        probe = probe_of(feeler, 5, held)
        low, high = feeler.model.world.limits[held]
        assert is_gentle(probe)
        assert (np.diff(probe.places) * CLOSING[held] > 0.0).all()
        assert low < probe.places.min() and probe.places.max() < high
    assert nearest_resting(feeler.hypotheses, np.array([0.0, 0.05, 0.7])) == -1
