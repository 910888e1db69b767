"""The terminal's picture of a run: what it shows of an instant, in a real terminal of a real run, and lines without one."""

import io
import os
import pty
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

pytest.importorskip('rclpy', reason='needs ROS 2')

from wholearm_ros.launcher.drawing import draw_outlines
from wholearm_ros.launcher.live_view import BAR, draw_hand, moment_of, picture, torque_bar, view_on
from wholearm_ros.model.hand import CLOSING
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest


@pytest.fixture(scope='module')
def trajectory(config):
    return plan_and_verify(
        load_scenario(config / 'asymmetric_hexagon.yaml'), PlanRequest(samples=1)
    ).trajectory


def moment_at(trajectory, t):
    sample = trajectory.sample(t)
    return moment_of(trajectory, trajectory.segment_at(t).mode, t, sample.angles, sample.efforts)


def shown(renderable) -> str:
    console = Console(file=io.StringIO(), width=100)
    console.print(renderable)
    return console.file.getvalue()


def test_the_planned_torque_stands_in_the_shaded_range(trajectory):
    seen = 0
    for segment in (s for s in trajectory.segments if s.mode == 'quasi_static'):
        moment = moment_at(trajectory, 0.5 * (segment.start + segment.end))
        line = torque_bar(moment).plain
        assert len(line) == BAR and line.count('┃') == 1
        assert set(line.replace('┃', '▒').strip('·')) == {'▒'} and torque_bar(moment).plain.strip(
            '·'
        )
        assert moment.torque_range[0] <= moment.torque <= moment.torque_range[1]
        seen += 1
    assert seen >= 2


def test_a_torque_beyond_the_range_is_a_red_mark_beside_it(trajectory):
    segment = next(s for s in trajectory.segments if s.mode == 'quasi_static')
    moment = moment_at(trajectory, segment.end - 0.01)
    beyond = replace(moment, torque=moment.torque_range[1] + 0.5 * moment.highest)
    bar = torque_bar(beyond)
    assert bar.plain.index('┃') > bar.plain.rindex('▒')
    assert any('red' in str(span.style) for span in bar.spans)
    assert not any('red' in str(span.style) for span in torque_bar(moment).spans)


def test_the_picture_tells_mode_time_angles_and_roles(trajectory):
    t = 0.5 * trajectory.duration
    moment, segment = moment_at(trajectory, t), trajectory.segment_at(t)
    text = shown(picture('executing', moment))
    for word in (
        'executing',
        segment.mode.replace('_', '-'),
        f'{t:.2f} of {trajectory.duration:.2f} s',
        'velocity',
        'torque',
        *(f'{angle:.1f}°' for angle in np.degrees(moment.angles)),
    ):
        assert word in text
    assert (
        f'{CLOSING[segment.torque_finger] * trajectory.sample(t).efforts[segment.torque_finger]:+.2f} N m'
        in text
    )


def test_outlines_are_dots_of_braille():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) * 7.5
    assert draw_outlines([square], (0.0, 8.0, 0.0, 8.0), 4) == '⡏⠉⠉⢹\n⣇⣀⣀⣸'
    assert draw_outlines([square + 100.0], (0.0, 8.0, 0.0, 8.0), 4) == '⠀⠀⠀⠀\n⠀⠀⠀⠀'


def test_the_hand_is_drawn_and_moves(config, trajectory):
    scenario = load_scenario(config / 'asymmetric_hexagon.yaml')
    drawn = [
        draw_hand(scenario, trajectory, t, trajectory.sample(t).angles)
        for t in (0.0, 0.5 * trajectory.duration)
    ]
    assert drawn[0] != drawn[1]
    for text in drawn:
        assert all(len(line) == BAR for line in text.splitlines()) and text.strip('⠀\n')
    moment = replace(moment_at(trajectory, 0.5), drawing=drawn[0])
    assert drawn[0].splitlines()[1] in shown(picture('executing', moment))


def test_where_there_is_no_terminal_each_step_is_one_line():
    console = Console(file=io.StringIO(), width=200)
    with view_on(console) as view:
        for step in ('planning', 'planning', 'quasi_static [1]'):
            view(step, 0.5)
    assert console.file.getvalue() == 'planning\nquasi_static [1]\n'


def test_a_run_in_a_terminal_shows_its_torque(domain):
    """A pseudo-terminal of 120 columns; the reading end sees every picture that was drawn."""
    ours, theirs = pty.openpty()
    environment = {
        **os.environ,
        'ROS_DOMAIN_ID': domain,
        'TERM': 'xterm-256color',
        'COLUMNS': '120',
        'LINES': '40',
    }
    command = [
        sys.executable,
        '-m',
        'wholearm_ros',
        'run',
        '--backend',
        'planar',
        '--pacing',
        'lockstep',
        '--rate',
        '250',
    ]
    with subprocess.Popen(
        command, stdin=theirs, stdout=theirs, stderr=theirs, env=environment, close_fds=True
    ) as process:
        os.close(theirs)
        text = b''.join(iter(lambda: _read(ours), b'')).decode(errors='replace')
        assert process.wait(60) == 0, text[-2000:]
    os.close(ours)
    assert text.count('wholearm run') > 10 and '▒' in text and '┃' in text
    assert (
        ' quasi-static ' in text
        and ' caging ' in text
        and 'success' in text.split('wholearm run')[-1]
    )


def _read(descriptor) -> bytes:
    try:
        return os.read(descriptor, 65536)
    except OSError:  # Linux says so when the other end has been closed
        return b''
