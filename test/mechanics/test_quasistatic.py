"""Equations (1) to (5): virtual work, equilibrium, the energy balance of a quasi-static motion, scaling, conditions of II-C."""

import numpy as np
import pytest
from problems import ASYMMETRIC, FLAT_PALMS, with_masses

from wholearm_ros.mechanics.contacts import contact_rows, pair_from_name, pair_name
from wholearm_ros.mechanics.mirror import mirror_configurations, mirror_contacts
from wholearm_ros.mechanics.quasistatic import build_quasistatics
from wholearm_ros.mechanics.torque_range import build_torque_range, solve_torque_range
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.planning.routes import SearchOptions, plan


def configurations(scenario, every: int = 4):
    """(world, pairs, q) along the quasi-static legs of the best route."""
    world = build_world(scenario)
    for leg in plan(scenario, SearchOptions()).legs:
        if leg.mode == 'quasi_static':
            pairs = tuple(pair_from_name(c) for c in leg.contacts)
            for q in leg.configurations[::every]:
                yield world, pairs, q


CASES = [
    case
    for name in ('asymmetric_hexagon', 'regular_hexagon', 'heptagon', 'tall')
    for case in configurations(FLAT_PALMS[name])
]
SIDES = pytest.mark.parametrize('side', [0, 1], ids=['left_torque', 'right_torque'])


def ranges(side):
    """(model, range) of every case, with that finger torque-controlled; those that are not empty."""
    for world, pairs, q in CASES:
        model = build_quasistatics(world, pairs, q)
        found = solve_torque_range(build_torque_range(model, side, world.torque_limits))
        if not found.empty:
            yield model, found


def test_contact_forces_do_no_net_work_on_object_and_fingers():
    """Virtual work: along any q̇ that keeps the contacts closed, f_nᵀ [G_nᵀ, −J_n] q̇ = 0 for whatever forces f_n."""
    rng, checked = np.random.default_rng(50), 0
    for world, pairs, q in CASES:
        model = build_quasistatics(world, pairs, q)
        for side in range(2):
            if not model.velocity_is_unique(side):
                continue
            rate = model.velocities(side, 1.0)
            f = rng.uniform(0.0, 10.0, 4)
            on_object, from_fingers = (model.G_n @ f) @ rate[:3], (model.J_n.T @ f) @ rate[3:]
            assert on_object == pytest.approx(from_fingers, abs=1e-9 * (1.0 + np.abs(rate).max()))
            checked += 1
    assert checked > 30


@SIDES
def test_motor_power_is_the_rate_at_which_potential_energy_rises(side):
    """τᵀθ̇ = d/dt (m g y + Σ m_f g L/2 sin θ) at any torque of the range: equilibrium makes the motion reversible."""
    checked = 0
    for model, found in ranges(side):
        if not model.velocity_is_unique(1 - side):
            continue
        rate = model.velocities(1 - side, 1.0)
        rising = -model.g_O @ rate[:3] + model.g_h @ rate[3:]
        for f in (found.forces_low, found.forces_high):
            assert model.joint_torques(f) @ rate[3:] == pytest.approx(
                rising, abs=1e-8 * (1.0 + np.abs(rate).max() * np.abs(f).max())
            )
        checked += 1
    assert checked > 10


@SIDES
def test_equilibrium_holds_to_1e_9_at_both_ends_of_the_range_and_between(side):
    """Eq. (2) for the object and both fingers, eq. (5), both motors' limits."""
    checked = 0
    for model, found in ranges(side):
        assert found.equilibrium_error() <= 1e-9 * (
            1.0 + np.abs(found.forces_high).max() + np.abs(found.forces_low).max()
        )
        for u in (0.0, 0.3, 1.0):
            f = (1 - u) * found.forces_low + u * found.forces_high
            tau = model.joint_torques(f)
            assert model.residual(f, tau) <= 1e-9 * (1.0 + np.abs(f).max())
            assert tau[side] == pytest.approx((1 - u) * found.low + u * found.high, abs=1e-8)
        checked += 1
    assert checked > 20


