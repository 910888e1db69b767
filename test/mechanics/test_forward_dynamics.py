"""Our time stepping against PyBullet, an engine of other authors, on motions with all contacts and with none."""

import numpy as np
import pytest
from problems import ASYMMETRIC, HEPTAGON, OF_SHAPES, REGULAR

from wholearm_ros.mechanics.contacts import start_configuration
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.weight import bearing_torques
from wholearm_ros.simulation.factory import make_hand

pytest.importorskip('pybullet')
RATE = 1000.0


def motion(backend, scenario, drive, seconds):
    """(m, 5) true pose and joint angles every step under drive(t, angles, velocities) → efforts (2,)."""
    hand = make_hand(backend, scenario, rate=RATE)
    try:
        hand.reset(start_configuration(scenario))
        rows = []
        for _ in range(int(seconds * RATE)):
            angles, velocities = hand.joints()
            hand.step(drive(hand.time, angles, velocities))
            rows.append(np.concatenate([hand.object_pose(), hand.joints()[0]]))
        return np.array(rows)
    finally:
        hand.disconnect()


def sweep(scenario, side, speed, torque):
    """One finger turns at `speed` after a smooth start, the other pushes with a torque: the object slides between them."""
    world, begin = build_world(scenario), start_configuration(scenario)[3:]

    def drive(t, angles, velocities):
        u = min(t / 0.1, 1.0)
        rate = speed * u * u * (3.0 - 2.0 * u)
        way = speed * (u**3 - 0.5 * u**4) * 0.1 + speed * max(t - 0.1, 0.0)
        efforts = bearing_torques(world.finger_weights, angles)
        efforts[side] += 60.0 * (begin[side] + way - angles[side]) + 1.5 * (rate - velocities[side])
        efforts[1 - side] += torque * min(t / 0.05, 1.0)
        return efforts

    return drive


@pytest.mark.parametrize(
    'scenario, side, speed, torque',
    [
        (ASYMMETRIC, 0, -0.6, 0.15),
        (ASYMMETRIC, 1, 0.6, -0.15),
        (REGULAR, 0, -0.6, 0.1),
        (HEPTAGON, 0, -0.4, 0.1),
        (OF_SHAPES['tapered_fingers'], 0, -0.6, 0.15),
        (OF_SHAPES['hooked_fingers'], 0, -0.6, 0.15),
        (OF_SHAPES['hooked_fingers'], 1, 0.6, -0.15),
        (OF_SHAPES['unequal_fingers'], 1, 0.6, -0.15),
    ],
    ids=[
        'asymmetric_to_the_right',
        'asymmetric_to_the_left',
        'regular',
        'heptagon',
        'tapered',
        'hooked_to_the_right',
        'hooked_to_the_left',
        'unequal',
    ],
)
def test_a_slide_between_the_fingers_is_what_pybullet_makes_of_it(scenario, side, speed, torque):
    """0.4 s, the object moves by more than 1 cm: poses differ by at most 0.1 mm and 1 mrad all the way."""
    ours, theirs = (
        motion(backend, scenario, sweep(scenario, side, speed, torque), 0.4)
        for backend in ('planar', 'pybullet')
    )
    assert np.abs(theirs[-1, 0] - theirs[0, 0]) > 0.01
    difference = np.abs(ours - theirs)
    assert difference[:, :2].max() < 1e-4 and difference[:, 2:].max() < 1e-3


def test_an_opened_hand_lets_the_object_stand_in_both():
    world = build_world(ASYMMETRIC)

    def open_up(t, angles, velocities):
        return bearing_torques(world.finger_weights, angles) + [0.3, -0.3] - 0.1 * velocities

    ours, theirs = (motion(backend, ASYMMETRIC, open_up, 0.3) for backend in ('planar', 'pybullet'))
    np.testing.assert_allclose(
        ours[:, :3], np.tile(start_configuration(ASYMMETRIC)[:3], (300, 1)), atol=1e-6
    )
    np.testing.assert_allclose(ours[:, 3:], theirs[:, 3:], atol=2e-3)
    np.testing.assert_allclose(ours[:, :3], theirs[:, :3], atol=1e-4)
