"""Laws of similarity: a plan depends on shapes and ratios, not on this hand's metres or on where it stands."""

from dataclasses import replace

import numpy as np
import pytest
from problems import ASYMMETRIC, beliefs

from wholearm_ros.model.hand import Hand, Palm
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario import Gravity, ManipulatedObject, Scenario, StartOnEdge
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.planning.problem import build_problem
from wholearm_ros.planning.routes import SearchOptions
from wholearm_ros.rollout.primitive_rollout import released, simulate_primitive
from wholearm_ros.search.primitive_candidates import STYLES, stops_along, sweeps
from wholearm_ros.search.state_routes import StateRoutes

NOMINAL_ONLY = PlanRequest(samples=0, certificate_samples=0, moves=0, transition='dwell')


def scaled(scenario: Scenario, k: float) -> Scenario:
    """Every length k times as long, masses and gravity such that torques and times stay as they are."""
    hand = Hand(
        *(
            replace(
                f,
                axis=k * f.axis,
                shape=f.shape.scaled(k),
                mass=f.mass / k**2,
            )
            for f in (scenario.hand.left, scenario.hand.right)
        )
    )
    body, start, gravity = scenario.object, scenario.start, scenario.gravity
    return replace(
        scenario,
        object=ManipulatedObject(Polygon(k * body.polygon.vertices), body.mass / k**2),
        hand=hand,
        palm=Palm(k * scenario.palm.vertices),
        gravity=Gravity(k * gravity.acceleration, gravity.tilt),
        start=StartOnEdge(start.edge, k * start.x),
    )


def raised(scenario: Scenario, by: np.ndarray) -> Scenario:
    """The hand, and the object in it, somewhere else in the plane of support."""
    hand = Hand(*(replace(f, axis=f.axis + by) for f in (scenario.hand.left, scenario.hand.right)))
    start = StartOnEdge(scenario.start.edge, scenario.start.x + by[0])
    return replace(scenario, hand=hand, palm=Palm(scenario.palm.vertices + by), start=start)


def poses_and_angles(plan, k=1.0, by=(0.0, 0.0)):
    q = np.vstack([leg.configurations for leg in plan.legs])
    return np.hstack([(q[:, :2] - by) / k, q[:, 2:]])


@pytest.mark.parametrize('k', [2.0, 0.5])
def test_a_scaled_hand_gets_the_scaled_plan(k):
    plain, large = (plan_and_verify(s, NOMINAL_ONLY) for s in (ASYMMETRIC, scaled(ASYMMETRIC, k)))
    assert large.verification.success_rate == 1.0
    np.testing.assert_allclose(
        poses_and_angles(large.plan, k), poses_and_angles(plain.plan), atol=1e-6
    )
    np.testing.assert_allclose(large.trajectory.efforts, plain.trajectory.efforts, atol=1e-4)


def first_stops(problem):
    """Of all sweeps from the start."""
    rest = released(problem.world, problem.start)
    tried = [
        (s, simulate_primitive(problem.world, rest, s)) for s in sweeps(problem, rest.q, STYLES[0])
    ]
    stops = [move for s, record in tried for move, _ in stops_along(problem, rest, s, record)]
    return [(move.velocity_finger, move.turn, move.torque) for move in stops]


@pytest.mark.parametrize('k', [2.0, 0.5])
def test_the_first_states_of_a_scaled_tree_of_primitives_are_scaled(k):
    """Later ones are apart by what impacts make of rounding; how far an object may go must not depend on metres."""
    stops = [first_stops(build_problem(s)) for s in (ASYMMETRIC, scaled(ASYMMETRIC, k))]
    shared = set(stops[0]) & set(stops[1])
    assert len(shared) >= 0.8 * max(map(len, stops))


@pytest.mark.parametrize('by', [(0.0, 0.2), (0.3, -0.4)])
def test_a_palm_at_another_height_changes_nothing(by):
    plain, other = (
        plan_and_verify(s, NOMINAL_ONLY) for s in (ASYMMETRIC, raised(ASYMMETRIC, np.array(by)))
    )
    np.testing.assert_allclose(
        poses_and_angles(other.plan, by=by), poses_and_angles(plain.plan), atol=1e-6
    )
    routes = StateRoutes(raised(ASYMMETRIC, np.array(by)), SearchOptions(move_limit=800), beliefs)
    assert routes.next_plan().found
