"""Supervision: what is done next after each claim."""

from dataclasses import replace
from pathlib import Path

import pytest

from wholearm_ros.estimation.claim import Claim, unfelt_claim
from wholearm_ros.estimation.feel import Candidate, Felt
from wholearm_ros.model.orientation import directed
from wholearm_ros.model.outcomes import AT_GOAL, ELSEWHERE, LOST, LYING, UNKNOWN, UNVERIFIED
from wholearm_ros.model.scenario import GoalOnEdge, StartOnEdge
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.planner.supervision import END, FEEL, FEELS, PLAN, Supervision

SCENARIO = load_scenario(Path(__file__).parents[2] / 'config' / 'asymmetric_hexagon.yaml')


def elsewhere(edge=0, x=0.01):
    felt = Felt(LYING, (Candidate((edge,), 0, x, 1e-3, 1e-3, 1.0, 1.0),))
    return Claim(ELSEWHERE, 'felt elsewhere', felt)


@pytest.mark.parametrize('outcome', [AT_GOAL, LOST])
def test_it_ends_where_nothing_is_left_to_do(outcome):
    _, decision = Supervision(SCENARIO).executed(Claim(outcome, 'so it is'))
    assert (decision.action, decision.outcome, decision.reason) == (END, outcome, 'so it is')


def test_it_plans_again_from_what_was_felt_until_the_attempts_are_spent():
    supervision = Supervision(SCENARIO, max_attempts=3)
    for _ in range(2):
        supervision, decision = supervision.executed(elsewhere())
        assert decision.action == PLAN
        start = decision.scenario.start
        assert (start.edge, start.x) == (0, 0.01)
    supervision, decision = supervision.executed(elsewhere())
    assert (decision.action, decision.outcome, supervision.attempts) == (END, ELSEWHERE, 3)


def test_from_where_it_was_felt_either_direction_will_do_and_the_shorter_turn_is_planned_first():
    again = Supervision(SCENARIO).onwards(StartOnEdge(4, 0.01))
    assert again.goal.direction is None
    assert [s.goal.direction for s in directed(again)] == ['cw', 'ccw']


def test_a_stop_on_the_way_costs_no_attempt():
    supervision, decision = Supervision(SCENARIO, max_attempts=1).executed(
        replace(elsewhere(edge=1), outcome=AT_GOAL), stop=GoalOnEdge(1, 'cw')
    )
    assert (decision.action, supervision.stops) == (PLAN, 1)
    assert decision.scenario.start.edge == 1 and decision.scenario.goal == GoalOnEdge(5)
    supervision, decision = supervision.executed(elsewhere(edge=2), stop=GoalOnEdge(0, 'cw'))
    assert (decision.action, decision.outcome) == (END, ELSEWHERE)


def test_a_slide_on_the_way_is_not_felt_unless_the_fingers_deviated():
    slide, place = GoalOnEdge(0, None, 0.03, 0.012), StartOnEdge(0, 0.03)
    unfelt = unfelt_claim('')
    supervision, decision = Supervision(SCENARIO, 1).executed(unfelt, slide, place)
    assert (decision.action, supervision.stops) == (PLAN, 1)
    assert decision.scenario.start == place and decision.scenario.goal == GoalOnEdge(5)
    assert supervision.no_plan('from there').outcome == UNKNOWN
    _, decision = Supervision(SCENARIO, 1).executed(unfelt_claim('left 0.1 rad'), slide, place)
    assert decision.action == FEEL
    _, decision = Supervision(SCENARIO, 1).executed(Claim(UNVERIFIED, 'no probe was made'))
    assert (decision.action, decision.outcome) == (END, UNVERIFIED)


def test_a_stop_that_is_felt_only_at_the_second_probe_is_not_taken_for_the_goal():
    stop = GoalOnEdge(4, 'ccw')
    supervision, decision = Supervision(SCENARIO).executed(Claim(UNKNOWN, 'wedged'), stop)
    assert decision.action == FEEL
    supervision, decision = supervision.felt(replace(elsewhere(edge=4), outcome=AT_GOAL))
    assert (decision.action, supervision.stops) == (PLAN, 1)
    assert decision.scenario.start.edge == 4


def test_before_the_first_trajectory_only_what_is_felt_counts():
    """The claim is of the goal before: what lies elsewhere is not at this goal."""
    to_be_felt = replace(SCENARIO, start=replace(SCENARIO.start, felt=True))
    supervision = Supervision(to_be_felt)
    assert supervision.begin().action == FEEL
    _, decision = supervision.felt(replace(elsewhere(edge=4), outcome=AT_GOAL))
    assert decision.action == PLAN and not decision.scenario.to_be_felt
    _, decision = supervision.felt(elsewhere(edge=5))
    assert (decision.action, decision.outcome) == (END, AT_GOAL)


def test_what_ends_at_the_goal_by_chance_is_felt_twice_before_it_is_said_to_be_there():
    missed, stop = elsewhere(edge=5), GoalOnEdge(0, 'cw')
    first, decision = Supervision(SCENARIO).executed(missed, stop=stop)
    assert decision.action == FEEL
    _, decision = first.felt(missed)
    assert (decision.action, decision.outcome) == (END, AT_GOAL)
    second, decision = first.felt(Claim(UNKNOWN, 'wedged'))
    assert decision.action == FEEL
    _, decision = second.felt(Claim(UNKNOWN, 'wedged'))
    assert (decision.action, decision.outcome) == (END, UNKNOWN)
    _, decision = first.felt(elsewhere(edge=3))
    assert decision.action == PLAN and decision.scenario.start.edge == 3
    _, decision = Supervision(SCENARIO).executed(replace(missed, outcome=AT_GOAL), stop=stop)
    assert (decision.action, decision.outcome) == (END, AT_GOAL)


def test_what_is_not_known_is_felt_again_but_not_forever():
    supervision, decision = Supervision(SCENARIO).executed(Claim(UNKNOWN, 'wedged'))
    feels = 1
    while decision.action == FEEL:
        supervision, decision = supervision.felt(Claim(UNKNOWN, 'wedged'))
        feels += 1
    assert (decision.action, decision.outcome, feels) == (END, UNKNOWN, FEELS)


def test_without_a_plan_the_reason_names_what_was_felt():
    supervision, _ = Supervision(SCENARIO).executed(elsewhere())
    decision = supervision.no_plan('exhausted')
    assert decision.outcome == ELSEWHERE and 'felt elsewhere' in decision.reason
