"""The page of a face map: routes that can be played, all of it inside one file."""

import json
import re
from dataclasses import replace

import pytest
from matplotlib.colors import to_hex

from wholearm_ros.model.certificate import certificate
from wholearm_ros.model.outcomes import ABORTED, AT_GOAL, ELSEWHERE, SUCCEEDED, UNKNOWN
from wholearm_ros.model.scenario import CCW, GoalOnEdge, StartOnEdge
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.planner.face_map import FORMAT, FaceMap, Turn, Way
from wholearm_ros.planning.routes import plan
from wholearm_ros.report.bag_run import RecordedRuns
from wholearm_ros.report.figures.map_figure import FAINT, draw_route
from wholearm_ros.report.html.attempts_page import attempts_page, turn_of
from wholearm_ros.report.html.map_page import map_page

SCENARIO = load_scenario('asymmetric_hexagon')


def data_of(page):
    return json.loads(re.search(r'const REPORT = (.*);</script>', page)[1].replace('<\\/', '</'))


def test_a_route_is_shown_and_can_be_played():
    route = replace(plan(SCENARIO), certificate=certificate(1.0, 59, 58))
    turn = Way(StartOnEdge(0, -0.02), 0.006, GoalOnEdge(5, CCW), StartOnEdge(5, -0.02), route)
    page = map_page(SCENARIO, FaceMap((0, 1, 2, 3, 4, 5), (turn,)))
    data = data_of(page)
    assert [(r['start'], r['face'], r['ways']) for r in data['routes']] == [(0, 5, [0])]
    way = data['ways'][0]
    assert len(way['pose']) == len(way['angles']) == len(way['modes']) > 10
    assert len(page) < 500_000 and 'plotly' not in page.lower()


def test_an_empty_map_has_a_page():
    assert data_of(map_page(SCENARIO, FaceMap((0, 1))))['routes'] == []


def test_the_route_of_several_runs_is_marked_in_what_the_map_knows(told):
    plan, trajectory, run = told
    edge = {'from': {'edge': 5, 'x': 0.0}, 'to': {'edge': 4, 'x': 0.0}, 'direction': CCW}
    known = {'format': FORMAT, 'edges': [{**edge, 'survived': 50, 'samples': 59}]}
    again = (plan, trajectory, run)
    assert turn_of(plan) == Turn(0, 5, CCW)
    marked = [attempts_page(RecordedRuns((told, again), face_map=m)) for m in (known, {})]
    with_map, alone = (page.split('id="route"')[1].split('</details>')[0] for page in marked)
    assert '<svg' in alone and len(alone) < len(with_map)


@pytest.mark.parametrize(
    'motion, said',
    [
        ({'outcome': SUCCEEDED, 'claimed': AT_GOAL}, 'felt at the goal after 1 attempt'),
        ({'outcome': ABORTED, 'claimed': UNKNOWN}, 'not known whether it is at the goal'),
        ({'outcome': ABORTED, 'claimed': ELSEWHERE}, 'not at the goal after 1 attempt'),
    ],
)
def test_of_several_runs_it_is_said_only_what_the_hand_knows(told, motion, said):
    recorded = RecordedRuns((told, told), ({**motion, 'planned': True},))
    assert f'>{said}' in attempts_page(recorded)


def test_turns_that_were_made_are_numbered_and_those_that_might_have_been_are_faint():
    made, other = Turn(0, 5, CCW), Turn(5, 4, CCW)
    axes = draw_route(SCENARIO.object.polygon, {made: 0.9, other: 0.9}, [made, made]).axes[0]
    faces = [str(face) for face in SCENARIO.object.polygon.resting_edges]
    assert sorted(text.get_text() for text in axes.texts) == sorted([*faces, '1, 2'])
    faint, bold = axes.patches
    assert faint.get_linewidth() < bold.get_linewidth()
    assert to_hex(faint.get_edgecolor()) == FAINT != to_hex(bold.get_edgecolor())
