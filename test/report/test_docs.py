"""README and docs: Python snippets run, commands exist with the options shown, links lead somewhere, images are small."""

import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import get_args

import pytest
import typer
from conftest import fresh_domain
from pydantic import BaseModel

import wholearm_ros as wa
from wholearm_ros.cli.main import app
from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.model.scenario_schema import ScenarioTable
from wholearm_ros.model.yaml_text import parse_mapping

from .test_sources import SUITE

ROOT = Path(__file__).parents[2]
OWN = (
    'README.md',
    'CONTRIBUTING.md',
    'CHANGELOG.md',
    'docs/concepts.md',
    'docs/index.md',
    'docs/your_polygon.md',
    'docs/scenario.md',
    'docs/gallery.md',
    'docs/your_hand.md',
    'docs/faces.md',
    'docs/console.md',
    'docs/figures.md',
    'docs/performance.md',
    'bags/README.md',
)
LAYOUT = ROOT / 'config' / 'foxglove_layout.json'
OTHERS = ('docs/ros.md', 'docs/faults.md')  # written beside these; each may come later


# The graph at 250 Hz instead of 1000, on the planar stand-in; a map of few places, each given up soon.
SOONER = {
    'run': ['--rate', '250', '--backend', 'planar'],
    'map': ['--range', '0', '--time-budget', '5'],
}


LASTING = ('console',)  # until Ctrl-C: test/ros/test_console.py runs it


def blocks(language: str):
    return [
        pytest.param(text, id=f'{name}-{k}')
        for name in OWN
        for k, text in enumerate(
            re.findall(rf'```{language}\n(.*?)```', (ROOT / name).read_text(), flags=re.S)
        )
    ]


@pytest.mark.parametrize('snippet', blocks('python'))
def test_python_runs(snippet, tmp_path, monkeypatch):
    for directory in ('config', 'bags'):
        (tmp_path / directory).symlink_to(ROOT / directory)
    monkeypatch.chdir(tmp_path)
    exec(compile(snippet, 'snippet', 'exec'), {'__name__': 'snippet'})


@pytest.mark.parametrize('snippet', blocks('yaml'))
def test_scenarios_are_accepted(snippet):
    parse_scenario(parse_mapping(snippet, 'snippet'), 'snippet')


def command_lines():
    return sorted(
        {
            line.split('  #')[0].strip()
            for block in blocks('bash')
            for line in block.values[0].splitlines()
            if line.strip()
        }
    )


@pytest.mark.parametrize('line', command_lines())
def test_commands_parse(line):
    words = shlex.split(line, comments=True)
    if words[0] == 'wholearm':
        _parse(words[1:])
    elif words[0] == 'make':
        assert re.search(rf'^{words[1]}:', (ROOT / 'Makefile').read_text(), flags=re.M)
    elif words[0] == 'python':
        told = subprocess.run(
            [sys.executable, ROOT / words[1], '--help'], capture_output=True, text=True, timeout=100
        ).stdout
        assert all(word in told for word in words[2:] if word.startswith('-'))
    elif words[0] == 'dask':
        assert words[1] in ('scheduler', 'worker')
    elif words[0] == 'ros2':
        assert words[1] in ('run', 'launch', 'service')
        if words[1] == 'run':
            assert (ROOT / 'wholearm_ros' / 'nodes' / f'{words[3]}.py').exists()
        if words[1] == 'launch':
            assert (ROOT / 'launch' / words[3]).exists()
    else:
        assert (ROOT / words[0]).exists()


