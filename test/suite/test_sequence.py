"""Sequences of faces: one hand, face after face, each judged and claimed."""

import pytest

from wholearm_ros.errors import ScenarioError
from wholearm_ros.model.outcomes import AT_GOAL
from wholearm_ros.model.scenario_file import load_scenario, scenario_to_dict
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.suite.statistics import summarize
from wholearm_ros.suite.suite_file import SuiteEntry
from wholearm_ros.suite.suite_options import SuiteOptions
from wholearm_ros.suite.task_result import run_task

KEYS = scenario_to_dict(load_scenario('asymmetric_hexagon'))
del KEYS['goal']


def test_a_hand_lays_the_object_on_face_after_face_without_a_reset(tmp_path, monkeypatch):
    monkeypatch.setenv('WHOLEARM_MAPS', str(tmp_path))
    request = PlanRequest(certificate_samples=20, min_success=0.5)
    options = SuiteOptions(request, backend='planar', attempts=2)
    result = run_task(SuiteEntry('faces', {**KEYS, 'sequence': [5, 0]}), options)
    assert 'error' not in result, result['error']
    assert [one['edge'] for one in result['reached']] == [5, 0]
    first, second = result['reached']
    assert first['executed'] and first['claimed'] == AT_GOAL and first['true_edge'] == 5
    assert second['executed'] == (second['true_edge'] == 0)
    summary = summarize([result])
    assert summary['runs'] == 2 and summary['false_success'] == 0


@pytest.mark.parametrize(
    'more, words',
    [
        ({'sequence': []}, 'sequence: got'),
        ({'sequence': 5}, 'sequence: got'),
        ({'sequence': [5], 'goal': {'edge': 5}}, 'beside a sequence'),
        ({'sequence': [5, 9]}, 'the object has 6 edges'),
    ],
)
def test_a_bad_sequence_is_refused(more, words):
    with pytest.raises(ScenarioError, match=words):
        SuiteEntry('faces', {**KEYS, **more}).parsed()


def test_a_start_that_nobody_told_is_felt_first(tmp_path, monkeypatch):
    monkeypatch.setenv('WHOLEARM_MAPS', str(tmp_path))
    request = PlanRequest(certificate_samples=20, min_success=0.5)
    options = SuiteOptions(request, backend='planar', attempts=2)
    start = {'edge': 0, 'x': 0.01, 'felt': True}
    asked = SuiteEntry('felt', {**KEYS, 'start': start, 'goal': {'edge': 5}})
    result = run_task(asked, options)
    assert result['planned'] and result['executed'], result
    assert result['draws'][0]['claimed'] == AT_GOAL and result['draws'][0]['attempts'] >= 1
