"""The page of a face map: the ring, the places, and every route, to be played."""

from html import escape
from typing import Any

import numpy as np

from wholearm_ros.model.scenario import Scenario
from wholearm_ros.planner.face_map import FaceMap, Way
from wholearm_ros.report.figures.map_figure import draw_map
from wholearm_ros.report.figures.palette import MODE_COLOURS, MODE_NAMES
from wholearm_ros.report.html.figure import figure_in_page
from wholearm_ros.report.html.page import asset, page, table
from wholearm_ros.report.html.scene import numbers, scene
from wholearm_ros.trajectory.main_trajectory import generate

PERIOD = 0.05  # [s] between two rows of a way's motion


def map_page(scenario: Scenario, face_map: FaceMap) -> str:
    """One self-contained HTML file."""
    name = scenario.name or 'object'
    body = asset('map.html')
    reach = 1e3 * max((way.reach for way in face_map.ways), default=0.0)
    for key, value in (
        ('title', escape(name)),
        ('reach', f'{reach:.0f}'),
        ('picture', figure_in_page(draw_map(scenario, face_map))),
        ('routes', _routes(face_map)),
        ('ways', _ways(face_map)),
    ):
        body = body.replace('{{' + key + '}}', value)
    return page(f'Face map: {name}', body, _data(scenario, face_map), 'map.js', plots=False)


def _data(scenario: Scenario, face_map: FaceMap) -> dict[str, Any]:
    """What the page plays: the ways of all routes, and which of them a route takes."""
    pairs = face_map.all_pairs()
    starts = list(dict.fromkeys(start for start, _, _ in pairs))
    used = list(dict.fromkeys(way for _, _, route in pairs for way in route))
    motions = [_motion(way) for way in used]
    poses = np.vstack([pose for pose, _, _ in motions]) if motions else np.zeros((1, 3))
    angles = np.vstack([pair for _, pair, _ in motions]) if motions else np.zeros((1, 2))
    return {
        'period': PERIOD,
        'names': MODE_NAMES,
        'colours': MODE_COLOURS,
        'scene': scene(scenario, poses, angles),
        'starts': [{'edge': start.edge, 'x': start.x} for start in starts],
        'ways': [
            {
                'told': f'{_begin(way)}: {_step(way)}; {way.certificate}',
                'pose': numbers(pose * [1e3, 1e3, 180.0 / np.pi], 1),
                'angles': numbers(np.degrees(pair), 1),
                'modes': modes,
            }
            for way, (pose, pair, modes) in zip(used, motions)
        ],
        'routes': [
            {
                'start': starts.index(start),
                'face': face,
                'ways': [used.index(way) for way in route],
                'success_rate': face_map.success_rate(route),
            }
            for start, face, route in pairs
        ],
    }


def _motion(way: Way) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Planned poses (k, 3), angles (k, 2) and modes (k,) every PERIOD."""
    trajectory = generate(way.plan.scenario, way.plan)
    rows = np.arange(0, len(trajectory.poses), max(1, round(PERIOD / trajectory.period)))
    modes = [trajectory.segment_at(trajectory.period * k).mode for k in rows]
    return trajectory.poses[rows], trajectory.angles[rows], modes


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


def _begin(way: Way) -> str:
    return f'edge {way.start.edge} at {1e3 * way.start.x:+.0f} mm'


def _step(way: Way) -> str:
    if way.goal.direction is None:
        return f'slide to {1e3 * way.end.x:+.0f} mm'
    return f'{way.goal.direction} to edge {way.goal.edge}'


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
