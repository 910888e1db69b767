"""Scenario files: what is refused and how it is told; what is read is what was meant."""

import copy
import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from wholearm_ros.errors import ScenarioError
from wholearm_ros.mechanics.contacts import start_configuration
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario import GoalAtPose, GoalOnEdge, StartAtPose, StartOnEdge
from wholearm_ros.model.scenario_file import load_scenario, parse_scenario, scenario_to_dict
from wholearm_ros.model.start_checks import start_pose
from wholearm_ros.model.yaml_text import MAX_BYTES, parse_mapping

CONFIG = Path(__file__).parents[2] / 'config'
SHIPPED = ['asymmetric_hexagon', 'regular_hexagon']
BASE = scenario_to_dict(load_scenario(CONFIG / 'asymmetric_hexagon.yaml'))
V = BASE['object']['vertices']
NAN, INF = float('nan'), float('inf')
MISSING = object()
STAR = [[0.05 * np.cos(4 * np.pi * k / 5), 0.05 * np.sin(4 * np.pi * k / 5)] for k in range(5)]


def finger(**shape) -> dict:
    """The left finger of BASE with another shape."""
    rest = {k: v for k, v in BASE['hand']['left'].items() if k not in ('length', 'half_width')}
    return {**rest, **shape}


TAPER = [[0.0, -0.01], [0.15, -0.004], [0.15, 0.004], [0.0, 0.01]]
HOOK = [[0.128, -0.003], [0.140, -0.014], [0.149, -0.014], [0.147, -0.003]]
APART = [[0.16, -0.003], [0.17, -0.003], [0.17, 0.003]]


def changed(path: str, value) -> dict:
    """BASE with one key set, or removed."""
    document = copy.deepcopy(BASE)
    *parents, last = path.split('.')
    table = document
    for name in parents:
        table = table[name]
    if value is MISSING:
        del table[last]
    else:
        table[last] = value
    return document


