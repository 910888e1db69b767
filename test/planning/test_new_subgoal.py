"""NEW_SUBGOAL: along every arc the four contacts stay closed and nothing penetrates; where one changes, nothing jumps."""

import numpy as np
import pytest
from problems import ASYMMETRIC, FLAT_PALMS, ON_BENT_PALM, QUADRILATERAL, REGULAR, TALL

from wholearm_ros.kernels import arc_tracing, geometry
from wholearm_ros.mechanics.contacts import (
    closed_pairs,
    contact_rows,
    four_contact_subsets,
    gap_table,
)
from wholearm_ros.mechanics.quasistatic import build_quasistatics
from wholearm_ros.mechanics.torque_range import build_torque_range, solve_torque_range
from wholearm_ros.model.modes import CAGING, QUASI_STATIC
from wholearm_ros.planning.best_first_search import ArcGraph
from wholearm_ros.planning.new_subgoal import NEW_Y, REACHED, UNREACHED, new_subgoal, tangent
from wholearm_ros.planning.problem import build_problem

EXPLORED = (ASYMMETRIC, REGULAR, QUADRILATERAL, TALL, ON_BENT_PALM)
NODES = 12  # of each graph


def explored(scenario):
    """(task, node, pairs, expansion) of every expansion from the first nodes of the graph."""
    task = build_problem(scenario)
    graph, k = ArcGraph(task, 10_000), 0
    while k < min(NODES, len(graph.network.nodes)):
        graph.edges_from(k)
        k += 1
    for node in graph.network.nodes[:k]:
        for pairs in four_contact_subsets(node.pairs):
            for sign in (1, -1):
                toward = sign * tangent(task, node.configuration, pairs)
                for expansion in new_subgoal(task, node.configuration, pairs, toward):
                    yield task, node, pairs, expansion


ALL = [case for scenario in EXPLORED for case in explored(scenario)]
ARCS = [
    (task, arc)
    for task, _, _, expansion in ALL
    for arc in expansion.arcs
    if arc.mode == QUASI_STATIC
]


def test_there_is_something_to_look_at():
    outcomes = [expansion.outcome for *_, expansion in ALL]
    assert {REACHED, NEW_Y, UNREACHED} == set(outcomes) and len(ARCS) > 100


def test_along_an_arc_all_four_gaps_are_closed_and_nothing_penetrates():
    """|gap| ≤ 1e-9 m of the four, every other gap ≥ −1e-7 m, joints within their limits."""
    for task, arc in ARCS:
        limits = task.world.limits
        for q in arc.configurations:
            assert np.abs(contact_rows(task.world, arc.pairs, q)[1]).max() <= 1e-9
            assert gap_table(task.world, q)[0].min() >= -1e-7
            assert (q[3:] >= limits[:, 0] - 1e-8).all() and (q[3:] <= limits[:, 1] + 1e-8).all()


def test_contact_points_stay_on_their_edges():
    """0 ≤ along ≤ length, to 1e-8 m."""
    for task, arc in ARCS:
        for q in arc.configurations[::3]:
            for pair in arc.pairs:
                *_, along, length = geometry.contact(task.world, pair, q)
                assert -1e-8 <= along <= length + 1e-8


def test_tangents_are_unit_vectors_along_which_no_gap_opens():
    for task, arc in ARCS:
        for q, t in zip(arc.configurations, arc.tangents):
            assert np.linalg.norm(t / task.world.scale) == pytest.approx(1.0, abs=1e-9)
            np.testing.assert_allclose(
                contact_rows(task.world, arc.pairs, q)[0] @ t, 0.0, atol=1e-8
            )


def test_tangents_are_finite_differences_of_the_arc():
    """Two projected neighbours at ± 1e-4 of arc length, to 1e-5."""
    h = 1e-4
    for task, arc in ARCS[::3]:
        scale = task.world.scale
        for q, t in zip(arc.configurations[::4], arc.tangents[::4]):
            ends = []
            for sign in (1.0, -1.0):
                near = q + sign * h * t
                manifold = arc_tracing.new_manifold(task.world, np.array(arc.pairs))
                assert arc_tracing.project(task.world, manifold, near, t / scale**2)
                ends.append(near)
            np.testing.assert_allclose((ends[0] - ends[1]) / (2 * h * scale), t / scale, atol=1e-5)


