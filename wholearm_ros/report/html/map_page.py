"""The page of a face map: the ring, the places, and every pair of faces with its route."""

from html import escape

from wholearm_ros.model.scenario import Scenario
from wholearm_ros.planner.face_map import FaceMap, Way
from wholearm_ros.report.figures.canvas import svg_text
from wholearm_ros.report.figures.map_figure import draw_map
from wholearm_ros.report.html.page import still_page, table


def map_page(scenario: Scenario, face_map: FaceMap) -> str:
    """One self-contained HTML file."""
    name = escape(scenario.name or 'object')
    body = (
        f'<main><h1>Face map: {name}</h1>'
        '<p>From which face to which the object can be turned in this hand. Every turn and slide '
        'is a plan that was certified on fresh perturbed samples, the start up to '
        f'{1e3 * max((w.reach for w in face_map.ways), default=0.0):.0f} mm off; between two of '
        'them the hand feels where the object lies.</p>'
        f'<figure>{svg_text(draw_map(scenario, face_map))}</figure>'
        f'<h2>Routes</h2>{_routes(face_map)}<h2>Ways</h2>{_ways(face_map)}</main>'
    )
    return still_page(f'Face map: {scenario.name}', body)


def _routes(face_map: FaceMap) -> str:
    rows = [
        [
            start.edge,
            f'{1e3 * start.x:+.0f}',
            face,
            f'{face_map.success_rate(route):.2f}',
            ', '.join(_step(way) for way in route),
        ]
        for start, face, route in face_map.all_pairs()
    ]
    return table(['from edge', 'x [mm]', 'to edge', 'success rate', 'route'], rows)


def _step(way: Way) -> str:
    if way.goal.direction is None:
        return f'slide to {1e3 * way.end.x:+.0f} mm'
    return f'{way.goal.direction} to {way.goal.edge}'


def _ways(face_map: FaceMap) -> str:
    rows = [
        [
            way.start.edge,
            f'{1e3 * way.start.x:+.0f}',
            _step(way),
            f'{1e3 * way.end.x:+.1f}',
            f'{way.certificate.survived} of {way.certificate.samples}',
            f'{way.certificate.lower_bound:.2f}',
            way.plan.id[:8],
        ]
        for way in face_map.ways
    ]
    head = ['edge', 'x [mm]', 'what', 'ends at x [mm]', 'survived', 'at least', 'plan']
    return table(head, rows)