BAD = [
    # path, value, key in the message, words in it
    ('object.vertices', V[::-1], 'object.vertices', 'clockwise'),
    ('object.vertices', [V[0], V[2], V[1], V[3]], 'object.vertices', 'cross'),
    ('object.vertices', STAR, 'object.vertices', 'cross'),
    ('object.vertices', V + V, 'object.vertices', 'cross'),
    (
        'object.vertices',
        V[:3] + [[0.03, 0.06]] + V[4:],
        'object.vertices',
        'not convex (at vertex 3)',
    ),
    (
        'object.vertices',
        [[0, 0], [0.05, 0], [0.1, 0], [0.05, 0.1]],
        'object.vertices',
        'degenerate',
    ),
    ('object.vertices', V[:1] + V, 'object.vertices', 'degenerate'),
    ('object.vertices', [[0, 0], [0.05, 0], [0.1, 1e-9]], 'object.vertices', 'degenerate'),
    ('object.vertices', V[:2], 'object.vertices', 'at least 3'),
    ('object.vertices', [[0, 0, 0]] + V[1:], 'object.vertices[0]', 'at most 2'),
    ('object.vertices', [[NAN, 0.0]] + V[1:], 'object.vertices[0][0]', 'finite'),
    ('object.vertices', [[INF, 0.0]] + V[1:], 'object.vertices[0][0]', ''),
    ('object.vertices', [['0', 0.0]] + V[1:], 'object.vertices[0][0]', "got '0'"),
    (
        'object.vertices',
        [[1000 * x, 1000 * y] for x, y in V],
        'object.vertices[1][0]',
        'less than or equal to 10',
    ),
    ('object.vertices', 'a hexagon', 'object.vertices', 'a list'),
    ('object.vertices', MISSING, 'object.vertices', 'missing'),
    ('object.mass', -0.3, 'object.mass', 'got -0.3; allowed: greater than 0'),
    ('object.mass', 0, 'object.mass', 'greater than 0'),
    ('object.mass', NAN, 'object.mass', 'nan'),
    ('object.mass', True, 'object.mass', 'a number'),
    ('object.weight', 1.0, 'object.weight', 'unknown key'),
    ('surprise', 1.0, 'surprise', 'unknown key'),
    ('hand.left', MISSING, 'hand.left', 'missing'),
    ('hand.left.length', 0.03, 'hand.left', 'cannot touch the object'),
    ('hand.right.length', 0.03, 'hand.right', 'cannot touch the object'),
    ('hand.right.axis', [0.5, -0.02], 'hand.right', 'cannot touch the object'),
    ('hand.left.angle_limits', [2.5, 3.0], 'hand.left', 'cannot touch the object'),
    ('hand.left.angle_limits', [3.0, 0.1], 'hand.left.angle_limits', 'lower one first'),
    ('hand.left.angle_limits', [0.1, 1.0], 'hand.left', 'even when open'),
    ('hand.left.half_width', 0.2, 'hand.left.half_width', 'less than the length'),
    ('hand.left.torque_limit', -7.0, 'hand.left.torque_limit', 'greater than 0'),
    ('hand.left.rotor_inertia', -1e-3, 'hand.left.rotor_inertia', 'greater than or equal to 0'),
    ('palm.vertices', [[0.15, 0.0], [-0.15, 0.0]], 'palm.vertices', 'left to right'),
    ('palm.vertices', [[0.15, 0.0]], 'palm.vertices', 'at least 2'),
    ('gravity.tilt_deg', 90.0, 'gravity.tilt_deg', 'less than 90'),
    ('gravity.tilt', 0.1, 'gravity.tilt', 'unknown key'),
    ('gravity.acceleration', 0.0, 'gravity.acceleration', 'greater than 0'),
    ('gravity', [], 'gravity', 'a table of keys'),
    ('start', 5, 'start', 'a table of keys'),
    ('start.edge', 6, 'start.edge', 'allowed: 0 to 5'),
    ('start.edge', 1.0, 'start.edge', 'a whole number'),
    ('start.edge', -1, 'start.edge', 'greater than or equal to 0'),
    ('start.x', 0.2, 'start.x', 'not over the palm'),
    ('start', {'edge': 0, 'x': 0.0, 'fingers': [1.5, 1.6]}, 'start.fingers', 'unknown key'),
    ('start', {'pose': [0.0, 0.058, 0.0]}, 'start.fingers', 'missing'),
    (
        'start',
        {'pose': [0.0, 0.04, 0.0], 'fingers': [2.5, 0.5]},
        'start',
        'penetrates the palm by 18.01 mm',
    ),
    (
        'start',
        {'pose': [0.0, 0.058014, 0.0], 'fingers': [1.0, 0.5]},
        'start.fingers[0]',
        'penetrates the object',
    ),
    (
        'start',
        {'pose': [0.0, 0.058014, 0.0], 'fingers': [2.5, 3.1]},
        'start.fingers[1]',
        'allowed: 0.05 to 3.09',
    ),
    ('goal.edge', 7, 'goal.edge', 'the object has 6 edges'),
    ('goal.direction', 'left', 'goal.direction', "'ccw' or 'cw'"),
    ('goal', {'direction': 'ccw'}, 'goal', 'neither an edge nor x'),
    ('goal', {'x': 1.0}, 'goal.x', 'not over the palm'),
    ('start', {'edge': 0}, 'start.x', 'missing'),
    ('start', {'felt': 'yes'}, 'start.felt', 'allowed: '),
    ('goal.x_tolerance', 0.01, 'goal.x_tolerance', 'without goal.x'),
    ('goal', {'edge': 5, 'direction': 'ccw', 'x': 1.0}, 'goal.x', 'not over the palm'),
    ('goal', {'pose': [0.0, 0.0, 1.0]}, 'goal', 'penetrates the palm'),
    ('goal', {'pose': [0.0, 0.1, 1.0], 'tolerance': [0.01, 0.01]}, 'goal.tolerance', 'at least 3'),
    ('name', 3, 'name', 'text'),
    ('hand.left', finger(), 'hand.left', 'without a shape; allowed: length and half_width, or'),
    ('hand.left.length', MISSING, 'hand.left.length', 'missing'),
    ('hand.left.vertices', TAPER, 'hand.left', 'got length and half_width and vertices; allowed'),
    ('hand.left', finger(vertices=TAPER, parts=[TAPER]), 'hand.left', 'got vertices and parts'),
    ('hand.left', finger(vertices=TAPER[::-1]), 'hand.left.vertices', 'clockwise'),
    ('hand.left', finger(vertices=TAPER[:2]), 'hand.left.vertices', 'at least 3'),
    (
        'hand.left',
        finger(vertices=[TAPER[k] for k in (0, 2, 1, 3)]),
        'hand.left.vertices',
        'cross',
    ),
    (
        'hand.left',
        finger(vertices=[*TAPER[:2], [0.1, 0.0], *TAPER[2:]]),
        'hand.left.vertices',
        'not convex (at vertex 2)',
    ),
    (
        'hand.left',
        finger(vertices=[[x + 0.005, y] for x, y in TAPER]),
        'hand.left.vertices',
        '5 mm beside its axis',
    ),
    (
        'hand.left',
        finger(vertices=[[-x, -y] for x, y in TAPER]),
        'hand.left.vertices',
        'x along the finger',
    ),
    ('hand.left', finger(parts=[]), 'hand.left.parts', 'at least 1'),
    ('hand.left', finger(parts=[TAPER, HOOK[::-1]]), 'hand.left.parts[1]', 'clockwise'),
    ('hand.left', finger(parts=[TAPER, APART]), 'hand.left.parts[1]', 'touches no other'),
    ('hand.left', finger(parts=[TAPER] * 9), 'hand.left.parts', 'at most 8'),
]


