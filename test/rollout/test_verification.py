"""Verification tells good trajectories from bad ones, the same way every time."""

from dataclasses import replace

import numpy as np
import pytest
from problems import ASYMMETRIC

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.model.hand import CLOSING
from wholearm_ros.model.scenario import GoalOnEdge
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.rollout.perturbed_samples import build_perturbed_samples
from wholearm_ros.rollout.verification import Rollout, Verification, verify

SAMPLES = build_perturbed_samples(ASYMMETRIC, 4, 1.0, 0)
NOMINAL = SAMPLES[:1]


@pytest.fixture(scope='module')
def trajectory():
    return plan_and_verify(
        ASYMMETRIC, PlanRequest(samples=2, moves=0, transition='dwell')
    ).trajectory


def test_a_good_trajectory_survives_as_told_and_in_perturbed_copies(trajectory):
    found = verify(trajectory, SAMPLES)
    assert (
        found.success_rate == 1.0
        and not found.reasons()
        and found.asked == len(found.rollouts) == 5
    )
    assert found.to_dict()['lcp_residual'] <= 1e-9


def test_verification_is_the_same_every_time(trajectory):
    one, two = (verify(trajectory, SAMPLES) for _ in range(2))
    for a, b in zip(one.rollouts, two.rollouts):
        np.testing.assert_array_equal(a.configurations, b.configurations)


def test_the_nominal_run_keeps_to_the_planned_poses(trajectory):
    """Within 5 mm and 0.05 rad to the end of the last quasi-static segment: such plans predict their execution."""
    trial = verify(trajectory, NOMINAL).nominal
    release = max(s.end for s in trajectory.segments if s.mode == 'quasi_static')
    planned = trajectory.poses[
        np.minimum(np.round(trial.times / trajectory.period).astype(int), len(trajectory.poses) - 1)
    ]
    away = np.abs(trial.configurations[:, :3] - planned)[trial.times < release]
    assert (away.max(axis=0) < [5e-3, 5e-3, 5e-2]).all()


@pytest.mark.parametrize('wrong', [3.0, -3.0])
def test_a_torque_far_out_of_range_fails(trajectory, wrong):
    """The torque finger's effort off by 3 N m all along: what was planned does not happen."""
    efforts = trajectory.efforts.copy()
    sides = np.array([trajectory.segment_at(t).torque_finger for t in trajectory.times])
    efforts[np.arange(len(sides)), sides] += wrong
    found = verify(replace(trajectory, efforts=efforts), NOMINAL)
    assert found.success_rate == 0.0 and found.reasons() and found.nominal.residual <= 1e-9


def test_a_trajectory_that_stands_still_does_not_reach_the_goal(trajectory):
    still = replace(
        trajectory,
        angles=np.repeat(trajectory.angles[:1], len(trajectory.angles), axis=0),
        velocities=np.zeros_like(trajectory.velocities),
    )
    assert 'rotation is off' in verify(still, NOMINAL).nominal.reason


def test_an_x_asked_for_must_be_reached(trajectory):
    for x, tolerance, fails in ((0.10, 0.01, True), (0.0, 0.5, False)):
        asked = replace(ASYMMETRIC, goal=GoalOnEdge(5, 'ccw', x, tolerance))
        nominal = build_perturbed_samples(asked, 0, 0.0, 0)
        assert bool(verify(trajectory, nominal).nominal.reason) == fails


def test_rollouts_that_were_not_run_count_as_failed():
    good = Rollout(np.zeros(1), np.zeros((1, 5)), True, '', 0.0)
    assert Verification((good, good), 4).success_rate == 0.5


def test_a_run_whose_finger_meets_an_end_stop_that_the_plan_does_not_use_has_failed(trajectory):
    """The torque finger opens with 1 N m instead of holding the object: it comes to bear on its open stop, and stays there,
    where nothing else stops the run before.
    """
    efforts = trajectory.efforts.copy()
    for k, t in enumerate(trajectory.times):
        side = trajectory.segment_at(t).torque_finger
        efforts[k, side] -= CLOSING[side]
    unguarded = ControlOptions(max_tracking_error=np.inf)
    nominal = verify(replace(trajectory, efforts=efforts), NOMINAL, unguarded).nominal
    assert 'end stop' in nominal.reason and not nominal.success
    limits = NOMINAL[0].world.limits
    angles = nominal.configurations[:, 3:]
    assert (angles > limits[:, 0] - 1e-6).all() and (angles < limits[:, 1] + 1e-6).all()