@pytest.mark.parametrize(
    'name',
    [
        name
        for name in OWN
        if 'wholearm '
        in ''.join(re.findall(r'```bash\n(.*?)```', (ROOT / name).read_text(), flags=re.S))
    ],
)
def test_wholearm_commands_run_one_after_the_other(name, bag_mcap, tmp_path):
    """As a reader would: in a directory with config/, benchmarks/ (a short suite) and what the page tells to be there."""
    for directory in ('config', 'bags'):
        (tmp_path / directory).symlink_to(ROOT / directory)
    (tmp_path / 'benchmarks').mkdir()
    suite = json.loads((ROOT / 'benchmarks' / 'suite.json').read_text())
    (tmp_path / 'benchmarks' / 'suite.json').write_text(
        json.dumps({**suite, 'tasks': suite['tasks'][:1]})
    )
    (tmp_path / 'my_pentagon.yaml').write_text(
        re.findall(r'```yaml\n(.*?)```', (ROOT / 'docs/your_polygon.md').read_text(), flags=re.S)[0]
    )
    if name != 'README.md':  # there, a command makes it
        (tmp_path / 'runs').mkdir()
        (tmp_path / 'runs' / 'first').symlink_to(bag_mcap)
    for result in ('nominal.json', 'perturbed.json'):
        (tmp_path / result).write_text(json.dumps(SUITE))
    environment = {
        **os.environ,
        'WHOLEARM_MAPS': str(tmp_path / 'maps'),
        'ROS_DOMAIN_ID': fresh_domain(),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
    }
    for block in re.findall(r'```bash\n(.*?)```', (ROOT / name).read_text(), flags=re.S):
        for line in block.splitlines():
            words = shlex.split(line, comments=True)
            if words[:1] == ['wholearm'] and words[1] not in LASTING and '--scheduler' not in words:
                sooner = SOONER.get(words[1], [])
                done = subprocess.run(
                    [sys.executable, '-m', 'wholearm_ros', *words[1:], *sooner],
                    cwd=tmp_path,
                    env=environment,
                    capture_output=True,
                    text=True,
                    timeout=200,
                )
                assert done.returncode == 0, f'{line}\n{done.stdout[-2000:]}{done.stderr[-2000:]}'


def _parse(words):
    group = typer.main.get_command(app)
    context = group.make_context('wholearm', list(words), resilient_parsing=True)
    _, command, _ = group.resolve_command(context, list(words))
    assert command is not None, words[0]
    params = command.params
    known = {option for p in params for option in (*p.opts, *p.secondary_opts)}
    given = [word for word in words[1:] if word.startswith('-')]
    if words[0] == 'run' and '--pacing' not in known:
        pytest.skip('wholearm run needs ROS 2')
    assert set(given) <= known, set(given) - known


@pytest.mark.parametrize('name', OWN)
def test_links_lead_somewhere(name):
    here = (ROOT / name).parent
    for target in re.findall(r'\]\((?!https://)([^)#]+?)\)', (ROOT / name).read_text()):
        path = (here / target).resolve()
        relative = path.relative_to(ROOT).as_posix()
        assert path.exists() or relative in OTHERS, f'{name}: {target}'


def test_images_are_used_and_small():
    text = ''.join((ROOT / name).read_text() for name in OWN)
    images = ROOT / 'docs' / 'images'
    for image in images.rglob('*.*'):
        assert image.stat().st_size < 1 << 20
        assert f'images/{image.relative_to(images).as_posix()}' in text


