"""Drawn scenarios: checked with the place of what is wrong, saved, opened; outlines of drawings."""

import io

import ezdxf
import numpy as np
import pytest

from wholearm_ros.console.faces import faces
from wholearm_ros.console.outline import Scenarios, check
from wholearm_ros.console.outline_import import imported
from wholearm_ros.errors import WholeArmError
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario import StartOnEdge
from wholearm_ros.model.scenario_file import load_scenario, scenario_to_dict
from wholearm_ros.planner.face_map import FaceMap

PENTAGON = [[0.0, 0.0], [60.0, 0.0], [80.0, 50.0], [30.0, 90.0], [-20.0, 50.0]]  # [mm]


def drawn(points):
    told = scenario_to_dict(load_scenario('asymmetric_hexagon'))
    told['object']['vertices'] = [[x / 1000, y / 1000] for x, y in points]
    return {**told, 'start': {'edge': 0, 'x': 0.0}, 'goal': {'edge': 1}}


def test_a_sound_polygon_says_where_it_rests_and_whether_the_hand_reaches_it():
    told = check(drawn(PENTAGON))
    assert not told['problems'] and [f['edge'] for f in told['faces']] == [0, 1, 2, 3, 4]
    assert not any(f['reach'] for f in told['faces'])


def test_a_dent_is_said_with_its_place():
    (problem,) = check(drawn([*PENTAGON[:3], [30.0, 20.0], PENTAGON[4]]))['problems']
    assert 'not convex' in problem['text'] and problem['vertices'] == [3]


def test_crossing_edges_are_said_with_their_place():
    (problem,) = check(drawn([[0, 0], [60, 60], [60, 0], [0, 60]]))['problems']
    assert len(problem['edges']) == 2 and not problem['vertices']


def test_reach_is_said():
    told = check({**drawn([[0, 0], [4, 0], [4, 4], [0, 4]]), 'start': {'edge': 0, 'x': 0.14}})
    assert 'cannot touch' in told['problems'][0]['text']


def test_what_is_no_scenario_is_a_problem_not_an_exception():
    assert check({})['problems'] and check({'object': {'vertices': [[float('nan')]]}})['problems']


def test_a_saved_scenario_is_opened_again_and_not_overwritten_unasked(tmp_path):
    kept = Scenarios(tmp_path / 'mine')
    assert 'saved as' in kept.save('five', drawn(PENTAGON), over=False)
    assert kept.open('five')['object']['vertices'] == drawn(PENTAGON)['object']['vertices']
    assert kept.names()[0] == 'five' and 'regular_hexagon' in kept.names()
    with pytest.raises(WholeArmError, match='exists already'):
        kept.save('five', drawn(PENTAGON), over=False)
    kept.save('five', drawn(PENTAGON), over=True)
    with pytest.raises(WholeArmError, match='convex'):
        kept.save('bad', drawn([*PENTAGON[:3], [30.0, 20.0], PENTAGON[4]]), over=False)
    with pytest.raises(WholeArmError, match='not there'):
        kept.open('six')


def same_shape(found, wanted):
    """Up to a rotation of the list and a translation."""
    found, wanted = np.array(found), np.array(wanted)
    assert found.shape == wanted.shape, found
    wanted = wanted - wanted.min(axis=0)
    assert min(np.abs(np.roll(wanted, k, axis=0) - found).max() for k in range(len(found))) < 0.02
    assert Polygon(found).area > 0


def test_a_path_of_an_svg_is_its_polygon_in_millimetres():
    corners = ' '.join(f'{x},{100 - y}' for x, y in PENTAGON)
    text = f'<svg xmlns="http://www.w3.org/2000/svg" width="200mm" height="200mm" viewBox="0 0 200 200"><path d="M {corners} Z"/></svg>'
    same_shape(imported('svg', text), PENTAGON)
    same_shape(
        imported('svg', text.replace('<path d="M', '<polygon points="').replace(' Z"', '"')),
        PENTAGON,
    )


@pytest.mark.parametrize('unit, scale', [(4, 1.0), (6, 0.001), (1, 1 / 25.4)])
@pytest.mark.parametrize('as_lines', [False, True])
def test_an_outline_of_a_dxf_is_its_polygon_in_millimetres(unit, scale, as_lines):
    document = ezdxf.new()
    document.units = unit
    points = [(x * scale, y * scale) for x, y in PENTAGON]
    if as_lines:  # in any order and direction
        pairs = list(zip(points, points[1:] + points[:1]))
        for a, b in pairs[::2] + [(b, a) for a, b in pairs[1::2]]:
            document.modelspace().add_line(a, b)
    else:
        document.modelspace().add_lwpolyline(points, close=True)
    text = io.StringIO()
    document.write(text)
    same_shape(imported('dxf', text.getvalue()), PENTAGON)


@pytest.mark.parametrize('kind', ['svg', 'dxf'])
@pytest.mark.parametrize(
    'text',
    ['', 'nonsense', '<svg></svg>', '<!DOCTYPE x [<!ENTITY a "b">]><svg>&a;</svg>', '0\nSECTION\n'],
)
def test_what_is_no_drawing_is_refused(kind, text):
    with pytest.raises(WholeArmError, match=kind):
        imported(kind, text)


def test_faces_without_a_map_are_planned_when_asked_and_felt_first_where_nothing_is_known():
    scenario = load_scenario('asymmetric_hexagon')
    rows = faces(scenario, FaceMap(scenario.object.polygon.resting_edges), StartOnEdge(0, -0.02))
    assert [row['here'] for row in rows] == [True] + [False] * 5
    assert all('planned when asked' in row['told'] for row in rows[1:])
    rows = faces(scenario, FaceMap(()), None)
    assert all('felt first' in row['told'] for row in rows)
