"""An offer survives its own simulation, or there is none and a reason; the same request gets the same bytes."""

from dataclasses import replace

import numpy as np
import pytest
from problems import ASYMMETRIC, SHIPPED, SQUARE, with_torque_limits

from wholearm_ros.errors import ScenarioError
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario import StartOnEdge
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.planner.planner import Request, offer
from wholearm_ros.trajectory.main_trajectory import generate

BEST, RANDOM = Request(), Request(search='random', seed=3)


@pytest.fixture(scope='module')
def offers():
    return {
        (name, request.search): offer(scenario, request)
        for name, scenario in SHIPPED.items()
        for request in (BEST, RANDOM)
    }


@pytest.mark.parametrize('search', ['best', 'random'])
@pytest.mark.parametrize('name', SHIPPED)
def test_the_shipped_scenarios_are_offered_and_every_copy_survives(offers, name, search):
    found = offers[name, search]
    record = found.trajectory.verification
    assert found.plan.found and found.verification.survived == 1.0
    assert (
        record['survived'] == record['copies'] == Request().copies + 1 and record['reasons'] == []
    )
    assert record['lcp_residual'] <= 1e-9


@pytest.mark.parametrize('name', SHIPPED)
def test_the_generator_makes_the_offered_trajectory_from_the_plan_document_alone(offers, name):
    """What the trajectory generator node does: the same motion and torques, bit by bit."""
    found = offers[name, 'best']
    plan = ContactPlan.from_json(found.plan.to_json())
    made = generate(plan.scenario, plan)
    assert made.plan_id == found.trajectory.plan_id == plan.id
    for field in ('angles', 'velocities', 'efforts', 'poses'):
        np.testing.assert_array_equal(getattr(made, field), getattr(found.trajectory, field))


@pytest.mark.parametrize('name', SHIPPED)
def test_the_same_request_gives_the_same_documents(offers, name):
    again = offer(SHIPPED[name], RANDOM)
    assert again.plan.to_json() == offers[name, 'random'].plan.to_json()
    assert again.trajectory.to_json() == offers[name, 'random'].trajectory.to_json()


def test_timings_name_the_three_stages(offers):
    for found in offers.values():
        assert set(found.timings) == {'plan_ms', 'generate_ms', 'verify_ms'}
        assert all(value > 0.0 for value in found.timings.values())


def test_a_clockwise_task_is_offered_too():
    found = offer(ASYMMETRIC.mirrored(), replace(BEST, copies=2))
    assert found.verification.survived == 1.0
    assert found.trajectory.poses[-1, 2] < found.trajectory.poses[0, 2]
    ManipulationTrajectory.from_json(found.trajectory.to_json())


def test_motors_that_cannot_lift_the_object_get_a_reason_and_no_trajectory():
    found = offer(with_torque_limits(ASYMMETRIC, 0.02), Request(copies=1, candidates=3, moves=60))
    assert found.trajectory is None and not found.plan.found and found.plan.reason
    assert not found.plan.path and not found.plan.legs


def test_a_graph_without_a_route_gets_its_own_reason():
    found = offer(SQUARE, Request(moves=0))
    assert (
        found.trajectory is None
        and found.plan.outcome == 'exhausted'
        and 'exhausted' in found.plan.reason
    )


def test_a_route_that_no_copy_survives_is_not_offered():
    """Copies so wildly perturbed that most must fail: the answer says how many candidates were tried and why they failed."""
    found = offer(ASYMMETRIC, Request(copies=6, level=12.0, candidates=2, moves=0))
    assert found.trajectory is None and found.plan.outcome == 'not_executable'
    assert 'candidates tried' in found.plan.reason and not found.plan.legs


def test_a_start_out_of_reach_is_an_error():
    with pytest.raises(ScenarioError):
        offer(replace(ASYMMETRIC, start=StartOnEdge(0, -0.9)))


def test_progress_is_told_for_people():
    lines = []
    offer(
        with_torque_limits(ASYMMETRIC, 0.6),
        Request(copies=1, candidates=2, moves=0),
        progress=lines.append,
    )
    assert all('candidates tried' in line for line in lines)
