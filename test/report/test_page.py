"""The page stands alone, and a real browser opens it: no errors, the slider moves the drawing, it fits every width."""

import json
import re

import numpy as np
import pytest

from wholearm_ros.model.scenario_file import scenario_to_dict
from wholearm_ros.report.html.page import page
from wholearm_ros.report.html.run_page import run_page
from wholearm_ros.report.html.suite_page import suite_page

from .test_sources import SUITE

WIDTHS = [(1280, 900), (390, 844)]  # [pixel] a desk, a phone


@pytest.fixture(scope='module')
def text(told):
    return run_page(*told)


def test_the_page_asks_for_nothing_from_outside(text):
    assert not re.findall(r'<(?:script|img|link|iframe)[^>]+(?:src|href)="(?!data:)', text)
    assert 'REPORT = ' in text and '{{' not in text.split('<script>')[0] and len(text) < 1.5e6


def test_data_cannot_end_its_script():
    assert (
        '</script><script>'
        not in page('t', '', {'name': '</script><script>alert(1)'}, 'suite.js').split('REPORT = ')[
            1
        ][:80]
    )


def test_the_page_holds_what_the_run_was(told, text):
    plan, trajectory, run = told
    data = json.loads(text.split('const REPORT = ')[1].split(';</script>')[0])
    assert len(data['times']) == len(data['pose']) == len(data['touches']) == len(data['torque'])
    assert data['times'][0] == pytest.approx(run.times[0], abs=1e-3)
    found = list(data['subgoal_times'].values())
    assert found == sorted(found) and len(found) == len(plan.path)
    for what in (
        plan.id,
        trajectory.segments[0].contacts[0],
        'asymmetric_hexagon',
        'numpy',
        'the object rests on its goal',
    ):
        assert what in text


def opened(browser, path, width, height):
    browser.execute_cdp_cmd('Network.enable', {})
    browser.execute_cdp_cmd(
        'Network.emulateNetworkConditions',
        {'offline': True, 'latency': 0, 'downloadThroughput': 0, 'uploadThroughput': 0},
    )
    browser.execute_cdp_cmd(
        'Emulation.setDeviceMetricsOverride',
        {'width': width, 'height': height, 'deviceScaleFactor': 1, 'mobile': width < 600},
    )
    browser.get(path.as_uri())
    assert browser.get_log('browser') == []
    assert browser.execute_script(
        'return document.documentElement.scrollWidth <= window.innerWidth'
    )


def theme(browser, scheme, plot='plots') -> tuple:
    """Colours of the page and of the plot's lines once the system's theme is `scheme`."""
    browser.execute_cdp_cmd(
        'Emulation.setEmulatedMedia',
        {'features': [{'name': 'prefers-color-scheme', 'value': scheme}]},
    )
    return tuple(
        browser.execute_async_script(
            'const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => done(['
            f"getComputedStyle(document.body).backgroundColor, getComputedStyle(document.querySelector('#{plot} .grid')).stroke])))"
        )
    )


SLIDE = (
    "const s = document.getElementById('time'); s.value = arguments[0]; s.dispatchEvent(new Event('input'));"
    "return [document.getElementById('object').getAttribute('transform'), document.getElementById('now').textContent]"
)
CURSOR = "return +document.querySelector('#plots .cursor').dataset.at"
KEYS = (
    "document.activeElement.dispatchEvent(new KeyboardEvent('keydown', {key: arguments[0], bubbles: true, cancelable: true}));"
    "return +document.getElementById('time').value"
)


@pytest.mark.parametrize('width, height', WIDTHS)
def test_the_slider_moves_the_drawing_and_the_cursor(browser, told, text, tmp_path, width, height):
    path, (plan, trajectory, _) = tmp_path / 'run.html', told
    path.write_text(text, encoding='utf-8')
    opened(browser, path, width, height)
    seen = [browser.execute_script(SLIDE, t) for t in (0.0, 1.0, trajectory.duration)]
    assert len({transform for transform, _ in seen}) == 3 and all(
        f'{t:.2f} s' in now for t, (_, now) in zip((0.0, 1.0), seen)
    )
    assert browser.execute_script(CURSOR) == pytest.approx(trajectory.duration, abs=0.01)
    light, dark = theme(browser, 'light'), theme(browser, 'dark')
    assert light[0] == 'rgb(255, 255, 255)' != dark[0] and light[1] != dark[1]
    browser.execute_script(SLIDE, 0.0)
    browser.execute_script(
        f"document.getElementById('subgoal-{plan.path[-1]}').dispatchEvent(new Event('click'))"
    )
    assert float(browser.execute_script("return document.getElementById('time').value")) > 1.0
    browser.execute_script(SLIDE, 0.0)
    browser.execute_script("document.getElementById('play').click()")
    assert browser.execute_async_script(
        "const done = arguments[0], s = document.getElementById('time');"
        'const wait = () => s.value > 0.1 ? done(true) : requestAnimationFrame(wait); wait()'
    )
    assert browser.get_log('browser') == []


