"""Scenario files: YAML or JSON in, a Scenario out, with every problem reported at once."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from wholearm_ros.errors import ScenarioError
from wholearm_ros.model.finger_shape import FingerShape, Rectangle
from wholearm_ros.model.hand import SIDES, Finger, Hand, Palm
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario import (
    GoalAtPose,
    GoalOnEdge,
    Gravity,
    ManipulatedObject,
    Scenario,
    StartAtPose,
    StartOnEdge,
)
from wholearm_ros.model.scenario_checks import finger_shape, problems_with
from wholearm_ros.model.scenario_schema import (
    AT_POSE,
    ON_EDGE,
    FingerTable,
    GoalOnEdgeTable,
    ScenarioTable,
    StartOnEdgeTable,
)
from wholearm_ros.model.start_checks import problems_at_start
from wholearm_ros.model.yaml_text import read_mapping
from wholearm_ros.package_share import scenario_path


def load_scenario(path: str | Path) -> Scenario:
    """The scenario in the YAML or JSON file at `path`, or a shipped one by its name.

    Raises ScenarioError that lists every problem found.
    """
    found = scenario_path(path)
    return parse_scenario(read_mapping(found), source=str(found))


def parse_scenario(mapping: Mapping[str, Any], source: str = 'scenario') -> Scenario:
    """The scenario in `mapping` (the keys of a scenario file); `source` names it in messages.

    Raises ScenarioError that lists every problem found.
    """
    try:
        table = ScenarioTable.model_validate(mapping)
    except ValidationError as error:
        raise _refusal(source, [_told(dict(e)) for e in error.errors(include_url=False)]) from error
    problems = problems_with(table)
    if problems:
        raise _refusal(source, problems)
    scenario = _build(table)
    problems = problems_at_start(scenario)
    if problems:
        raise _refusal(source, problems)
    return scenario


def scenario_to_dict(scenario: Scenario) -> dict[str, Any]:
    """The keys of a scenario file; `parse_scenario` gives back the same numbers, bit by bit."""
    thing, gravity = scenario.object, scenario.gravity
    return {
        'name': scenario.name,
        'object': {'vertices': thing.polygon.vertices.tolist(), 'mass': thing.mass},
        'hand': {side: _finger_to_dict(scenario.hand[k]) for k, side in enumerate(SIDES)},
        'palm': {'vertices': scenario.palm.vertices.tolist()},
        'gravity': {'acceleration': gravity.acceleration, 'tilt_deg': _exact_degrees(gravity.tilt)},
        'start': _start_to_dict(scenario.start),
        'goal': _goal_to_dict(scenario.goal),
    }


def _build(table: ScenarioTable) -> Scenario:
    thing = ManipulatedObject(Polygon(np.array(table.object.vertices)), table.object.mass)
    hand = Hand(*(_finger(getattr(table.hand, side)) for side in SIDES))
    gravity = Gravity(table.gravity.acceleration, float(np.radians(table.gravity.tilt_deg)))
    palm = Palm(np.array(table.palm.vertices))
    start, goal = _start(table, thing.polygon), _goal(table)
    return Scenario(thing, hand, palm, gravity, start, goal, table.name)


def _finger(table: FingerTable) -> Finger:
    others = table.model_dump(exclude={'length', 'half_width', 'vertices', 'parts'})
    return Finger(shape=finger_shape(table), **others)


def _start(table: ScenarioTable, polygon: Polygon) -> StartOnEdge | StartAtPose:
    given = table.start.model_dump()
    if not isinstance(table.start, StartOnEdgeTable):
        return StartAtPose(**given)
    if table.start.edge is None:  # a simulated hand has to have it somewhere
        given['edge'] = polygon.resting_edges[0]
    given['x'] = given['x'] or 0.0
    return StartOnEdge(**given)


def _goal(table: ScenarioTable) -> GoalOnEdge | GoalAtPose:
    given = table.goal.model_dump()
    if not isinstance(table.goal, GoalOnEdgeTable):
        return GoalAtPose(**given)
    if table.goal.edge is None:  # along the palm
        assert isinstance(table.start, StartOnEdgeTable)
        given['edge'] = table.start.edge
    return GoalOnEdge(**given)


def _finger_to_dict(f: Finger) -> dict[str, Any]:
    return {
        'axis': f.axis.tolist(),
        **_shape_to_dict(f.shape),
        'mass': f.mass,
        'rotor_inertia': f.rotor_inertia,
        'angle_limits': f.angle_limits.tolist(),
        'torque_limit': f.torque_limit,
    }


def _shape_to_dict(shape: FingerShape) -> dict[str, Any]:
    if isinstance(shape, Rectangle):
        return {'length': shape.length, 'half_width': shape.half_width}
    if len(shape.parts) == 1:
        return {'vertices': shape.parts[0].tolist()}
    return {'parts': [part.tolist() for part in shape.parts]}


def _start_to_dict(start: StartOnEdge | StartAtPose) -> dict[str, Any]:
    if isinstance(start, StartOnEdge):
        told = {'edge': start.edge, 'x': start.x}
        return {**told, 'felt': True} if start.felt else told
    return {'pose': start.pose.tolist(), 'fingers': start.fingers.tolist()}


def _goal_to_dict(goal: GoalOnEdge | GoalAtPose) -> dict[str, Any]:
    if isinstance(goal, GoalAtPose):
        return {'pose': goal.pose.tolist(), 'tolerance': goal.tolerance.tolist()}
    optional = {'direction': goal.direction, 'x': goal.x, 'x_tolerance': goal.x_tolerance}
    return {
        'edge': goal.edge,
        **{k: v for k, v in optional.items() if v is not None},
    }


def _exact_degrees(angle: float) -> float:
    """Degrees whose conversion gives back exactly `angle` [rad], the shortest such number."""
    near = float(np.degrees(angle))
    candidates = [round(near, 12), near, np.nextafter(near, -np.inf), np.nextafter(near, np.inf)]
    return float(next((c for c in candidates if float(np.radians(c)) == angle), near))


def _refusal(source: str, problems: list[str]) -> ScenarioError:
    return ScenarioError('\n'.join(f'{source}: {p}' for p in problems))


def _told(error: dict[str, Any]) -> str:
    """One line of ours for one error of pydantic's: key, what was got, what is allowed."""
    key = _key(error['loc'])
    kind, context = error['type'], error.get('ctx', {})
    if kind == 'missing':
        return f'{key}: missing; this key is needed'
    if kind == 'extra_forbidden':
        return f'{key}: unknown key; got {_shown(error["input"])}'
    allowed = {
        'finite_number': 'a finite number',
        'float_type': 'a number',
        'int_type': 'a whole number',
        'string_type': 'text',
        'list_type': 'a list',
        'model_type': 'a table of keys',
        'literal_error': context.get('expected'),
    }.get(kind)
    return f'{key}: got {_shown(error["input"])}; allowed: {allowed or _lower_first(error["msg"])}'


def _key(loc: tuple[int | str, ...]) -> str:
    text = ''
    for part in loc:
        if isinstance(part, int):
            text += f'[{part}]'
        elif part not in (ON_EDGE, AT_POSE):
            text += f'.{part}' if text else str(part)
    return text


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + '...'


def _lower_first(message: str) -> str:
    for prefix in ('Input should be ', 'Input should have ', 'Value error, '):
        message = message.removeprefix(prefix)
    return message[:1].lower() + message[1:]
