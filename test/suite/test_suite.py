"""The suite: every task gets a result with the contract's keys, an error spoils only itself, same seed same results."""

import copy
import json
from pathlib import Path

import numpy as np
import pytest

from wholearm_ros.errors import DocumentError, ScenarioError
from wholearm_ros.model.backends import installed_backends
from wholearm_ros.model.scenario_file import load_scenario, scenario_to_dict
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.suite.execution import perturbation_rng
from wholearm_ros.suite.jury_summary import jury_lines, jury_summary
from wholearm_ros.suite.statistics import summarize
from wholearm_ros.suite.suite import run_suite
from wholearm_ros.suite.suite_file import SuiteEntry, load_suite
from wholearm_ros.suite.suite_options import SuiteOptions
from wholearm_ros.suite.task_result import run_task

CONFIG = Path(__file__).parents[2] / 'config'
HEXAGON = scenario_to_dict(load_scenario(CONFIG / 'asymmetric_hexagon.yaml'))
KEYS = {
    'planned',
    'reason',
    'plan_ms',
    'generate_ms',
    'verify_ms',
    'subgoals',
    'path_length',
    'modes',
    'executed',
    'final_pose',
}
TIMES = {'plan_ms', 'generate_ms', 'verify_ms'}
OPTIONS = SuiteOptions(PlanRequest(candidates=4, moves=0), perturb=1.0, draws=2)


def tasks():
    clockwise_only_flat = copy.deepcopy(HEXAGON)
    clockwise_only_flat['object']['mass'] = -1
    return [
        SuiteEntry('good', HEXAGON),
        SuiteEntry('bad mass', clockwise_only_flat),
        SuiteEntry('not a table', 3),
    ]


@pytest.fixture(scope='module')
def results():
    heard = []
    found = run_suite(tasks(), OPTIONS, on_result=heard.append)
    assert heard == found
    return found


def test_every_task_has_a_result_in_order_with_the_keys_of_the_contract(results):
    assert [r['name'] for r in results] == ['good', 'bad mass', 'not a table']
    assert all(KEYS <= set(r) for r in results)
    json.dumps(results, allow_nan=False)


def test_the_shipped_scenario_is_planned_and_executed_under_perturbation(results):
    good = results[0]
    assert good['planned'] and good['executed'] and len(good['draws']) == 2, (
        good['reason'] or good['draws']
    )
    assert good['subgoals'] >= good['path_length'] > 1 and len(good['final_pose']) == 3
    assert sum(good['modes'].values()) > 0.5 and all(good[t] >= 0.0 for t in TIMES)


def test_an_error_is_told_as_an_error_and_spoils_nothing_else(results):
    bad, no_table = results[1:]
    assert not bad['planned'] and bad['reason'] == 'error' and 'object.mass: got -1' in bad['error']
    assert 'error' in no_table
    summary = summarize(results)
    assert (summary['tasks'], summary['planned'], summary['errors']) == (3, 1, 2)
    assert summary['runs'] == 2 and summary['sound'] == summary['executed_runs'] / 2
    assert set(summary['plan_ms']) == {'median', 'p95'}


def test_a_bug_is_never_called_infeasible(monkeypatch):
    def broken(*_, **__):
        raise ZeroDivisionError('a bug')

    monkeypatch.setattr('wholearm_ros.planner.legs.plan_and_verify', broken)
    result = run_task(SuiteEntry('good', HEXAGON), SuiteOptions())
    assert 'ZeroDivisionError: a bug' in result['error'] and result['reason'] == 'error'


def without_times(results):
    return [{k: v for k, v in r.items() if k not in TIMES} for r in results]


def test_processes_change_nothing_but_the_times(results):
    again = run_suite(tasks(), OPTIONS, jobs=2)
    assert without_times(again) == without_times(results)


def test_draws_depend_on_seed_task_and_number_only():
    def numbers(seed, name, k):
        return perturbation_rng(SuiteOptions(PlanRequest(seed=seed)), name, k).uniform(size=3)

    np.testing.assert_array_equal(numbers(1, 'a', 0), numbers(1, 'a', 0))
    for other in (numbers(2, 'a', 0), numbers(1, 'b', 0), numbers(1, 'a', 1)):
        assert not np.array_equal(numbers(1, 'a', 0), other)


def test_nothing_planned_is_neither_sound_nor_unsound():
    summary = summarize([run_task(SuiteEntry('bad', 3), SuiteOptions())])
    assert summary['sound'] is None and summary['plan_ms'] is None


@pytest.mark.parametrize(
    'text, words',
    [
        ('{', 'is not JSON'),
        ('[]', "allowed: 'wholearm-suite/1'"),
        ('{"format": "other/2"}', "got 'other/2'"),
        ('{"format": "wholearm-suite/1", "tasks": []}', 'at least one'),
        ('{"format": "wholearm-suite/1"}', 'tasks'),
        ('[' * 100000, 'is not JSON'),
    ],
)
def test_a_damaged_suite_file_is_refused(tmp_path, text, words):
    path = tmp_path / 'suite.json'
    path.write_text(text)
    with pytest.raises((DocumentError, ScenarioError)) as told:
        load_suite(path)
    assert words in str(told.value)


def test_tasks_without_a_name_get_one(tmp_path):
    path = tmp_path / 'suite.json'
    path.write_text(json.dumps({'format': 'wholearm-suite/1', 'tasks': [HEXAGON, {}, 7]}))
    assert [t.name for t in load_suite(path)] == ['asymmetric_hexagon', 'task 1', 'task 2']


def test_the_jury_is_counted_engine_by_engine_and_pair_by_pair():
    def draw(**executed):
        [missed] = [name for name, done in executed.items() if not done] or ['']
        found = [{'text': f'{missed} misses'}] if missed else []
        engines = {name: {'executed': done} for name, done in executed.items()}
        return {'executed': not missed, 'jury': {'engines': engines, 'disagreements': found}}

    draws = [draw(a=True, b=True, c=True), draw(a=True, b=False, c=True)]
    told = jury_summary([{'name': 'one', 'draws': draws}, {'name': 'no plan', 'draws': []}])
    assert told['executed'] == {'a': 2, 'b': 1, 'c': 2} and told['runs'] == 2
    assert [p['runs'] for p in told['agreement']] == [1, 2, 1]  # a and b, a and c, b and c
    assert told['disagreements'] == [{'task': 'one', 'draw': 1, 'text': 'b misses'}]
    assert 'one, draw 1: b misses' in jury_lines(told)


def test_a_run_before_the_jury_reaches_its_goal_only_when_it_does_in_every_engine():
    options = SuiteOptions(PlanRequest(candidates=3, moves=0), perturb=1.0, backend='jury')
    [result] = run_suite([SuiteEntry('good', HEXAGON)], options)
    [told] = result['draws']
    engines = told['jury']['engines']
    assert list(engines) == list(installed_backends())
    assert told['executed'] == all(engine['executed'] for engine in engines.values())
    json.dumps(result, allow_nan=False)
    assert summarize([result])['jury']['runs'] == 1
