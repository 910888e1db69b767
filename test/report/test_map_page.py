"""The page of a face map: routes that can be played, all of it inside one file."""

import json
import re
from dataclasses import replace

from wholearm_ros.model.certificate import certificate
from wholearm_ros.model.scenario import CCW, GoalOnEdge, StartOnEdge
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.planner.face_map import FaceMap, Way
from wholearm_ros.planning.routes import plan
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