@pytest.mark.parametrize(
    'path, value, key, words', BAD, ids=[f'{k}-{b[0]}' for k, b in enumerate(BAD)]
)
def test_a_bad_scenario_is_refused_with_source_key_and_what_is_allowed(path, value, key, words):
    with pytest.raises(ScenarioError) as told:
        parse_scenario(changed(path, value), 'bad.yaml')
    lines = str(told.value).splitlines()
    assert any(line.startswith(f'bad.yaml: {key}: ') and words in line for line in lines), str(
        told.value
    )


def test_an_edge_that_cannot_carry_the_object_is_refused():
    tall = [[0.0, 0.0], [0.04, 0.0], [0.10, 0.09], [0.07, 0.10]]
    assert not Polygon(tall).can_rest_on(0)
    document = changed('object.vertices', tall)
    document['goal'] = {'edge': 0, 'direction': 'ccw'}
    with pytest.raises(
        ScenarioError, match=r'goal\.edge: got 0, on which the object cannot rest.*allowed: '
    ):
        parse_scenario(document)


@pytest.mark.parametrize('factor', [5.0, 10.0, 1.0 / 0.0254])
def test_an_object_in_another_unit_than_metres_is_told_so(factor):
    """An object of many times the hand's size was read, and broke the search."""
    vertices = (factor * np.array(BASE['object']['vertices'])).tolist()
    with pytest.raises(ScenarioError, match='span of the open hand .are the vertices in metres'):
        parse_scenario(changed('object.vertices', vertices))


def test_every_problem_is_told_not_only_the_first():
    document = changed('object.mass', -1)
    document['goal'] = {'edge': 'x'}
    document['zzz'] = 1
    with pytest.raises(ScenarioError) as told:
        parse_scenario(document, 'f')
    keys = [line.split(': ')[1] for line in str(told.value).splitlines()]
    assert keys == ['object.mass', 'goal.edge', 'zzz']


