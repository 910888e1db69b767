"""Routes of the search over states at rest: chains of legs that the generator executes, found by executing them."""

import numpy as np
import pytest
from problems import ASYMMETRIC, LEANING, PENTAGON, REGULAR, TALL, beliefs

from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.planning.problem import build_problem
from wholearm_ros.planning.routes import SearchOptions
from wholearm_ros.search.arcs import arcs_from, whole_graph
from wholearm_ros.search.state_routes import StateRoutes
from wholearm_ros.search.state_tree import REFUSAL_PRICE
from wholearm_ros.trajectory.main_trajectory import generate

TASKS = [ASYMMETRIC, REGULAR, PENTAGON, TALL]


@pytest.fixture(scope='module')
def found():
    routes = {s.name: StateRoutes(s, SearchOptions(move_limit=800), beliefs) for s in TASKS}
    plans = {name: (made, made.next_plan()) for name, made in routes.items()}
    return {name: pair for name, pair in plans.items() if pair[1].found}


def test_both_shipped_hexagons_have_a_route(found):
    assert {ASYMMETRIC.name, REGULAR.name} <= set(found)


def test_a_route_is_a_chain_of_its_own_subgoals(found):
    """Numbers are places, legs join neighbours of the path, and one begins where the last one ended."""
    for _, plan in found.values():
        assert [s.number for s in plan.subgoals] == list(range(1, len(plan.subgoals) + 1))
        assert plan.path[0] == 1 and len(set(plan.path)) == len(plan.path)
        neighbours = set(zip(plan.path[:-1], plan.path[1:]))
        assert all((leg.start, leg.end) in neighbours for leg in plan.legs)
        for before, after in zip(plan.legs[:-1], plan.legs[1:]):
            np.testing.assert_allclose(
                after.configurations[0], before.configurations[-1], atol=2e-3
            )
        assert ContactPlan.from_json(plan.to_json()).id == plan.id


def test_every_sample_that_the_goal_needs_has_arrived_in_every_state_before(found):
    for routes, _ in found.values():
        tree = routes.tree
        goal = next(k for k, state in enumerate(tree.states) if state.goal)
        arrived = [
            {k for k, sample in enumerate(state.belief.states) if sample is not None}
            for state in (tree.states[place] for place in tree.places_to(goal))
        ]
        assert all(0 in here and after <= here for here, after in zip(arrived, arrived[1:]))


def test_the_generator_executes_a_route_whatever_its_kinds_of_legs(found):
    for _, plan in found.values():
        made = generate(plan.scenario, plan)
        assert made.poses[-1, 2] == pytest.approx(plan.legs[-1].configurations[-1, 2], abs=5e-3)


def test_arcs_leave_a_state_that_is_only_nearly_closed():
    """What a simulation leaves open by a tenth of a millimetre is closed before arcs are traced."""
    problem = build_problem(ASYMMETRIC)
    arcs = arcs_from(problem, problem.start + 1e-5 * np.array([1.0, 1.0, 0.1, 0.1, -0.1]), 1000)
    there = whole_graph(problem, 1000)
    assert arcs is not None and arcs.prospects[0].margin == pytest.approx(
        there.prospects[0].margin, abs=0.01
    )


def test_a_refused_route_defers_what_goes_on_from_its_cell():
    """Also what is queued afterwards, so that the next route avoids what made the first one fail."""
    tree = StateRoutes(LEANING, SearchOptions(move_limit=200), beliefs).tree
    while len(tree.states) < 2:
        tree.grow()
    done: list[str] = []
    tree.refuse(1)
    tree.push(1, -1.0, lambda: done.append('from the refused state'))
    tree.push(0, -1.0 + 0.5 * REFUSAL_PRICE, lambda: done.append('from the start'))
    for _ in range(2):
        tree.grow()
    assert done == ['from the start', 'from the refused state']
