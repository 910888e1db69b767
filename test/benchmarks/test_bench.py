"""The benchmark runs, its kernels agree with their plain twins, its results can be compared; the suite file is the seed's."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from wholearm_ros.mechanics.contacts import start_configuration
from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.suite.suite_file import load_suite

BENCHMARKS = Path(__file__).parents[2] / 'benchmarks'


def python(script: str, *arguments) -> str:
    done = subprocess.run(
        [sys.executable, str(BENCHMARKS / script), *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=250,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope='module')
def measured(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp('bench') / 'a.json'
    python('bench.py', '--quick', '--tasks', '2', '--parts', 'kernels', 'suite', '--json', path)
    return path


def test_every_kernel_and_every_part_of_an_offer_is_measured(measured):
    rows = json.loads(measured.read_text())['rows']
    assert {
        'kernel.gap_table',
        'kernel.torque_range',
        'kernel.projection',
        'kernel.one_arc',
        'suite.plan_best',
        'suite.plan_random',
        'suite.generate',
        'suite.verify_nominal',
        'suite.verify_8_copies',
    } <= set(rows)
    assert all(r['ratio'] > 1.0 for name, r in rows.items() if name.startswith('kernel.'))
    assert rows['suite.plan_best']['n'] == 2 and 0.0 < rows['suite.generate']['median']


def test_comparing_divides_the_medians(measured, tmp_path):
    twice = json.loads(measured.read_text())
    for r in twice['rows'].values():
        r['median'] *= 2.0
    (tmp_path / 'b.json').write_text(json.dumps(twice))
    lines = python('bench.py', '--compare', measured, tmp_path / 'b.json').splitlines()
    assert sum(line.split()[-1] == '2.00' for line in lines if '.' in line) == len(twice['rows'])


def test_the_shipped_suite_is_the_one_its_script_makes(tmp_path):
    python('make_suite.py', '--out', tmp_path / 'suite.json')
    assert (tmp_path / 'suite.json').read_text() == (BENCHMARKS / 'suite.json').read_text()
    for task in load_suite(BENCHMARKS / 'suite.json'):
        start_configuration(parse_scenario(task.scenario))