@pytest.mark.parametrize('name', SHIPPED)
def test_shipped_scenarios_turn_one_face_counter_clockwise(name):
    scenario = load_scenario(CONFIG / f'{name}.yaml')
    assert scenario.name == name
    assert (
        scenario.object.polygon.can_rest_on(scenario.start.edge)
        and scenario.goal.direction == 'ccw'
    )


@pytest.mark.parametrize('name', SHIPPED)
def test_round_trip_is_exact_through_json_and_yaml(name):
    document = scenario_to_dict(load_scenario(CONFIG / f'{name}.yaml'))
    for text in (json.dumps(document), yaml.safe_dump(document)):
        again = parse_scenario(parse_mapping(text, 'again'))
        assert scenario_to_dict(again) == document
        assert again.gravity.tilt == np.radians(document['gravity']['tilt_deg'])


@given(tilt=st.floats(0.0, 1.57), x=st.floats(-0.03, 0.03), mass=st.floats(1e-3, 50.0))
@settings(max_examples=60, deadline=None)
def test_numbers_survive_to_the_last_bit(tilt, x, mass):
    document = changed('object.mass', mass)
    document['start']['x'] = x
    document['gravity']['tilt_deg'] = float(np.degrees(tilt))
    scenario = parse_scenario(document)
    again = parse_scenario(scenario_to_dict(scenario))
    assert (again.gravity.tilt, again.start.x, again.object.mass) == (
        scenario.gravity.tilt,
        x,
        mass,
    )


def test_optional_keys_and_other_kinds_of_start_and_goal():
    document = changed('note', {'anything': ['goes', 1]})
    assert parse_scenario(document).goal == GoalOnEdge(5, 'ccw')
    document['goal'] = {'edge': 5, 'direction': 'ccw', 'x': 0.01, 'x_tolerance': 0.005}
    assert parse_scenario(document).goal == GoalOnEdge(5, 'ccw', 0.01, 0.005)
    document['goal'] = {'edge': 5}
    assert parse_scenario(document).goal == GoalOnEdge(5)
    document['goal'] = {'x': 0.01}
    slide = parse_scenario(document)
    assert slide.goal == GoalOnEdge(0, None, 0.01)
    assert parse_scenario(scenario_to_dict(slide)).goal == slide.goal
    document['start'] = {'pose': [-0.02, 0.0581, 0.0], 'fingers': [1.6, 1.9]}
    document['goal'] = {'pose': [0.0, 0.1, 1.1]}
    scenario = parse_scenario(document)
    assert isinstance(scenario.start, StartAtPose) and isinstance(scenario.goal, GoalAtPose)
    assert scenario_to_dict(parse_scenario(scenario_to_dict(scenario))) == scenario_to_dict(
        scenario
    )


@given(radii=st.lists(st.floats(0.03, 0.06), min_size=3, max_size=8), seed=st.integers(0, 99))
@settings(max_examples=60, deadline=None)
def test_random_polygons_are_accepted_when_convex_and_told_apart_when_not(radii, seed):
    n = len(radii)
    angles = 2 * np.pi * (np.arange(n) + 0.3 * np.random.default_rng(seed).uniform(-1, 1, n)) / n
    vertices = np.stack([np.cos(angles), np.sin(angles)], axis=1) * np.array(radii)[:, None]
    before, after = (
        vertices - np.roll(vertices, 1, axis=0),
        np.roll(vertices, -1, axis=0) - vertices,
    )
    sines = (before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]) / (
        np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    )
    document = changed('object.vertices', vertices.tolist())
    polygon = Polygon(vertices)
    stable = [k for k in range(n) if polygon.can_rest_on(k)]
    document['start']['edge'] = document['goal']['edge'] = stable[0] if stable else 0
    try:
        parse_scenario(document)
    except ScenarioError as error:
        assert sines.min() <= 1e-3 or 'object.vertices' not in str(error)
    else:
        assert sines.min() > 1e-3


