"""Arcs: projection onto closed contacts, forward kinematics at given angles, and the pair that follows at the end of an edge."""

import numpy as np
import pytest
from problems import ASYMMETRIC, FLAT_PALMS

from wholearm_ros.kernels import arc_tracing
from wholearm_ros.mechanics.contacts import (
    contact_rows,
    four_contact_subsets,
    gap_table,
    pair_from_name,
    pair_name,
)
from wholearm_ros.mechanics.quasistatic import build_quasistatics
from wholearm_ros.mechanics.torque_range import build_torque_range, solve_torque_range
from wholearm_ros.planning.problem import build_problem

CONTACTS = (
    'v0:palm.e0',
    'v1:palm.e0',
    'v5:left.inner',
    'v2:right.inner',
)  # of the slide that ASYMMETRIC begins with


def slide():
    """(world, pair codes, configurations, tangents, statics) of the arc on which the hexagon slides to the right."""
    task = build_problem(ASYMMETRIC)
    w, codes = task.world, np.array([pair_from_name(c) for c in CONTACTS])
    given = arc_tracing.ArcTask(codes, task.start, np.eye(5)[0], -1, 0.03, task.cage_intervals)
    samples = new_samples()
    count, event, which = arc_tracing.trace_arc(w, given, samples)
    return w, codes, *(rows[:count] for rows in samples), event, which


def new_samples():
    return arc_tracing.ArcSamples(np.empty((300, 5)), np.empty((300, 5)), np.empty((300, 2, 4)))


def followed(w, codes, qs, driver, thetas):
    """(how many were found, configurations, statics, gains) at angles of the velocity finger."""
    k = len(thetas)
    course = arc_tracing.FollowedCourse(np.empty((k, 5)), np.empty((k, 2, 4)), np.empty((k, 2)))
    following = arc_tracing.Following(codes, qs, driver, 0.03)
    return arc_tracing.follow(w, following, thetas, course), *course


def test_projection_closes_the_pairs_and_moves_across_the_held_direction_only():
    w, codes, qs, _, _, _, _ = slide()
    rng = np.random.default_rng(40)
    for q in qs[1:-1:4]:
        away = q + rng.normal(size=5) * 1e-3
        hold, moved = rng.normal(size=5), away.copy()
        assert arc_tracing.project(w, arc_tracing.new_manifold(w, codes), moved, hold)
        assert np.abs(contact_rows(w, codes, moved)[1]).max() < arc_tracing.GAP_TOLERANCE
        assert hold @ (moved - away) == pytest.approx(0.0, abs=1e-9)


def test_an_arc_starts_where_it_is_told_and_goes_to_the_side_it_is_told():
    _, _, qs, ts, _, event, _ = slide()
    np.testing.assert_allclose(qs[0], build_problem(ASYMMETRIC).start, atol=1e-9)
    assert ts[0, 0] > 0.0 and qs[-1, 0] > qs[0, 0] + 0.05
    assert event == arc_tracing.CLOSED


def test_the_event_that_ends_an_arc_is_located_to_a_nanometre():
    """The pair named as closed has no gap at the end, and had one before."""
    w, _, qs, _, _, _, which = slide()
    after, before = (contact_rows(w, [which], q)[1][0] for q in (qs[-1], qs[-2]))
    assert abs(after) <= 2.0 * arc_tracing.EVENT_TOLERANCE and before > 1e-6


def test_statics_along_an_arc_are_the_torque_ranges_of_problem_6():
    """For either torque finger, as solved configuration by configuration; the friction-robust part lies inside."""
    w, codes, qs, _, statics, _, _ = slide()
    for q, both in zip(qs, statics):
        for side in range(2):
            one = solve_torque_range(
                build_torque_range(build_quasistatics(w, tuple(codes), q), side, w.torque_limits)
            )
            np.testing.assert_allclose(both[side, :2], [one.low, one.high], atol=1e-9)
            assert both[side, 2] >= both[side, 0] and both[side, 3] <= both[side, 1]


@pytest.mark.parametrize('driver', [0, 1])
def test_following_gives_the_angles_asked_for_with_all_contacts_closed(driver):
    """Forward kinematics (3): θ_V exactly, gaps ≤ 1e-9; the gains are the equilibrium torque of the velocity finger."""
    w, codes, qs, _, _, _, _ = slide()
    thetas = np.linspace(qs[0, 3 + driver], qs[-1, 3 + driver], 37)
    found, out, statics, gains = followed(w, codes, qs, driver, thetas)
    assert found == 37
    np.testing.assert_allclose(out[:, 3 + driver], thetas, atol=1e-12)
    for q, both, gain in zip(out, statics, gains):
        assert np.abs(contact_rows(w, codes, q)[1]).max() < 1e-9
        model = build_quasistatics(w, tuple(codes), q)
        torque = both[1 - driver, 0]
        f = np.linalg.solve(
            model.square_block(1 - driver).T,
            np.append(-model.g_O, torque - model.g_h[1 - driver]) * [1, 1, 1, -1],
        )
        assert model.joint_torques(f)[1 - driver] == pytest.approx(torque, abs=1e-9)
        assert gain[0] + gain[1] * torque == pytest.approx(model.joint_torques(f)[driver], abs=1e-9)


def test_following_stops_where_the_contacts_cannot_be_kept():
    w, codes, qs, _, _, _, _ = slide()
    assert followed(w, codes, qs, 0, np.array([qs[0, 3], qs[0, 3] + 2.0]))[0] == 1


def test_a_driver_that_would_have_to_reverse_ends_the_arc():
    """With a velocity finger the arc is a part of the arc without, and its angle is monotone."""
    for scenario in FLAT_PALMS.values():
        task = build_problem(scenario)
        w = task.world
        for four in four_contact_subsets(task.pairs):
            for driver in (0, 1):
                ends = []
                toward = np.zeros(5)
                toward[3 + driver] = 1.0
                for given in (-1, driver):
                    asked = arc_tracing.ArcTask(
                        np.array(four), task.start, toward, given, 0.03, task.cage_intervals
                    )
                    samples = new_samples()
                    count = arc_tracing.trace_arc(w, asked, samples)[0]
                    ends.append(samples.configurations[:count])
                assert len(ends[1]) <= len(ends[0])
                assert (np.diff(ends[1][:, 3 + driver]) > 0.0).all()


@pytest.mark.parametrize(
    'name, vertex_on, follows',
    [
        (
            'e2:right.inner_corner',
            'v2',
            'v2:right.inner',
        ),  # the corner slides off edge 2: its lower vertex comes onto the face
        (
            'v2:right.inner',
            'v2',
            'e1:right.inner_corner',
        ),  # the vertex slides off the face: the edge below it is on the corner
    ],
)
def test_the_pair_at_the_end_of_an_edge_is_followed_by_its_neighbour(name, vertex_on, follows):
    """Vertex 2 of the object is put on the corner of the right finger's tip: what it had been determines what comes."""
    task = build_problem(ASYMMETRIC)
    w, q = task.world, task.start.copy()
    corner = np.array(arc_tracing.hand_edge(w, 2, 0, arc_tracing.frames_of(w, q))[:2]) + w.fingers[
        1, 2
    ] * np.array([np.cos(q[4]), np.sin(q[4])])
    c, s = np.cos(q[2]), np.sin(q[2])
    q[:2] += corner - (q[:2] + np.array([[c, -s], [s, c]]) @ w.obj[int(vertex_on[1]), :2])
    assert pair_name(int(arc_tracing.next_pair_at_end(w, pair_from_name(name), q))) == follows
    gaps, _ = gap_table(w, q)
    assert np.abs(gaps).min() < 1e-12
