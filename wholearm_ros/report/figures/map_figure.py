"""The face map of an object: its faces in a ring with the turns between them, and from where each
turn can be made.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch

from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario import CCW, CW, Scenario
from wholearm_ros.planner.face_map import FaceMap, Refused, Turn, Way
from wholearm_ros.report.figures.canvas import new_figure
from wholearm_ros.report.figures.palette import INK, OBJECT, OBJECT_EDGE, SIDE_COLOURS
from wholearm_ros.report.figures.ring import outline_on_ring, ring_of_faces

TURN_COLOURS = {CCW: SIDE_COLOURS[0], CW: SIDE_COLOURS[1]}
NO_PLAN = '#e8e8e8'
THICKEST = 6.0  # [pt] of an arrow that always succeeds
MADE = 4.0  # [pt] of one along which a run went
FAINT = '#9a9a9a'  # of what could have been done
BENT = 0.22  # of an arrow: how far from straight, over its length


def draw_map(scenario: Scenario, face_map: FaceMap) -> Figure:
    """Left the ring, right the places at which the turns begin."""
    figure = new_figure(11.0, 5.4)
    ring = figure.add_axes((0.01, 0.02, 0.46, 0.9), aspect='equal')
    centres = _draw_faces(ring, scenario.object.polygon)
    for turn, way in face_map.best_turns().items():
        ring.add_patch(_arrow(centres, turn, _thickness(way.success_rate)))
    ring.set_title('turns from face to face: the thicker, the surer', fontsize=9, color=INK)
    places = figure.add_axes((0.56, 0.12, 0.42, 0.72))
    _draw_places(places, face_map)
    return figure


def draw_route(polygon: Polygon, known: Mapping[Turn, float], taken: Sequence[Turn]) -> Figure:
    """The ring with the turns that were made, numbered in order; known: success rates of those that
    could be made, drawn faintly.
    """
    figure = new_figure(5.4, 5.0)
    ring = figure.add_axes((0.01, 0.01, 0.98, 0.98), aspect='equal')
    centres = _draw_faces(ring, polygon)
    for turn, rate in known.items():
        if turn not in taken:
            ring.add_patch(_arrow(centres, turn, _thickness(rate) / 3.0, FAINT))
    for turn in dict.fromkeys(taken):
        ring.add_patch(_arrow(centres, turn, MADE))
        numbers = ', '.join(str(k) for k, other in enumerate(taken, 1) if other == turn)
        x, y = _beside(centres, turn)
        ring.text(x, y, numbers, ha='center', va='center', color=INK)
    return figure


def _beside(centres: dict[int, np.ndarray], turn: Turn) -> tuple[float, float]:
    """Beside the middle of a turn's arrow, on the outside of its bend."""
    start, end = centres[turn.start], centres[turn.end]
    along = end - start
    across = np.array([along[1], -along[0]])
    x, y = (start + end) / 2 + (BENT / 2 + 0.16 / np.linalg.norm(across)) * across
    return float(x), float(y)


def _draw_faces(axes: Any, polygon: Polygon) -> dict[int, np.ndarray]:
    """The object on each of its faces, in a ring; where, by face."""
    centres = ring_of_faces(polygon)
    shapes = [centre + outline_on_ring(polygon, face) for face, centre in centres.items()]
    axes.add_collection(PolyCollection(shapes, facecolors=OBJECT, edgecolors=OBJECT_EDGE, zorder=3))
    for face, (x, y) in centres.items():
        axes.text(x, y, str(face), ha='center', va='center', color=INK, zorder=4)
    axes.set(xlim=(-1.45, 1.45), ylim=(-1.4, 1.4))
    axes.axis('off')
    return centres


def _thickness(rate: float) -> float:
    return max(0.6, THICKEST * (2.0 * rate - 1.0))


def _arrow(
    centres: dict[int, np.ndarray], turn: Turn, thickness: float, colour: str = ''
) -> FancyArrowPatch:
    start, end = centres[turn.start], centres[turn.end]
    return FancyArrowPatch(
        (float(start[0]), float(start[1])),
        (float(end[0]), float(end[1])),
        connectionstyle=f'arc3,rad={BENT}',
        arrowstyle='-|>',
        mutation_scale=12,
        shrinkA=34,
        shrinkB=34,
        linewidth=thickness,
        color=colour or TURN_COLOURS[turn.direction],
        alpha=0.85,
    )


def _draw_places(axes: Any, face_map: FaceMap) -> None:
    """A row a face and direction, a column a place; the lower bound of the success rate in each."""
    ways: tuple[Way | Refused, ...] = (*face_map.ways, *face_map.refused)
    tried = [(w.start.edge, w.goal.direction, w.start.x) for w in ways if w.goal.direction]
    if not tried:
        axes.axis('off')
        return
    rows = sorted({(edge, direction) for edge, direction, _ in tried})
    columns = sorted({x for _, _, x in tried})
    bounds = np.full((len(rows), len(columns)), np.nan)
    for way in face_map.ways:
        if way.goal.direction:
            cell = rows.index((way.start.edge, way.goal.direction)), columns.index(way.start.x)
            bounds[cell] = way.certificate.lower_bound
    axes.set_facecolor(NO_PLAN)
    image = axes.imshow(bounds, cmap='viridis', vmin=0.75, vmax=1.0, aspect='auto')
    axes.figure.colorbar(image, ax=axes, label='success rate at least')
    axes.set_xticks(range(len(columns)), [f'{1e3 * x:+.0f}' for x in columns])
    axes.set_yticks(range(len(rows)), [f'{edge} {direction}' for edge, direction in rows])
    axes.set_xlabel('x of the centroid at the start [mm]')
    axes.set_title('from where it can be turned (grey: no plan)', fontsize=9, color=INK)
