"""Contacts of the MuJoCo hand: exact normals and gaps, shallow contacts, friction that sticks, forces of the LCP's equilibrium."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip('mujoco')

from wholearm_ros.errors import ScenarioError
from wholearm_ros.kernels import geometry
from wholearm_ros.mechanics.contacts import (
    close_finger,
    contact_rows,
    gap_table,
    pose_on_palm,
    start_configuration,
)
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.hand import CLOSING, SIDES, Palm
from wholearm_ros.model.perturbation import Perturbation
from wholearm_ros.model.scenario import StartOnEdge
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.simulation.mujoco_hand import PHYSICS_RATE, MuJoCoHand

SCENARIO = load_scenario(Path(__file__).parents[2] / 'config/asymmetric_hexagon.yaml')
WORLD = build_world(SCENARIO)
Q = start_configuration(SCENARIO)
G = SCENARIO.gravity.in_plane


def pressed(rng: np.random.Generator, side: int, depth: float):
    """q (5,): an object at random in the air, one finger closed on it and `depth` [m] further."""
    while True:
        pose = [rng.uniform(-0.05, 0.05), rng.uniform(0.09, 0.13), rng.uniform(-np.pi, np.pi)]
        q = np.array([*pose, 2.8, 0.3])
        try:
            q[3 + side] = close_finger(WORLD, q[:3], side)
        except ScenarioError:
            continue
        (lever,), _ = contact_rows(WORLD, [deepest(q)[1]], q)
        q[3 + side] += CLOSING[side] * depth / abs(lever[3 + side])
        return q


def deepest(q):
    """(gap [m], code) of the pair that penetrates most."""
    gaps, codes = gap_table(WORLD, q)
    return float(gaps.min()), int(codes[gaps.argmin()])


@pytest.mark.parametrize('side', [0, 1])
@pytest.mark.parametrize('depth', [1e-7, 1e-5, 1e-4])
def test_normals_and_gaps_are_those_of_the_exact_polygons(side, depth):
    """Vertex on edge and edge on corner, faces at every angle to each other; spheres of 1 µm stand out by that."""
    hand, rng, kinds = MuJoCoHand(SCENARIO), np.random.default_rng(7), set()
    for _ in range(40):
        q = pressed(rng, side, depth)
        gap, code = deepest(q)
        hand.reset(q)
        found = min(hand.contacts(), key=lambda c: c.gap)
        px, py, nx, ny, *_ = geometry.contact(WORLD, code, q)
        assert found.other == SIDES[side]
        np.testing.assert_allclose(found.normal, [nx, ny], atol=3e-5)
        np.testing.assert_allclose(found.point, [px, py], atol=2e-4)
        assert found.gap == pytest.approx(gap, abs=1.1e-6)
        kinds.add(int(geometry.pair_kind(code)))
    assert kinds == {geometry.VERTEX_EDGE, geometry.EDGE_CORNER}


def test_contacts_stay_shallow_under_load():
    """Both fingers press the object with 2 N m: less than 1 µm deep at rest."""
    hand = MuJoCoHand(SCENARIO)
    hand.reset(Q)
    moments = np.array(
        [f.mass * G * f.shape.length / 2 for f in (SCENARIO.hand.left, SCENARIO.hand.right)]
    )
    for k in range(1000):
        hold = 60.0 * (Q[3] - hand.joints()[0][0]) - 1.5 * hand.joints()[1][0]
        hand.step(moments * np.cos(hand.joints()[0]) + [hold, 2.0 * min(1.0, k / 500)])
    assert min(c.gap for c in hand.contacts()) > -1e-6


def test_an_impact_penetrates_by_one_step_of_its_speed_and_does_not_bounce():
    hand = MuJoCoHand(SCENARIO)
    hand.reset(np.array([-0.02, Q[1] + 0.03, 0.0, 3.0, 0.1]))
    speed, rises = np.sqrt(2 * G * 0.03), []
    for _ in range(300):
        hand.step(None)
        rises.append(hand.object_velocity()[1])
    assert hand.largest_penetration < 1.05 * speed / PHYSICS_RATE
    assert max(rises) < 0.03 * speed


@pytest.mark.parametrize('share, sticks', [(0.8, True), (1.2, False)])
def test_friction_holds_an_object_below_its_cone_and_not_above(share, sticks):
    slope = np.arctan(share * 0.1)
    palm = Palm([[-0.15, 0.15 * np.tan(slope)], [0.15, -0.15 * np.tan(slope)]])
    scenario = replace(SCENARIO, palm=palm, start=StartOnEdge(0, 0.0))
    pose = pose_on_palm(build_world(scenario), 0.0, -slope)
    hand = MuJoCoHand(scenario, perturbation=Perturbation(friction=0.1))
    hand.reset(np.array([*pose, 3.0, 0.1]))
    for _ in range(500):
        hand.step(None)
    slid = np.linalg.norm(hand.object_pose()[:2] - pose[:2])
    assert (
        slid < 1e-5
        if sticks
        else slid == pytest.approx(G * (np.sin(slope) - 0.1 * np.cos(slope)) / 8, rel=0.03)
    )