def test_velocities_keep_all_four_contacts_closed():
    """Eq. (1): [G_nᵀ, −J_n] q̇ = 0, with the velocity finger turning as asked."""
    for world, pairs, q in CASES:
        model = build_quasistatics(world, pairs, q)
        for side in range(2):
            if model.velocity_is_unique(side):
                rate = model.velocities(side, -0.7)
                assert rate[3 + side] == -0.7
                np.testing.assert_allclose(
                    model.constraint() @ rate, 0.0, atol=1e-9 * np.abs(rate).max()
                )


def test_a_motion_along_these_velocities_changes_gaps_to_second_order_only():
    """Halving the step quarters the gaps: the velocities are tangent to the contact manifold."""
    for world, pairs, q in CASES[::3]:
        model = build_quasistatics(world, pairs, q)
        if model.velocity_is_unique(0):
            rate = model.velocities(0, 1.0)
            rate /= np.abs(rate).max()
            large, small = (
                np.abs(contact_rows(world, pairs, q + h * rate)[1]).max() for h in (1e-3, 5e-4)
            )
            assert small <= large / 3.0 + 1e-10


@SIDES
def test_everything_twice_as_heavy_needs_twice_the_torque(side):
    """Object and fingers of double mass and motors of double strength: both ends of the range double."""
    for world, pairs, q in CASES:
        heavy = build_world(with_masses(ASYMMETRIC, 2.0))
        one = solve_torque_range(
            build_torque_range(build_quasistatics(world, pairs, q), side, world.torque_limits)
        )
        model = build_quasistatics(world, pairs, q)
        double = type(model)(model.G_n, model.J_n, 2.0 * model.g_O, 2.0 * model.g_h, model.scale)
        two = solve_torque_range(build_torque_range(double, side, 2.0 * world.torque_limits))
        assert one.empty == two.empty
        if not one.empty:
            np.testing.assert_allclose(
                [two.low, two.high], [2.0 * one.low, 2.0 * one.high], atol=1e-8
            )
    np.testing.assert_allclose(heavy.load, 2.0 * build_world(ASYMMETRIC).load)
    np.testing.assert_allclose(heavy.finger_weights, 2.0 * build_world(ASYMMETRIC).finger_weights)


@SIDES
@pytest.mark.parametrize('name', ['asymmetric_hexagon', 'heptagon'])
def test_the_mirrored_hand_needs_the_mirrored_torque(name, side):
    """Left and right change places, torques their sign: the range [a, b] becomes [−b, −a]."""
    scenario = FLAT_PALMS[name]
    other = build_world(scenario.mirrored())
    for world, pairs, q in configurations(scenario):
        image = tuple(
            pair_from_name(n) for n in mirror_contacts(tuple(map(pair_name, pairs)), scenario)
        )
        one = solve_torque_range(
            build_torque_range(build_quasistatics(world, pairs, q), side, world.torque_limits)
        )
        two = solve_torque_range(
            build_torque_range(
                build_quasistatics(other, image, mirror_configurations(q)),
                1 - side,
                other.torque_limits,
            )
        )
        assert one.empty == two.empty
        if not one.empty:
            np.testing.assert_allclose([two.low, two.high], [-one.high, -one.low], atol=1e-8)


def test_dependent_contacts_do_not_determine_the_motion():
    """Condition 1 of II-C: the same contact twice makes [G_nᵀ, −J_nT] singular."""
    world, pairs, q = CASES[1]
    assert build_quasistatics(world, pairs, q).velocity_is_unique(0)
    assert not build_quasistatics(
        world, (pairs[0], pairs[1], pairs[2], pairs[2]), q
    ).velocity_is_unique(0)


def test_a_finger_that_does_not_touch_drives_nothing():
    """Condition 2 of II-C: J_nV of a finger without contact is zero."""
    world, pairs, q = CASES[0]
    codes = tuple(
        pair_from_name(c) for c in ('v0:palm.e0', 'v1:palm.e0', 'v2:right.inner', 'v3:right.inner')
    )
    assert not build_quasistatics(world, codes, q).velocity_is_unique(0)