def test_an_arc_goes_on_without_turning_back():
    for task, arc in ARCS:
        steps = np.diff(arc.configurations, axis=0) / task.world.scale**2
        assert (np.einsum('ij,ij->i', steps, arc.tangents[:-1]) > 0.0).all()


def test_one_of_the_fingers_can_hold_the_object_all_along_an_arc():
    """Check_Equilibrium: some torque range of (6) is not empty; the last sample, an event, is not asked."""
    for task, arc in ARCS:
        for q in arc.configurations[:-1]:
            model = build_quasistatics(task.world, arc.pairs, q)
            assert any(
                not solve_torque_range(
                    build_torque_range(model, side, task.world.torque_limits)
                ).empty
                for side in (0, 1)
            )


def test_where_an_arc_passes_into_the_next_one_contact_changes_and_the_configuration_does_not():
    """X_through: the configuration is the same to 1e-9, three of the four pairs stay."""
    passed = 0
    for task, _, _, expansion in ALL:
        for before, after in zip(expansion.arcs[:-1], expansion.arcs[1:]):
            if CAGING in (before.mode, after.mode):
                continue
            passed += 1
            np.testing.assert_allclose(
                after.configurations[0], before.configurations[-1], atol=1e-9
            )
            assert len(set(before.pairs) & set(after.pairs)) == 3
    assert passed > 10


def test_through_an_x_through_the_velocity_finger_does_not_reverse():
    """With a driver, its angle is monotone from X_start to the end of the expansion (X_through is projected anew: 1e-8)."""
    passed = 0
    for scenario in FLAT_PALMS.values():
        task = build_problem(scenario)
        for pairs in four_contact_subsets(task.pairs):
            for driver in (0, 1):
                for direction in (1.0, -1.0):
                    toward = np.zeros(5)
                    toward[3 + driver] = direction
                    for expansion in new_subgoal(task, task.start, pairs, toward, driver):
                        turned = [
                            q[3 + driver]
                            for arc in expansion.arcs
                            if arc.mode == QUASI_STATIC
                            for q in arc.configurations
                        ]
                        assert (direction * np.diff(turned) > -1e-8).all()
                        passed += len(expansion.arcs) > 1
    assert passed > 5


def test_a_new_y_has_five_contacts_and_the_four_it_was_reached_with():
    for task, _, _, expansion in ALL:
        last = expansion.arcs[-1] if expansion.arcs else None
        if expansion.outcome == NEW_Y and last.mode == QUASI_STATIC:
            assert len(expansion.pairs) >= 5 and set(last.pairs) <= set(expansion.pairs)
            assert expansion.pairs == closed_pairs(task.world, expansion.end)


def test_reached_means_that_the_object_is_at_its_goal():
    for task, _, _, expansion in ALL:
        assert task.reached(expansion.end[:3]) if expansion.outcome == REACHED else True
        if expansion.outcome == UNREACHED and expansion.arcs:
            assert not task.reached(expansion.end[:3])


def test_a_caged_object_rolls_down_over_its_lowest_vertex_between_closed_fingers():
    """From past the top to the landing: φ rises, the lowest vertex is on the palm, each finger touches, nothing penetrates."""
    caged = 0
    for task, _, _, expansion in ALL:
        for arc in expansion.arcs:
            if arc.mode != CAGING:
                continue
            caged += 1
            angles = arc.configurations[:, 2]
            cage = task.cage_at(angles[0])
            assert (
                cage is not None
                and (np.diff(angles) > 0.0).all()
                and angles[-1] == pytest.approx(cage.landing, abs=1e-9)
            )
            for q in arc.configurations[1:]:
                gaps, codes = gap_table(task.world, q)
                bodies = np.array([geometry.pair_body(c) for c in codes])
                assert gaps.min() > -1e-7
                assert all(gaps[bodies == body].min() < 1e-7 for body in range(3))
    assert caged > 10
