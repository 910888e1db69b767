"""Perturbations: inside their bounds, convex, scaled by the level, the same for the same seed; honest starts."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wholearm_ros.mechanics.contacts import deepest_penetration, gap_table, start_configuration
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.convex import turns
from wholearm_ros.model.hand_errors import MAX_JOINT_FRICTION, HandErrors
from wholearm_ros.model.perturbation import NOMINAL, Perturbation, draw_perturbation
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario import ManipulatedObject, StartAtPose
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.rollout.initial_state import perturbed_start

SCENARIO = load_scenario(Path(__file__).parents[2] / 'config' / 'asymmetric_hexagon.yaml')


@given(seed=st.integers(0, 10**6), level=st.floats(0.01, 3.0))
@settings(max_examples=100, deadline=None)
def test_draws_are_within_their_bounds_and_convex(seed, level):
    p = draw_perturbation(np.random.default_rng(seed), level, SCENARIO)
    assert (
        abs(p.mass_factor - 1.0) <= 0.05 * level
        and np.abs(p.torque_factors - 1.0).max() <= 0.03 * level
    )
    assert np.abs(p.vertex_offsets).max() <= 0.0005 * level and 0.0 <= p.friction <= 0.05 * level
    assert 0.0 <= p.actuation_delay <= 0.003 * level and p.encoder_noise == pytest.approx(
        2e-4 * level
    )
    truth = p.applied(SCENARIO)
    assert (
        turns(truth.object.polygon.vertices).min() > 0.0
        and truth.object.mass == SCENARIO.object.mass * p.mass_factor
    )


def test_the_same_seed_draws_the_same_and_level_zero_is_nominal():
    a, b = (
        draw_perturbation(np.random.default_rng([4, 2]), 1.0, SCENARIO).to_dict() for _ in range(2)
    )
    assert a == b and a != draw_perturbation(np.random.default_rng([4, 3]), 1.0, SCENARIO).to_dict()
    assert draw_perturbation(np.random.default_rng(0), 0.0, SCENARIO) is NOMINAL


def test_errors_of_the_hand_are_drawn_beside_the_others_and_change_none_of_them():
    rng = np.random.default_rng
    alone, both = (
        draw_perturbation(rng(5), 1.0, SCENARIO, level).to_dict() for level in (0.0, 2.0)
    )
    hand = both.pop('hand')
    assert alone.pop('hand') == HandErrors().to_dict() and alone == both
    assert 0.0 < max(hand['joint_friction']) <= 2 * MAX_JOINT_FRICTION
    drawn = draw_perturbation(rng(5), 0.0, SCENARIO, 2.0)
    assert drawn.to_dict()['hand'] == hand and drawn.mass_factor == 1.0
    assert Perturbation.from_dict(drawn.to_dict()).to_dict() == drawn.to_dict()
    assert NOMINAL.applied(SCENARIO).object.mass == SCENARIO.object.mass


@pytest.mark.parametrize('corners, level', [(40, 1.4), (64, 20.0)])
def test_a_polygon_with_many_corners_is_perturbed_as_far_as_it_stays_convex(corners, level):
    """With so many corners hardly any draw leaves all of them: it must not end in an error, nor in no perturbation."""
    angles = 2 * np.pi * np.arange(corners) / corners
    almost_round = Polygon(0.055 * np.stack([np.cos(angles), np.sin(angles)], axis=1))
    scenario = replace(SCENARIO, object=ManipulatedObject(almost_round, 0.1))
    drawn = draw_perturbation(np.random.default_rng(0), level, scenario)
    assert turns(drawn.applied(scenario).object.polygon.vertices).min() > 0.0
    assert 1e-6 < np.abs(drawn.vertex_offsets).max() <= level * 0.0005


@pytest.mark.parametrize('seed', range(8))
@pytest.mark.parametrize('at_pose', [False, True])
def test_the_true_object_is_set_down_and_grasped_without_penetration(seed, at_pose):
    told = SCENARIO
    if at_pose:
        q = start_configuration(told)
        told = replace(told, start=StartAtPose(q[:3], q[3:]))
    truth = draw_perturbation(np.random.default_rng(seed), 2.0, told).applied(told)
    world, q = build_world(truth), perturbed_start(told, truth)
    gaps, codes = gap_table(world, q)
    assert deepest_penetration(world, q)[0] < 1e-6
    n, p = len(world.obj), len(world.palm) - 1
    assert gaps[: n * p].min() < 1e-6  # it lies on the palm
    q_open = q + [0, 0, 0, -1e-4, 1e-4]  # closing either finger a little more would penetrate
    assert deepest_penetration(world, q_open)[0] > 1e-6
