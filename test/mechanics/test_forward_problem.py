"""Forward dynamics as a complementarity problem: equilibria stand still, more torque than τ_max breaks a contact."""

import numpy as np
import pytest
from problems import ASYMMETRIC, REGULAR

from wholearm_ros.mechanics.contacts import contact_rows, pair_from_name, pair_name
from wholearm_ros.mechanics.forward_dynamics import (
    Inputs,
    build_forward_dynamics,
    solve_forward_dynamics,
)
from wholearm_ros.mechanics.quasistatic import build_quasistatics
from wholearm_ros.mechanics.torque_range import build_torque_range, solve_torque_range
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.hand import LEFT, RIGHT
from wholearm_ros.planning.routes import plan

REST = np.zeros(5)


def sliding(scenario):
    """(world, pairs, q) along the legs with two palm contacts."""
    world = build_world(scenario)
    for leg in plan(scenario).legs:
        if leg.mode == 'quasi_static' and sum('palm' in c for c in leg.contacts) == 2:
            for q in leg.configurations[1:-1:4]:
                yield world, tuple(pair_from_name(c) for c in leg.contacts), q


CASES = [*sliding(ASYMMETRIC), *sliding(REGULAR)]


@pytest.mark.parametrize('finger', [LEFT, RIGHT])
def test_inside_the_torque_range_nothing_accelerates_and_forces_are_those_of_equilibrium(finger):
    standing = 0
    for world, pairs, q in CASES:
        model = build_quasistatics(world, pairs, q)
        found = solve_torque_range(build_torque_range(model, finger, world.torque_limits))
        if found.empty or found.width < 1e-3:
            continue
        torque = 0.5 * (found.low + found.high)
        answer = solve_forward_dynamics(
            build_forward_dynamics(world, pairs, q, REST, Inputs(finger, torque))
        )
        np.testing.assert_allclose(answer.accelerations, 0.0, atol=1e-6)
        np.testing.assert_allclose(
            answer.forces, 0.5 * (found.forces_low + found.forces_high), atol=1e-6
        )
        assert answer.breaking() == ()
        standing += 1
    assert standing > 5


def test_more_than_the_largest_torque_breaks_a_contact():
    """III-B.2: τ_max + 1 N m of the right finger, where the range ends above by a contact force and not by a motor."""
    broken = 0
    for world, pairs, q in CASES:
        found = solve_torque_range(
            build_torque_range(build_quasistatics(world, pairs, q), RIGHT, world.torque_limits)
        )
        if found.empty or found.forces_high.min() > 1e-6:
            continue
        torque = found.high + 1.0
        answer = solve_forward_dynamics(
            build_forward_dynamics(world, pairs, q, REST, Inputs(RIGHT, torque))
        )
        assert answer.breaking() and answer.residual() <= 1e-9 * max(
            1.0, np.abs(answer.problem.b).max()
        )
        broken += 1
    assert broken > 5


def test_at_the_end_of_the_slide_the_extra_torque_lifts_the_right_palm_contact():
    """The paper's experiment: "the right-most contact on the environment breaks" (asymmetric hexagon)."""
    world = build_world(ASYMMETRIC)
    leg = plan(ASYMMETRIC).legs[0]
    pairs, q = tuple(pair_from_name(c) for c in leg.contacts), leg.configurations[-1]
    found = solve_torque_range(
        build_torque_range(build_quasistatics(world, pairs, q), RIGHT, world.torque_limits)
    )
    answer = solve_forward_dynamics(
        build_forward_dynamics(world, pairs, q, REST, Inputs(RIGHT, found.high + 0.5))
    )
    assert [pair_name(c) for c in answer.breaking()] == ['v1:palm.e0'] and answer.accelerations[
        2
    ] > 0.0


def test_complementarity_and_newton_hold_at_any_torque_and_velocity():
    """0 ≤ f ⟂ a_n ≥ 0; M q̈ = F + N f for object and torque finger; a_n by differences of the gap rates along the motion."""
    rng = np.random.default_rng(70)
    for world, pairs, q in CASES:
        rate, torque, finger = (
            rng.normal(size=5) * 0.1,
            rng.uniform(-3.0, 3.0),
            int(rng.integers(2)),
        )
        turning = rng.uniform(-5.0, 5.0)
        answer = solve_forward_dynamics(
            build_forward_dynamics(world, pairs, q, rate, Inputs(finger, torque, turning))
        )
        scale = max(1.0, np.abs(answer.problem.b).max())
        assert answer.residual() <= 1e-9 * scale and answer.forces.min() >= -1e-9 * scale
        rows, _ = contact_rows(world, pairs, q)
        moving = [0, 1, 2, 3 + finger]
        force = np.append(
            [0.0, -ASYMMETRIC.gravity.in_plane * world.inertias[0], 0.0],
            torque - world.bearing(q)[finger],
        )
        np.testing.assert_allclose(
            world.inertias[moving] * answer.accelerations,
            force + rows[:, moving].T @ answer.forces,
            atol=1e-9,
        )
        second = np.zeros(5)
        second[moving], second[4 - finger] = answer.accelerations, turning
        h = 1e-5
        ahead, behind = (
            contact_rows(world, pairs, q + s * h * rate)[0] @ (rate + s * h * second)
            for s in (1.0, -1.0)
        )
        np.testing.assert_allclose(
            answer.separations, (ahead - behind) / (2 * h), atol=1e-4 * scale
        )
