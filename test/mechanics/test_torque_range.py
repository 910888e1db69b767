"""Problem (6) with five and more contacts: certified, as linear programming finds it, and never less than with four of them."""

import numpy as np
import pytest
from problems import ASYMMETRIC, FLAT_PALMS, REGULAR
from scipy.optimize import linprog

from wholearm_ros.mechanics.contacts import closed_pairs, four_contact_subsets
from wholearm_ros.mechanics.quasistatic import QuasiStatics, build_quasistatics
from wholearm_ros.mechanics.torque_range import build_torque_range, solve_torque_range
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.planning.routes import SearchOptions, plan

pytestmark = pytest.mark.filterwarnings('ignore::PendingDeprecationWarning')  # of osqp's own
LIMITS = np.array([7.0, 7.0])


def five_contact_models():
    """Models at the ends of legs where five and more pairs are closed, of all problems."""
    for scenario in FLAT_PALMS.values():
        world = build_world(scenario)
        for leg in plan(scenario, SearchOptions()).legs:
            for q in leg.configurations[[0, -1]]:
                pairs = closed_pairs(world, q)
                if len(pairs) > 4:
                    yield world, pairs, q


FIVE = list(five_contact_models())
SIDES = pytest.mark.parametrize('side', [0, 1], ids=['left_torque', 'right_torque'])


def by_linprog(model, side, limits):
    ends = []
    for sign in (1.0, -1.0):
        a = np.vstack([model.J_n.T, -model.J_n.T])
        b = np.concatenate([limits - model.g_h, limits + model.g_h])
        answer = linprog(
            sign * model.J_n[:, side],
            A_ub=a,
            b_ub=b,
            A_eq=model.G_n,
            b_eq=-model.g_O,
            bounds=(0, None),
            method='highs',
        )
        if answer.status != 0:
            return None
        ends.append(model.joint_torques(answer.x)[side])
    return ends


@SIDES
def test_five_contacts_are_certified_and_as_linear_programming_finds_them(side):
    full = 0
    for world, pairs, q in FIVE:
        model = build_quasistatics(world, pairs, q)
        found, expected = (
            solve_torque_range(build_torque_range(model, side, LIMITS)),
            by_linprog(model, side, LIMITS),
        )
        assert found.empty == (expected is None)
        if expected is not None:
            full += 1
            np.testing.assert_allclose([found.low, found.high], expected, atol=1e-5)
            assert found.equilibrium_error() <= 1e-7 * (
                1.0 + np.abs([found.forces_low, found.forces_high]).max()
            )
    assert full > 10


@SIDES
def test_five_contacts_carry_every_torque_that_four_of_them_carry(side):
    """Dwell is possible: at rest at a five-contact configuration both ranges, and all between, are equilibria."""
    inside = 0
    for world, pairs, q in FIVE:
        if len(pairs) != 5:
            continue
        whole = solve_torque_range(
            build_torque_range(build_quasistatics(world, pairs, q), side, LIMITS)
        )
        for four in four_contact_subsets(pairs):
            part = solve_torque_range(
                build_torque_range(build_quasistatics(world, four, q), side, LIMITS)
            )
            if not part.empty and part.width > 1e-6:
                assert whole.low <= part.low + 1e-5 and part.high <= whole.high + 1e-5
                inside += 1
    assert inside > 10


def test_a_range_that_no_force_can_fill_is_empty():
    """Palm and fingers that can only push sideways and down do not carry a weight, with four contacts or with five."""
    for n in (4, 5):
        G_n = np.array(
            [[1.0, -1.0, 0.5, -0.5, 0.2][:n], [-0.1] * n, np.linspace(-0.05, 0.04, n) ** 2]
        )
        J_n = np.array([[0.1, 0.0], [0.0, 0.1], [0.05, 0.0], [0.0, 0.07], [0.03, 0.0]])[:n]
        model = QuasiStatics(G_n, J_n, np.array([0.0, -3.0, 0.0]), np.zeros(2), np.ones(5))
        found = solve_torque_range(build_torque_range(model, 1, LIMITS))
        assert found.empty and found.equilibrium_error() == 0.0


@SIDES
@pytest.mark.parametrize('scenario', [ASYMMETRIC, REGULAR], ids=['asymmetric', 'regular'])
def test_weaker_motors_have_a_smaller_range(scenario, side):
    world, (q, pairs) = build_world(scenario), next((q, p) for w, p, q in FIVE if len(w.obj) == 6)
    model = build_quasistatics(world, pairs, q)
    before = solve_torque_range(build_torque_range(model, side, LIMITS))
    for share in (0.5, 0.2, 0.1):
        found = solve_torque_range(build_torque_range(model, side, share * LIMITS))
        if found.empty:
            break
        assert found.low >= before.low - 1e-6 and found.high <= before.high + 1e-6
        before = found
    assert share < 0.5
