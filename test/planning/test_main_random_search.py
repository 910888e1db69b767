"""MAIN_RANDOM_SEARCH and its subgoal network: seeds, bookkeeping, outcomes."""

import numpy as np
import pytest
from problems import ASYMMETRIC, FLAT_PALMS, PENTAGON, QUADRILATERAL, REGULAR, SQUARE

from wholearm_ros.model.orientation import goal_rotation
from wholearm_ros.model.plan import (
    EXHAUSTED,
    FOUND,
    LIMIT_REACHED,
    X_END,
    X_GOAL,
    X_INIT,
    X_START,
    X_THROUGH,
    Y,
)
from wholearm_ros.planning.problem import build_problem
from wholearm_ros.planning.routes import RANDOM, SearchOptions, make_routes, plan

SOLVED = pytest.mark.parametrize(
    'scenario',
    [ASYMMETRIC, REGULAR, QUADRILATERAL, PENTAGON],
    ids=['asymmetric', 'regular', 'quadrilateral', 'pentagon'],
)


def random_plan(scenario, seed=0, limit=5000):
    return plan(scenario, SearchOptions(RANDOM, seed, limit))


@SOLVED
def test_the_same_seed_gives_the_same_bytes(scenario):
    assert random_plan(scenario, 5).to_json() == random_plan(scenario, 5).to_json()


def test_different_seeds_search_differently():
    plans = {tuple(s.kind for s in random_plan(REGULAR, seed).subgoals) for seed in range(8)}
    assert len(plans) > 3


def test_the_second_route_of_a_seed_is_another_draw_and_reproducible():
    firsts, seconds = set(), set()
    for _ in range(2):
        routes = make_routes(REGULAR, SearchOptions(RANDOM, 3))
        firsts.add(routes.next_plan().to_json())
        seconds.add(routes.next_plan().to_json())
    assert len(firsts) == len(seconds) == 1 and firsts != seconds


@SOLVED
@pytest.mark.parametrize('seed', range(3))
def test_parents_lead_from_every_subgoal_back_to_x_init(scenario, seed):
    """Numbers count from 1, a parent is older than its child, only X_init has none; the path is the parents of X_goal."""
    found = random_plan(scenario, seed)
    assert [s.number for s in found.subgoals] == list(range(1, len(found.subgoals) + 1))
    assert [s.kind for s in found.subgoals if s.parent is None] == [X_INIT]
    assert all(s.parent < s.number for s in found.subgoals[1:])
    walked, s = [], found.subgoals[found.path[-1] - 1]
    while s.parent is not None:
        walked.append(s.number)
        s = found.subgoals[s.parent - 1]
    assert (1, *reversed(walked)) == found.path and found.subgoals[
        found.path[-1] - 1
    ].kind == X_GOAL


@SOLVED
@pytest.mark.parametrize('seed', range(3))
def test_every_kind_of_subgoal_is_what_the_paper_says(scenario, seed):
    """X_start: four of its parent's contacts, at the same place. X_through: one contact changed. X_end: as X_start's chain.
    Y: five contacts at least, at the place of the X_end before it (four suffice where the object has just landed)."""
    subgoals = random_plan(scenario, seed).subgoals
    landed = {leg.end for leg in random_plan(scenario, seed).legs if leg.mode == 'caging'}
    for s in subgoals[1:]:
        before = subgoals[s.parent - 1]
        if s.kind == X_START:
            assert (
                before.kind in (X_INIT, Y)
                and len(s.contacts) == 4
                and set(s.contacts) <= set(before.contacts)
            )
            assert s.direction in (1, -1) and (s.configuration == before.configuration).all()
        elif s.kind in (X_THROUGH, X_END):
            assert before.kind in (X_START, X_THROUGH) and s.direction == before.direction
        elif s.kind == Y:
            assert before.kind == X_END and (s.configuration == before.configuration).all()
            assert set(before.contacts) <= set(s.contacts)
            assert len(s.contacts) >= (
                4 if before.number in landed or len(before.contacts) > 4 else 5
            )


@SOLVED
def test_no_x_start_is_drawn_twice(scenario):
    """ "Without overlapping with the existing four-contact subgoals attached": contacts and direction differ."""
    drawn = [
        (s.parent, s.contacts, s.direction)
        for s in random_plan(scenario, 1).subgoals
        if s.kind == X_START
    ]
    assert len(drawn) == len(set(drawn)) > 0


@SOLVED
@pytest.mark.parametrize('seed', range(3))
def test_legs_follow_on_one_another_from_the_start_to_the_goal(scenario, seed):
    found = random_plan(scenario, seed)
    ends = [(leg.start, leg.end) for leg in found.legs]
    assert set(n for pair in ends for n in pair) <= set(found.path)
    for before, after in zip(found.legs[:-1], found.legs[1:]):
        np.testing.assert_allclose(after.configurations[0], before.configurations[-1], atol=1e-8)
    np.testing.assert_allclose(
        found.legs[0].configurations[0], build_problem(scenario).start, atol=1e-9
    )
    assert found.legs[-1].configurations[-1, 2] == pytest.approx(goal_rotation(scenario), abs=1e-4)
    np.testing.assert_array_equal(
        found.object_path(), np.vstack([leg.configurations[:, :3] for leg in found.legs])
    )


@SOLVED
def test_counts_count_the_subgoals(scenario):
    found = random_plan(scenario, 2)
    five = sum(s.kind == Y for s in found.subgoals)
    assert (
        found.counts['subgoals'] == len(found.subgoals)
        and found.counts['five_contact_subgoals'] == five
    )
    assert (
        found.counts['four_contact_subgoals'] == len(found.subgoals) - five
        and found.counts['iterations'] >= 1
    )


def test_a_graph_without_a_way_is_exhausted_and_says_so():
    found = random_plan(SQUARE)
    assert (
        found.outcome == EXHAUSTED
        and not found.legs
        and not found.path
        and 'exhausted' in found.reason
    )
    assert found.object_path().shape == (0, 3) and found.summary().startswith('no plan (exhausted)')


def test_a_search_that_may_not_iterate_enough_says_limit_reached():
    limits = [random_plan(REGULAR, 0, limit) for limit in (1, 5000)]
    assert [p.outcome for p in limits] == [LIMIT_REACHED, FOUND] and 'limit' in limits[0].reason


@pytest.mark.parametrize(
    'name', ['asymmetric_hexagon', 'regular_hexagon', 'quadrilateral', 'pentagon']
)
def test_ten_seeds_all_find_a_route(name):
    assert all(random_plan(FLAT_PALMS[name], seed).found for seed in range(10))