def test_the_documentation_builds_as_a_site_without_a_dead_link(tmp_path):
    pytest.importorskip('mkdocs', reason='mkdocs-material is not installed')
    site = tmp_path / 'site'
    done = subprocess.run(
        [sys.executable, '-m', 'mkdocs', 'build', '-q', '--strict', '-d', site],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=250,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    api = (site / 'api.html').read_text()
    assert all(name in api for name in wa.__all__)
    assert 'The first plan that is certified' in api  # a docstring
    assert not re.findall(r'<(?:script|link)[^>]+(?:src|href)="https?:', api)


def test_every_key_of_a_scenario_is_in_the_reference():
    text = re.sub(r'```.*?```', '', (ROOT / 'docs' / 'scenario.md').read_text(), flags=re.S)

    def keys(model):
        for key, field in model.model_fields.items():
            yield key
            for part in (field.annotation, *get_args(field.annotation)):
                if isinstance(part, type) and issubclass(part, BaseModel):
                    yield from keys(part)
                for inner in get_args(part):
                    if isinstance(inner, type) and issubclass(inner, BaseModel):
                        yield from keys(inner)

    named = set(re.findall(r'[a-z_]+', ' '.join(re.findall(r'`([^`]+)`', text))))
    found = set(keys(ScenarioTable))
    assert {'x_tolerance', 'felt', 'fingers', 'rotor_inertia', 'tilt_deg'} <= found <= named


def test_layouts_name_topics_that_exist():
    channels = (ROOT / 'wholearm_ros' / 'ros' / 'interface' / 'channels.py').read_text()
    for text in (LAYOUT.read_text(), (ROOT / 'config' / 'wholearm.rviz').read_text()):
        named = re.findall(r'/wholearm/([a-z_/]+)', text)
        assert named and all(f"'{topic}'" in channels for topic in named)


def test_the_foxglove_layout_is_of_the_shape_that_is_imported():
    """The keys of an exported layout, every panel placed once, the hand a layer of its own that follows the joints."""
    layout = json.loads(LAYOUT.read_text())
    assert {'configById', 'globalVariables', 'userNodes', 'playbackConfig', 'layout'} == set(layout)
    placed = []

    def walk(node):
        if isinstance(node, str):
            return placed.append(node)
        assert node['direction'] in ('row', 'column')
        walk(node['first'])
        walk(node['second'])

    walk(layout['layout'])
    assert sorted(placed) == sorted(layout['configById'])
    hand = layout['configById']['3D!scene']['layers']['hand']
    assert (
        hand['layerId'] == 'foxglove.Urdf'
        and hand['sourceType'] == 'topic'
        and hand['controlMode'] == 'jointStates'
    )


# ros2/rviz: rviz_default_plugins/plugins_description.xml, rviz_common's panel_factory.cpp.
RVIZ = {
    *(f'rviz_common/{name}' for name in ('Displays', 'Time')),
    *(
        f'rviz_default_plugins/{name}'
        for name in ('Grid', 'RobotModel', 'MarkerArray', 'PoseWithCovariance', 'TF')
    ),
    *(f'rviz_default_plugins/{name}' for name in ('MoveCamera', 'Measure', 'TopDownOrtho')),
}
# Lichtblick, packages/suite-base/src/panels: the keys of a panel's configuration.
FOXGLOVE = {
    '3D': 'cameraState followTf followMode scene publish transforms topics layers imageMode',
    'Plot': 'paths showLegend legendDisplay showPlotValuesInLegend showXAxisLabels showYAxisLabels '
    'isSynced xAxisVal sidebarDimension foxglovePanelTitle',
    'StateTransitions': 'paths isSynced',
    'RawMessages': 'topicPath diffEnabled diffMethod diffTopicPath showFullMessageForDiff',
    'DiagnosticSummary': 'topicToRender minLevel pinnedIds hardwareIdFilter sortByLevel',
}


def test_the_viewers_files_name_what_the_viewers_have():
    text = (ROOT / 'config' / 'wholearm.rviz').read_text()
    assert set(re.findall(r'Class: (\w+/\w+)', text)) == RVIZ
    for name, config in json.loads(LAYOUT.read_text())['configById'].items():
        assert set(config) <= set(FOXGLOVE[name.partition('!')[0]].split()), name


def test_paths_of_the_foxglove_layout_are_fields_of_the_messages():
    channels = pytest.importorskip('wholearm_ros.ros.interface.channels', reason='needs ROS 2')
    types = {topic.name: topic.type for topic in channels.TOPICS}
    panels = json.loads(LAYOUT.read_text())['configById'].values()
    paths = [path['value'] for panel in panels for path in panel.get('paths', ())]
    for path in paths:
        topic, name = re.fullmatch(r'/wholearm/([a-z_/]+)\.([a-z]+)(?:\[\d\])?', path).groups()
        assert name in types[topic].get_fields_and_field_types(), path
    assert len(paths) >= 7