def test_keys_step_play_and_choose_subgoals(browser, told, text, tmp_path):
    path, plan = tmp_path / 'run.html', told[0]
    path.write_text(text, encoding='utf-8')
    opened(browser, path, *WIDTHS[0])
    browser.execute_script(SLIDE, 1.0)
    assert browser.execute_script(KEYS, 'ArrowRight') == pytest.approx(1.05)
    assert browser.execute_script(KEYS, 'ArrowLeft') == pytest.approx(1.0)
    browser.execute_script(KEYS, ' ')
    assert browser.execute_script("return document.getElementById('play').textContent") == 'Pause'
    browser.execute_script(KEYS, ' ')
    browser.execute_script(f"document.getElementById('subgoal-{plan.path[0]}').focus()")
    assert browser.execute_script(KEYS, 'Enter') < 0.1
    browser.execute_script(f"document.getElementById('subgoal-{plan.path[-1]}').focus()")
    assert browser.execute_script(KEYS, 'Enter') > 1.0
    assert browser.get_log('browser') == []


HOVER = (
    "const svg = document.querySelector('#plots svg'), box = svg.getBoundingClientRect();"
    'svg.dispatchEvent(new PointerEvent(arguments[1], {clientX: box.left + arguments[0] * box.width, clientY: box.top + 40, bubbles: true}));'
    "return document.querySelector('#plots .tip').textContent"
)


@pytest.mark.parametrize('width, height', WIDTHS)
def test_a_plot_tells_its_values_and_a_press_goes_there(browser, text, tmp_path, width, height):
    path = tmp_path / 'run.html'
    path.write_text(text, encoding='utf-8')
    opened(browser, path, width, height)
    told = browser.execute_script(HOVER, 0.5, 'pointermove')
    assert 'time [s]' in told and 'planned' in told and 'executed' in told and 'mrad' in told
    browser.execute_script(HOVER.replace('PointerEvent', 'MouseEvent'), 0.5, 'click')
    at = browser.execute_script("return +document.getElementById('time').value")
    assert float(told.split()[2]) == pytest.approx(at, abs=0.015)
    clipped = "return [...document.querySelectorAll('.scroll')].filter(e => !e.id && e.scrollWidth > e.clientWidth).length"
    assert browser.execute_script(clipped) == 0
    assert browser.get_log('browser') == []


@pytest.fixture(scope='module')
def suite_text(told):
    plan, _, run = told
    rows = np.hstack([run.poses, run.angles])[::40]
    motion = {'period': 0.04, 'rows': rows.tolist(), 'modes': list(run.modes[::40])}
    first = {**SUITE['tasks'][0], 'motion': motion, 'scenario': scenario_to_dict(plan.scenario)}
    return suite_page([{**SUITE, 'tasks': [first, SUITE['tasks'][1]]}])


MOVE = (
    "const s = document.querySelector('#details input'); s.value = arguments[0]; s.dispatchEvent(new Event('input'));"
    "return [document.getElementById('object').getAttribute('transform'), document.querySelector('#details .chip').textContent]"
)


@pytest.mark.parametrize('width, height', WIDTHS)
def test_a_task_of_a_suite_opens_and_its_run_plays(browser, suite_text, tmp_path, width, height):
    path = tmp_path / 'suite.html'
    path.write_text(suite_text, encoding='utf-8')
    opened(browser, path, width, height)
    browser.execute_script("document.querySelector('#tiles button').click()")
    assert 'fell' in browser.execute_script("return document.getElementById('details').textContent")
    assert browser.execute_async_script(
        "const done = arguments[0], s = document.querySelector('#details input');"
        'const wait = () => s.value > 0.1 ? done(true) : requestAnimationFrame(wait); wait()'
    )
    seen = [browser.execute_script(MOVE, t) for t in (0.2, 2.0, 100.0)]
    assert (
        len({transform for transform, _ in seen}) == 3
        and seen[0][1] == 'dwell'
        and seen[2][1] == 'done'
    )
    assert browser.execute_script(
        'return document.documentElement.scrollWidth <= window.innerWidth'
    )
    assert theme(browser, 'light', 'times') != theme(browser, 'dark', 'times')
    assert browser.execute_script("return document.querySelectorAll('#times .bar').length") == 2
    assert browser.execute_script("return document.querySelector('#tiles .shape polygon') !== null")
    browser.execute_script("document.querySelectorAll('#tiles button')[1].click()")
    assert 'exhausted' in browser.execute_script(
        "return document.getElementById('details').textContent"
    )
    assert browser.execute_script("return document.querySelector('#details svg')") is None
    assert browser.get_log('browser') == []
