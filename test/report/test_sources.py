"""A report is made from a bag alone, from a run document, or from results of a suite; anything else is refused in words."""

import json
import subprocess
import sys

import numpy as np
import pytest

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.errors import BagError, DocumentError, WholeArmError
from wholearm_ros.report.html.suite_page import success_interval, suite_page
from wholearm_ros.report.html.write import default_target, write_report
from wholearm_ros.report.run_document import read_run_document, run_document
from wholearm_ros.report.sources import read_source

SUITE = {
    'format': 'wholearm-suite-result/1',
    'suite': 's.json',
    'seed': 0,
    'perturb': 1.0,
    'draws': 2,
    'search': 'best',
    'transition': 'auto',
    'backend': 'pybullet',
    'rate': 1000.0,
    'time_budget': 1.0,
    'summary': {
        'tasks': 2,
        'planned': 1,
        'executed': 0,
        'errors': 0,
        'runs': 2,
        'executed_runs': 1,
        'sound': 0.5,
    },
    'tasks': [
        {
            'name': '<b>a',
            'planned': True,
            'reason': '',
            'plan_ms': 1.0,
            'generate_ms': 2.0,
            'verify_ms': 3.0,
            'subgoals': 5,
            'path_length': 3,
            'modes': {'caging': 1.0},
            'executed': False,
            'final_pose': [0, 0, 0],
            'draws': [
                {
                    'executed': True,
                    'reason': '',
                    'angle_error': 0.0,
                    'perturbation': {'mass': 0.01},
                },
                {
                    'executed': False,
                    'reason': 'fell',
                    'angle_error': 1.0,
                    'perturbation': {'mass': -0.01},
                },
            ],
        },
        {
            'name': 'b',
            'planned': False,
            'reason': 'exhausted',
            'plan_ms': 1.0,
            'generate_ms': None,
            'verify_ms': None,
            'subgoals': 5,
            'path_length': 0,
            'modes': {},
            'executed': False,
            'final_pose': None,
            'draws': [],
        },
    ],
}


def test_a_bag_tells_the_same_run_as_the_simulation(told, bag):
    plan, trajectory, run = told
    read_plan, read_trajectory, read = read_source(
        bag.parent if bag.name == 'mcap' else bag
    )  # a run's directory, or the bag
    assert (read_plan.id, read_trajectory.plan_id) == (plan.id, plan.id)
    assert read.times[0] == pytest.approx(run.times[0], abs=1e-6)
    rows = len(read.times)
    assert np.allclose(read.times, run.times[:rows], atol=1e-6)
    assert np.allclose(read.angles, run.angles[:rows]) and np.allclose(
        read.efforts, run.efforts[:rows]
    )
    assert (
        np.abs(read.poses - run.poses[:rows]).max(axis=0) < [2e-3, 2e-3, 0.03]
    ).all()  # 100 Hz, impacts between
    assert sum(a != b for a, b in zip(read.modes, run.modes)) <= 2 * len(trajectory.segments)
    assert read.judged.executed == run.judged.executed


def test_a_run_document_comes_back_as_it_was(made, told):
    plan, trajectory, record = made
    _, _, read = read_run_document(run_document(plan, trajectory, record, {'source': 'test'}))
    assert read.modes == told[2].modes and read.judged.executed == told[2].judged.executed
    assert np.allclose(read.angles, told[2].angles, atol=1e-6) and read.facts['source'] == 'test'


@pytest.mark.parametrize(
    'content', ['', '[]', '{"format": "other"}', '{"format": "wholearm-run/1"}', '\0\1']
)
def test_what_is_no_run_is_refused_in_words(tmp_path, content):
    path = tmp_path / 'run.json'
    path.write_text(content)
    with pytest.raises(DocumentError):
        read_source(path)


def test_a_bag_without_a_run_is_refused(tmp_path):
    with pytest.raises(WholeArmError):
        read_source(tmp_path / 'none')
    with pytest.raises(WholeArmError):
        read_source(tmp_path)
    (tmp_path / 'metadata.yaml').write_text('nonsense')
    with pytest.raises(BagError):
        read_source(tmp_path)


def test_reading_a_bag_needs_no_ros():
    code = (
        'import sys; import wholearm_ros.report.html.write; '
        "print([m for m in ('rclpy', 'pybullet', 'matplotlib.pyplot') if m in sys.modules])"
    )
    assert (
        subprocess.run(
            [sys.executable, '-c', code], capture_output=True, text=True, check=True
        ).stdout.strip()
        == '[]'
    )


def test_a_suite_page_escapes_names_and_counts_kinds():
    text = suite_page([SUITE, {**SUITE, 'perturb': 0.0}])
    data = json.loads(text.split('const REPORT = ')[1].split(';</script>')[0])
    assert [t['kind'] for t in data['tasks']] == ['partly', 'unplanned']
    assert [level['level'] for level in data['levels']] == [0.0, 1.0]
    with pytest.raises(DocumentError):
        suite_page([{'format': SUITE['format']}])


def test_a_run_and_a_suite_are_not_mixed(tmp_path, made):
    path, run = tmp_path / 's.json', tmp_path / 'run.json'
    path.write_text(json.dumps(SUITE))
    run.write_text(run_document(*made, {}))
    with pytest.raises(WholeArmError, match='one run'):
        write_report([run, path], tmp_path / 'x.html')
    assert default_target(path) == path.with_suffix('.html')


def test_two_bags_side_by_side_get_two_reports(tmp_path):
    for name in ('a', 'b'):
        (tmp_path / name).mkdir()
        (tmp_path / name / 'metadata.yaml').touch()
    assert default_target(tmp_path / 'a') == tmp_path / 'a.html'
    assert default_target(tmp_path / 'b') == tmp_path / 'b.html'


def test_success_interval_holds_the_share():
    for done, runs in ((0, 10), (3, 4), (10, 10)):
        low, high = success_interval(done, runs)
        assert -1e-9 <= low <= done / runs <= high <= 1.0 + 1e-9


def test_the_time_of_a_run_begins_after_the_ramp_that_it_was_run_with(bag_of_a_long_ramp, bag_mcap):
    assert read_source(bag_mcap)[2].times[0] == pytest.approx(-ControlOptions().ramp, abs=1e-3)
    assert read_source(bag_of_a_long_ramp)[2].times[0] == pytest.approx(-1.1, abs=1e-3)
