"""The torque interval of four contacts against linear programming and against OSQP; loads; friction-tilted rows."""

import numpy as np
import osqp
import pytest
import scipy.sparse as sp
from problems import ASYMMETRIC, worlds
from scipy.optimize import linprog

from wholearm_ros.kernels import geometry
from wholearm_ros.kernels.statics import (
    clip_interval,
    equilibrium_forces,
    load_at,
    tilt_rows,
    torque_interval,
)
from wholearm_ros.mechanics.contacts import contact_rows, gap_table
from wholearm_ros.mechanics.world import build_world

TIGHT = {
    'eps_abs': 1e-11,
    'eps_rel': 1e-11,
    'eps_prim_inf': 1e-10,
    'max_iter': 50_000,
    'polishing': True,
    'verbose': False,
}


def contact_sets(seed: int, count: int):
    """(rows (4, 5), load (5,), limits (2,)) of random polygons in the hand: pairs with all three bodies, the object's load
    such that some compressive forces balance it in every other case, and its weight alone in the others."""
    rng, made = np.random.default_rng(seed), 0
    for _, world, q in worlds(rng, 100 * count):
        _, codes = gap_table(world, q)
        four = rng.choice(codes, 4, replace=False)
        if {int(geometry.pair_body(c)) for c in four} != {0, 1, 2}:
            continue
        rows, _ = contact_rows(world, four, q)
        if (
            np.linalg.cond(np.delete(rows, 3, axis=1)) > 1e4
            or np.linalg.cond(np.delete(rows, 4, axis=1)) > 1e4
        ):
            continue
        load = np.empty(5)
        load_at(world.load, world.finger_weights, q, load)
        if made % 2:
            load[:3] = rows[:, :3].T @ rng.uniform(0.0, 10.0, 4)
        yield rows, load, rng.uniform(0.5, 7.0, 2)
        made += 1
        if made == count:
            return


def by_linprog(rows, load, limits, finger):
    """(τ_min, τ_max) over (f ≥ 0, |τ_T| and |τ_V| ≤ limits), or None: the problem (6) as two linear programmes."""
    column, other_column = 3 + finger, 4 - finger
    mine, other = rows[:, column], rows[:, other_column]
    a_ub = np.vstack([-mine, mine, -other, other])
    b_ub = [
        limits[finger] - load[column],
        limits[finger] + load[column],
        limits[1 - finger] - load[other_column],
        limits[1 - finger] + load[other_column],
    ]
    ends = []
    for sign in (1.0, -1.0):
        answer = linprog(
            -sign * mine,
            A_ub=a_ub,
            b_ub=b_ub,
            A_eq=rows[:, :3].T,
            b_eq=load[:3],
            bounds=(0, None),
            method='highs',
        )
        if answer.status != 0:
            return None
        ends.append(load[column] - mine @ answer.x)
    return ends


def by_osqp(rows, load, limits, finger):
    """The same by OSQP at tight tolerance, with a ridge that moves the ends by less than 1e-7."""
    column = 3 + finger
    a = sp.csc_matrix(np.vstack([rows[:, :3].T, rows[:, 3:].T, np.eye(4)]))
    low = np.concatenate([load[:3], load[3:] - limits, np.zeros(4)])
    high = np.concatenate([load[:3], load[3:] + limits, np.full(4, np.inf)])
    ends = []
    for sign in (1.0, -1.0):
        solver = osqp.OSQP()
        solver.setup(
            sp.csc_matrix(1e-10 * np.eye(4)), -sign * rows[:, column], a, low, high, **TIGHT
        )
        answer = solver.solve(raise_error=False)
        if answer.info.status != 'solved':
            return None
        ends.append(load[column] - rows[:, column] @ answer.x)
    return ends


