"""Advice: single changes in the order of their cost, and the first that has a certified plan."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wholearm_ros.model.scenario_file import load_scenario, parse_scenario, scenario_to_dict
from wholearm_ros.planner.advice import advise, changes
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest

CONFIG = Path(__file__).parents[2] / 'config'
REQUEST = PlanRequest(time_budget=60.0)


@pytest.fixture(scope='module')
def axes_too_far():
    """The hexagon in a hand whose axes are 13 cm from the middle instead of 10."""
    told = scenario_to_dict(load_scenario(CONFIG / 'asymmetric_hexagon.yaml'))
    for side, x in (('left', -0.13), ('right', 0.13)):
        told['hand'][side]['axis'][0] = x
    return parse_scenario(told)


def test_changes_are_single_and_in_the_order_of_their_cost(axes_too_far):
    found = changes(axes_too_far)
    assert len(found) > 15 and len({change.what for change in found}) == len(found)
    assert [change.cost for change in found] == sorted(change.cost for change in found)
    told = scenario_to_dict(axes_too_far)
    for change in found:
        other = scenario_to_dict(change.scenario)
        assert sum(other[key] != told[key] for key in told) == 1


def test_a_change_says_what_it_does(axes_too_far):
    lower = next(c for c in changes(axes_too_far) if c.what == 'both axes 20 mm lower')
    for k in (0, 1):
        moved = lower.scenario.hand[k].axis - axes_too_far.hand[k].axis
        assert moved == pytest.approx([0.0, -0.02])
    wider = next(c for c in changes(axes_too_far) if c.what == 'both axes 10 mm farther out')
    assert np.ptp([wider.scenario.hand[k].axis[0] for k in (0, 1)]) == pytest.approx(0.28)


def test_the_first_change_that_works_has_a_certified_plan(axes_too_far):
    arcs_alone = replace(REQUEST, moves=0)
    assert plan_and_verify(axes_too_far, arcs_alone).trajectory is None
    tried = list(advise(axes_too_far, REQUEST, 250.0))
    best = tried[-1]
    assert best.works and not best.primitives and not any(trial.works for trial in tried[:-1])
    assert best.result.plan.certificate.lower_bound >= REQUEST.min_success
    assert best.to_dict()['change'] == best.change.what
    again = plan_and_verify(best.change.scenario, arcs_alone)
    assert again.plan.id == best.result.plan.id


def test_a_spent_budget_ends_it(axes_too_far):
    assert list(advise(axes_too_far, REQUEST, 0.0)) == []
