"""README and docs: Python snippets run, commands exist with the options shown, links lead somewhere, images are small."""
import json
import re
import shlex
from pathlib import Path

import pytest
import typer

from wholearm_ros.cli import app
from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.model.yaml_text import parse_mapping

ROOT = Path(__file__).parents[2]
OWN = ('README.md', 'CONTRIBUTING.md', 'CHANGELOG.md', 'docs/concepts.md', 'docs/your_polygon.md', 'docs/your_hand.md',
       'docs/figures.md')
OTHERS = ('docs/ros.md', 'docs/faults.md')  # written beside these; each may come later


def blocks(language: str):
    return [pytest.param(text, id=f'{name}-{k}') for name in OWN for k, text in enumerate(
        re.findall(rf'```{language}\n(.*?)```', (ROOT / name).read_text(), flags=re.S))]


@pytest.mark.parametrize('snippet', blocks('python'))
def test_python_runs(snippet, tmp_path, monkeypatch):
    if 'drive_guard' in snippet:
        pytest.importorskip('rclpy', reason='wholearm_ros.ros needs ROS 2')
    (tmp_path / 'config').symlink_to(ROOT / 'config')
    monkeypatch.chdir(tmp_path)
    exec(compile(snippet, 'snippet', 'exec'), {'__name__': 'snippet'})


@pytest.mark.parametrize('snippet', blocks('yaml'))
def test_scenarios_are_accepted(snippet):
    parse_scenario(parse_mapping(snippet, 'snippet'), 'snippet')


def command_lines():
    return sorted({line.split('  #')[0].strip() for block in blocks('bash') for line in block.values[0].splitlines()
                   if line.strip()})


@pytest.mark.parametrize('line', command_lines())
def test_commands_parse(line):
    words = shlex.split(line, comments=True)
    if words[0] == 'wholearm':
        _parse(words[1:])
    elif words[0] == 'make':
        assert re.search(rf'^{words[1]}:', (ROOT / 'Makefile').read_text(), flags=re.M)
    elif words[0] == 'ros2':
        assert words[1] in ('run', 'launch', 'service')
        if words[1] == 'run':
            assert (ROOT / 'wholearm_ros' / 'nodes' / f'{words[3]}.py').exists()
        if words[1] == 'launch':
            assert (ROOT / 'launch' / words[3]).exists()
    else:
        assert (ROOT / words[0]).exists()


def _parse(words):
    group = typer.main.get_command(app)
    context = group.make_context('wholearm', list(words), resilient_parsing=True)
    command = group.get_command(context, words[0])
    assert command is not None, words[0]
    known = {option for parameter in command.params for option in parameter.opts}
    given = [word for word in words[1:] if word.startswith('-')]
    if words[0] == 'run' and '--pacing' not in known:
        pytest.skip('wholearm run needs ROS 2')
    assert set(given) <= known, set(given) - known


@pytest.mark.parametrize('name', OWN)
def test_links_lead_somewhere(name):
    here = (ROOT / name).parent
    for target in re.findall(r'\]\(([^)#]+?)\)', (ROOT / name).read_text()):
        path = (here / target).resolve()
        relative = path.relative_to(ROOT).as_posix()
        assert path.exists() or relative in OTHERS, f'{name}: {target}'


def test_images_are_used_and_small():
    text = ''.join((ROOT / name).read_text() for name in OWN)
    for image in (ROOT / 'docs' / 'images').iterdir():
        assert image.stat().st_size < 1 << 20 and f'images/{image.name}' in text


def test_layouts_name_topics_that_exist():
    channels = (ROOT / 'wholearm_ros' / 'ros' / 'channels.py').read_text()
    layout = (ROOT / 'config' / 'foxglove_layout.json').read_text()
    panels = set(json.loads(layout)['configById'])
    for topic in re.findall(r'/wholearm/([a-z_/]+)', layout + (ROOT / 'config' / 'wholearm.rviz').read_text()):
        assert f"'{topic}'" in channels
    assert set(re.findall(r'"((?:3D|Plot|RawMessages|DiagnosticSummary)![a-z]+)"', layout)) == panels
