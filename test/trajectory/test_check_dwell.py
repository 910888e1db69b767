"""Dwells: five contacts carry the whole torque path, as the range of problem (6) says, and a torque outside of it is seen."""

from dataclasses import replace

import numpy as np
import pytest
from problems import ASYMMETRIC, REGULAR

from wholearm_ros.mechanics.contacts import closed_pairs, pair_from_name
from wholearm_ros.mechanics.quasistatic import build_quasistatics
from wholearm_ros.mechanics.torque_path import build_torque_path, solve_torque_path
from wholearm_ros.mechanics.torque_range import build_torque_range, solve_torque_range
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.planning.routes import plan
from wholearm_ros.trajectory.check_dwell import check_dwells
from wholearm_ros.trajectory.main_trajectory import generate

pytestmark = pytest.mark.filterwarnings('ignore::PendingDeprecationWarning')  # of osqp's own
BOTH = pytest.mark.parametrize('scenario', [ASYMMETRIC, REGULAR, ASYMMETRIC.mirrored()])


@BOTH
def test_the_torque_path_of_every_dwell_of_five_contacts_is_certified(scenario):
    reports = check_dwells(scenario, generate(scenario, plan(scenario)))
    assert reports and all(report.certified for report in reports)
    assert all(len(report.contacts) >= 5 for report in reports)


def test_a_torque_that_five_contacts_cannot_carry_is_seen():
    trajectory = generate(ASYMMETRIC, plan(ASYMMETRIC))
    (dwell,) = check_dwells(ASYMMETRIC, trajectory)
    end = round(dwell.end / trajectory.period)
    side = next(s for s in trajectory.segments if s.start == dwell.start).torque_finger
    for change in (-2.0, 2.0):
        efforts = trajectory.efforts.copy()
        efforts[end, side] += change
        (changed,) = check_dwells(ASYMMETRIC, replace(trajectory, efforts=efforts))
        assert changed.certified == in_range(dwell, trajectory, side, efforts[end, side])
        if not changed.certified:
            return
    raise AssertionError('the range is wider than 4 N m')


def in_range(dwell, trajectory, side, torque):
    world, end = build_world(ASYMMETRIC), round(dwell.end / trajectory.period)
    q = np.concatenate([trajectory.poses[end], trajectory.angles[end]])
    model = build_quasistatics(world, tuple(map(pair_from_name, dwell.contacts)), q)
    found = solve_torque_range(build_torque_range(model, side, world.torque_limits))
    return found.low <= torque <= found.high


@BOTH
def test_a_path_is_certified_where_both_its_ends_lie_in_the_range_of_problem_6(scenario):
    world, rng, seen = build_world(scenario), np.random.default_rng(0), set()
    ends = [leg.configurations[-1] for leg in plan(scenario).legs]
    for q, side in ((q, side) for q in ends for side in (0, 1)):
        pairs = closed_pairs(world, q)
        if len(pairs) < 5:
            continue
        model = build_quasistatics(world, pairs, q)
        found = solve_torque_range(build_torque_range(model, side, world.torque_limits))
        if found.empty:
            continue
        torques = found.low + found.width * rng.uniform(-0.5, 1.5, size=(6, 2))
        for path in torques:
            expected = (found.low <= path).all() and (path <= found.high).all()
            problem = build_torque_path(model, side, path, world.torque_limits)
            assert solve_torque_path(problem).certified == expected
            seen.add(bool(expected))
    assert seen == {True, False}