@pytest.mark.parametrize('finger', [0, 1])
def test_the_interval_is_what_linear_programming_finds(finger):
    """150 random contact sets for either torque finger: both empty, or both ends equal to 1e-7 of their size."""
    full = empty = 0
    for rows, load, limits in contact_sets(11, 150):
        low, high, _ = torque_interval(rows, load, limits, finger, np.empty((4, 2)))
        expected = by_linprog(rows, load, limits, finger)
        if abs(high - low) < 1e-6:
            continue  # on the verge of empty the two solvers' tolerances decide
        assert (expected is None) == (low > high)
        if expected is not None:
            np.testing.assert_allclose([low, high], expected, atol=1e-7)
            full += 1
        else:
            empty += 1
    assert full > 80 and empty > 30


@pytest.mark.parametrize('finger', [0, 1])
def test_the_interval_is_what_osqp_finds_at_tight_tolerance(finger):
    """100 random contact sets for either torque finger, to 1e-5 N m where OSQP comes to a solution."""
    compared = 0
    for rows, load, limits in contact_sets(12, 100):
        low, high, _ = torque_interval(rows, load, limits, finger, np.empty((4, 2)))
        expected = by_osqp(rows, load, limits, finger)
        if high - low > 1e-6 and expected is not None:
            np.testing.assert_allclose([low, high], expected, atol=1e-5)
            compared += 1
        elif high - low < -1e-3:
            assert expected is None
    assert compared > 20


def test_forces_balance_the_object_and_the_torque_finger_for_every_torque():
    """[G_n; −J_nTᵀ] f = [−g_O; g_T − τ_T], eq. (4), at any τ_T."""
    for rows, load, _ in contact_sets(13, 50):
        for column in (3, 4):
            forces = np.empty((4, 2))
            equilibrium_forces(rows, load, column - 3, forces)
            for torque in (-3.0, 0.0, 2.0):
                f = forces[:, 0] + forces[:, 1] * torque
                scale = 1.0 + np.abs(f).max()
                np.testing.assert_allclose(rows[:, :3].T @ f, load[:3], atol=1e-10 * scale)
                assert rows[:, column] @ f == pytest.approx(
                    load[column] - torque, abs=1e-10 * scale
                )


def test_dependent_contacts_have_no_interval():
    rows = np.ones((4, 5))
    low, high, ratio = torque_interval(rows, np.zeros(5), np.ones(2), 1, np.empty((4, 2)))
    assert low > high and ratio < 1e-9


@pytest.mark.parametrize(
    'a, b, expected',
    [
        (1.0, 2.0, (-0.5, 3.0)),
        (1.0, -2.0, (-2.0, 0.5)),
        (1.0, 0.0, (-2.0, 3.0)),
        (-1.0, 0.0, (1.0, -1.0)),
        (8.0, 2.0, (-2.0, 3.0)),
    ],
)
def test_clipping_keeps_where_a_plus_b_tau_is_not_negative(a, b, expected):
    assert clip_interval(-2.0, 3.0, a, b) == expected


def test_the_load_holds_a_level_finger_by_half_its_weight_and_a_standing_one_by_nothing():
    world, out = build_world(ASYMMETRIC), np.empty(5)
    load_at(world.load, world.finger_weights, np.array([0.0, 0.0, 0.0, 0.0, np.pi / 2]), out)
    finger, g = ASYMMETRIC.hand.left, ASYMMETRIC.gravity.in_plane
    np.testing.assert_allclose(
        out,
        [0.0, ASYMMETRIC.object.mass * g, 0.0, finger.mass * g * finger.shape.length / 2, 0.0],
        atol=1e-15,
    )


def test_friction_takes_power_out_of_sliding_and_none_when_nothing_slides():
    """Tilted rows: along q̇ a unit force does the normal's work less μ |slip|."""
    rng = np.random.default_rng(14)
    for _ in range(100):
        rows, slides, rate = rng.normal(size=(4, 5)), rng.normal(size=(4, 5)), rng.normal(size=5)
        tilted = np.empty((4, 5))
        tilt_rows(rows, slides, rate, 0.3, tilted)
        np.testing.assert_allclose(
            tilted @ rate, rows @ rate - 0.3 * np.abs(slides @ rate), atol=1e-12
        )
        tilt_rows(rows, slides, np.zeros(5), 0.3, tilted)
        np.testing.assert_array_equal(tilted, rows)
