"""The command line: exit codes, one clear message instead of a traceback, help that teaches."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from wholearm_ros.cli.main import app
from wholearm_ros.package_share import shipped_scenarios

CONFIG = Path(__file__).parents[2] / 'config'
HEXAGON = str(CONFIG / 'asymmetric_hexagon.yaml')


def wholearm(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments])


@pytest.mark.parametrize(
    'command', ['', 'plan', 'advise', 'simulate', 'map', 'suite', 'check-hand', 'version']
)
def test_help_names_an_example(command):
    told = wholearm(*command.split(), '--help')
    assert told.exit_code == 0
    if command != 'version':
        assert 'xample' in told.output and 'Exit codes' in told.output


def test_run_is_listed_without_importing_ros_for_other_commands():
    assert 'run' in wholearm('--help').output
    code = (
        'import sys; from typer.testing import CliRunner; from wholearm_ros.cli.main import app; '
        "CliRunner().invoke(app, ['version']); "
        "print([m for m in ('rclpy', 'pybullet', 'numba') if m in sys.modules])"
    )
    assert (
        subprocess.run([sys.executable, '-c', code], capture_output=True, text=True).stdout.strip()
        == '[]'
    )


@pytest.mark.parametrize(
    'missing, words',
    [('rclpy', 'a sourced ROS 2 Jazzy'), ('wholearm_ros.launcher.launcher', 'launcher')],
)
def test_run_says_what_cannot_be_imported_whatever_its_options(missing, words):
    code = (
        'import sys\nclass Block:\n    def find_spec(self, name, path=None, target=None):\n'
        f"        if name == {missing!r}: raise ImportError(name + ' is blocked', name=name)\n"
        'sys.meta_path.insert(0, Block())\nfrom wholearm_ros.cli.main import main\nmain()'
    )
    done = subprocess.run(
        [sys.executable, '-c', code, 'run', 'regular_hexagon', '--pacing', 'lockstep'],
        capture_output=True,
        text=True,
        timeout=100,
    )
    told = done.stderr.replace('\n', ' ')
    assert (
        done.returncode != 0
        and f'{missing} is blocked' in told
        and words in told
        and 'No such option' not in told
    )


@pytest.fixture
def bad(tmp_path):
    path = tmp_path / 'bad.yaml'
    path.write_text(Path(HEXAGON).read_text().replace('mass: 0.353', 'mass: -0.353'))
    return path


@pytest.mark.parametrize('arguments', [['plan'], ['simulate'], ['suite']])
def test_bad_input_is_exit_code_2_and_one_message(bad, arguments):
    for path in (bad, bad.parent / 'none.yaml', bad.parent):
        told = wholearm(*arguments, path)
        assert told.exit_code == 2 and 'Traceback' not in told.output
        assert str(path) in told.output.replace('\n', '')


def test_what_is_wrong_is_said(bad):
    told = wholearm('plan', bad)
    assert 'object.mass: got -0.353; allowed: greater than 0' in told.output.replace('\n', ' ')


@pytest.mark.parametrize(
    'arguments',
    [
        ['plan'],
        ['plan', HEXAGON, '--seed', '-1'],
        ['plan', HEXAGON, '--search', 'worst'],
        ['nothing'],
        ['plan', HEXAGON, '--json', '/nowhere/at/all.json'],
        ['suite', HEXAGON, '--jobs', '0'],
        ['simulate', HEXAGON, '--backend', 'gazebo'],
        ['simulate', HEXAGON, '--rate', '1'],
    ],
)
def test_bad_arguments_are_exit_code_2(arguments):
    assert wholearm(*arguments).exit_code == 2


@pytest.mark.parametrize('command', ['plan', 'simulate', 'run'])
def test_a_wrong_name_lists_the_shipped_scenarios(command):
    if command == 'run':
        pytest.importorskip('rclpy', reason='wholearm run needs ROS 2')
    told = wholearm(command, 'pentagon')
    assert told.exit_code == 2
    assert 'pentagon' in told.output and ', '.join(shipped_scenarios()) in told.output


def test_a_shipped_scenario_is_planned_by_its_name_and_the_verdict_comes_first():
    told = wholearm('plan', 'asymmetric_hexagon')
    assert told.exit_code == 0 and told.output.startswith('plan found: ')


def test_the_version_is_an_option_and_a_command():
    option, command = wholearm('--version'), wholearm('version')
    assert option.exit_code == 0 and option.output == command.output
    assert option.output.startswith('wholearm_ros')


@pytest.mark.parametrize('option', ['--run', '--json'])
def test_a_full_disk_is_blamed_on_the_option_whose_file_it_is(option):
    told = wholearm('simulate', HEXAGON, '--backend', 'planar', option, '/dev/full')
    assert told.exit_code == 2
    assert f'error: {option} /dev/full: cannot be written' in told.output.replace('\n', ' ')


def test_a_row_of_a_suite_is_in_the_pipe_before_the_next_task_is_done(tmp_path):
    from wholearm_ros.suite.suite_file import load_suite

    tasks = load_suite(CONFIG.parent / 'benchmarks' / 'suite.json')
    scenarios = [{'name': 'bad'}, *(task.scenario for task in tasks[:2])]
    file = tmp_path / 'suite.json'
    file.write_text(json.dumps({'format': 'wholearm-suite/1', 'tasks': scenarios}))
    command = [sys.executable, '-m', 'wholearm_ros', 'suite', file, '--backend', 'planar']
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        rows = [process.stdout.readline() for _ in ('heading', 'first task')]
        assert process.poll() is None
        rest = process.stdout.read()
    assert 'bad' in rows[1] and 'ERROR' in rows[1]
    assert 'asymmetric_hexagon' in rest and '3 tasks' in rest


def test_plan_then_simulate_from_the_document(tmp_path):
    out, told = tmp_path / 'plan.json', tmp_path / 'run.json'
    planned = wholearm('plan', HEXAGON, '--seed', 1, '--json', out)
    assert planned.exit_code == 0, planned.output
    assert json.loads(out.read_text())['format'] == 'wholearm-contact-plan/1'
    done = wholearm('simulate', out, '--json', told)
    assert done.exit_code == 0, done.output
    result = json.loads(told.read_text())
    assert result['executed'] and abs(result['angle_error']) <= 0.03


def test_a_changed_plan_document_is_refused(tmp_path):
    out = tmp_path / 'plan.json'
    wholearm('plan', HEXAGON, '--json', out)
    out.write_text(out.read_text().replace('0.353', '0.453'))
    told = wholearm('simulate', out)
    assert told.exit_code == 2 and 'Traceback' not in told.output


def test_no_plan_is_exit_code_1(tmp_path):
    """Motors too weak to lift the object: an honest no."""
    weak = tmp_path / 'weak.yaml'
    weak.write_text(Path(HEXAGON).read_text().replace('torque_limit: 7.0', 'torque_limit: 0.15'))
    document, figures = tmp_path / 'plan.json', tmp_path / 'figures'
    told = wholearm('plan', weak, '--time-budget', 3, '--json', document, '--figures', figures)
    assert told.exit_code == 1 and told.output.startswith('no plan')
    assert (figures / 'search.png').stat().st_size > 10_000
    assert wholearm('report', document).exit_code == 0
    page = document.with_suffix('.html').read_text()
    assert 'no plan (' in page and page.count('<svg') >= 1 and '{{' not in page


def test_suite_writes_its_results(tmp_path):
    from wholearm_ros.model.scenario_file import load_scenario, scenario_to_dict

    file, out = tmp_path / 'suite.json', tmp_path / 'out.json'
    file.write_text(
        json.dumps(
            {'format': 'wholearm-suite/1', 'tasks': [scenario_to_dict(load_scenario(HEXAGON))]}
        )
    )
    told = wholearm('suite', file, '--json', out)
    assert told.exit_code == 0, told.output
    document = json.loads(out.read_text())
    assert document['format'] == 'wholearm-suite-result/1' and document['summary']['planned'] == 1


def test_map_writes_what_can_be_turned(tmp_path, monkeypatch):
    monkeypatch.setenv('WHOLEARM_MAPS', str(tmp_path / 'maps'))
    file, page = tmp_path / 'map.json', tmp_path / 'map.html'
    done = wholearm(
        'map',
        HEXAGON,
        '--range',
        '0',
        '--time-budget',
        '1',
        '--jobs',
        '1',
        '--json',
        file,
        '--html',
        page,
    )
    document = json.loads(file.read_text())
    assert document['format'] == 'wholearm-map/1' and len(document['faces']) == 6
    assert len(document['edges']) + len(document['refused']) >= 12
    assert done.exit_code == (0 if document['edges'] else 1) and 'ordered pairs' in done.output
    assert '<h1>Face map' in page.read_text()


def test_no_plan_names_the_command_that_looks_for_a_change(tmp_path):
    told = wholearm('plan', HEXAGON, '--time-budget', '0')
    assert told.exit_code == 1 and f'wholearm advise {HEXAGON}' in told.output.replace('\n', '')


def test_advice_that_none_is_needed(tmp_path):
    out, saved = tmp_path / 'advice.json', tmp_path / 'same.json'
    told = wholearm('advise', HEXAGON, '--json', out, '--save', saved)
    assert told.exit_code == 0 and 'no change is needed' in told.output
    document = json.loads(out.read_text())
    assert document['format'] == 'wholearm-advice/1' and document['as_it_is']['works']
    assert document['tried'] == [] and document['change'] is None
    assert document['as_it_is']['certificate']['lower_bound'] >= 0.8
    assert wholearm('plan', saved).exit_code == 0


def test_advice_ends_with_its_budget():
    told = wholearm('advise', HEXAGON, '--time-budget', '0')
    assert told.exit_code == 1 and 'no change found' in told.output