def test_the_start_is_the_one_that_the_mechanics_find():
    for x in (-0.04, 0.0, 0.03):
        scenario = parse_scenario(changed('start', {'edge': 0, 'x': x}))
        np.testing.assert_allclose(
            start_pose(scenario), start_configuration(scenario)[:3], atol=1e-12
        )
    document = changed('palm.vertices', [[-0.15, 0.02], [-0.05, 0.0], [0.15, 0.04]])
    document['start'] = {'edge': 0, 'x': 0.05}
    scenario = parse_scenario(document)
    np.testing.assert_allclose(start_pose(scenario), start_configuration(scenario)[:3], atol=1e-12)
    assert isinstance(scenario.start, StartOnEdge)


# ---------------------------------------------------------------------- files
def write(tmp_path, text, name='s.yaml'):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize(
    'text, words',
    [
        ('object: [1, 2', 'is not YAML or JSON'),
        ('object: {}\nobject: {}', "key 'object' is given twice"),
        ('a: &a {b: 1}\nc: *a', 'alias'),
        ('', 'got nothing'),
        ('- 1\n- 2', 'got list'),
        (b'\xff\xfe\x00', 'UTF-8'),
        (b'\x00\x01', 'is not YAML or JSON'),
        ('x' * (MAX_BYTES + 1), 'at most'),
        ('a: !!python/object/apply:os.getcwd []', 'is not YAML or JSON'),
        ('[' * 5000, 'not'),
    ],
)
def test_a_file_that_is_no_scenario_is_refused_by_name(tmp_path, text, words):
    path = write(tmp_path, text)
    with pytest.raises(ScenarioError) as told:
        load_scenario(path)
    assert str(told.value).startswith(str(path)) and words in str(told.value)


def test_a_file_that_is_not_there_and_a_directory_are_refused(tmp_path):
    for path in (tmp_path / 'none.yaml', tmp_path):
        with pytest.raises(ScenarioError, match='cannot be read'):
            load_scenario(path)


def test_numbers_with_exponents_are_numbers(tmp_path):
    text = yaml.safe_dump(changed('object.mass', 123.0)).replace('123.0', '353e-3')
    assert load_scenario(write(tmp_path, text)).object.mass == 0.353
    assert (
        load_scenario(
            write(tmp_path, json.dumps(changed('object.mass', 1e-5)), 's.json')
        ).object.mass
        == 1e-5
    )


# ---------------------------------------------------------------------- anything at all
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3)
    ),
    max_leaves=6,
)
PATHS = sorted(
    {row[0] for row in BAD}
    | {'palm', 'hand', 'object', 'goal', 'gravity.acceleration', 'hand.left.mass'}
)


@given(path=st.sampled_from(PATHS), value=JSON | st.just(10**400) | st.just(-(10**400)))
@settings(max_examples=200, deadline=None)
def test_whatever_stands_at_a_key_is_either_read_or_refused(path, value):
    try:
        parse_scenario(changed(path, value))
    except ScenarioError as error:
        assert str(error).startswith('scenario: ')


@given(JSON)
@settings(max_examples=100, deadline=None)
def test_no_document_breaks_the_reader(value):
    with pytest.raises(ScenarioError):
        parse_scenario(value)


@given(st.text(max_size=60))
@settings(max_examples=100, deadline=None)
def test_no_text_breaks_the_reader(text):
    with pytest.raises(ScenarioError):
        parse_scenario(parse_mapping(text, 'text'), 'text')


@pytest.mark.parametrize(
    'shape', [{'vertices': TAPER}, {'parts': [TAPER, HOOK]}, {'parts': [TAPER, HOOK, HOOK]}]
)
def test_a_finger_s_shape_is_read_as_it_is_written(shape):
    document = changed('hand.left', finger(**shape))
    told = scenario_to_dict(parse_scenario(document))
    assert told['hand'] == document['hand']
    assert scenario_to_dict(parse_scenario(told)) == told
