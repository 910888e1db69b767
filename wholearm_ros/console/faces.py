"""What the face map says of each face of the object, from where it lies now."""

from typing import Any

from wholearm_ros.model.scenario import Scenario, StartOnEdge
from wholearm_ros.planner.face_map import FaceMap


def faces(scenario: Scenario, face_map: FaceMap, place: StartOnEdge | None) -> list[dict[str, Any]]:
    """Every face in order: edge; rate, the success rate of the surest known route, None where the
    map knows none; told, in words.
    """
    routes = face_map.routes(place) if place else {}
    rows: list[dict[str, Any]] = []
    for edge in scenario.object.polygon.resting_edges:
        here, route = place is not None and place.edge == edge, routes.get(edge)
        rate = face_map.success_rate(route) if route else None
        if here:
            told = 'it lies here'
        elif place is None:
            told = 'felt first: where the object lies is not known'
        elif not route or rate is None:
            told = f'not on the map: planned when asked{_refusals(face_map, place, edge)}'
        else:
            told = f'{100 * rate:.0f} % by {len(route)} motion{"s" * (len(route) > 1)}'
        rows.append({'edge': edge, 'here': here, 'rate': rate, 'told': told})
    return rows


def _refusals(face_map: FaceMap, place: StartOnEdge, edge: int) -> str:
    tried = [r for r in face_map.refused if (r.start.edge, r.goal.edge) == (place.edge, edge)]
    return f'; {len(tried)} direct turns were tried in vain' if tried else ''


def map_line(face_map: FaceMap) -> str:
    """How much of the map there is."""
    if not face_map.ways and not face_map.refused:
        return 'no map yet'
    return f'{len(face_map.ways)} certified ways, {len(face_map.refused)} tried in vain'
