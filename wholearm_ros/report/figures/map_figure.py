"""The face map of an object: its faces in a ring with the turns between them, and from where each
turn can be made.
"""

from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch

from wholearm_ros.model.polygon import Polygon, rotated
from wholearm_ros.model.scenario import CCW, CW, Scenario
from wholearm_ros.planner.face_map import FaceMap, Refused, Way
from wholearm_ros.report.figures.canvas import new_figure
from wholearm_ros.report.figures.palette import INK, OBJECT, OBJECT_EDGE, SIDE_COLOURS

RING, SHAPE = 1.0, 0.26  # radius of the ring, and size of an object drawn on it
TURN_COLOURS = {CCW: SIDE_COLOURS[0], CW: SIDE_COLOURS[1]}
NO_PLAN = '#e8e8e8'
THICKEST = 6.0  # [pt] of an arrow that always succeeds


def draw_map(scenario: Scenario, face_map: FaceMap) -> Figure:
    """Left the ring, right the places at which the turns begin."""
    figure = new_figure(11.0, 5.4)
    ring = figure.add_axes((0.01, 0.02, 0.46, 0.9), aspect='equal')
    _draw_ring(ring, scenario.object.polygon, face_map)
    places = figure.add_axes((0.56, 0.12, 0.42, 0.72))
    _draw_places(places, face_map)
    return figure


def _draw_ring(axes: Any, polygon: Polygon, face_map: FaceMap) -> None:
    order = sorted(face_map.faces, key=polygon.resting_angle)
    angles = {face: 2 * np.pi * k / len(order) + np.pi / 2 for k, face in enumerate(order)}
    centres = {face: RING * np.array([np.cos(a), np.sin(a)]) for face, a in angles.items()}
    scale = SHAPE / np.linalg.norm(polygon.vertices_about_centroid, axis=1).max()
    shapes = [
        centres[face]
        + scale * rotated(polygon.vertices_about_centroid, polygon.resting_angle(face))
        for face in order
    ]
    axes.add_collection(PolyCollection(shapes, facecolors=OBJECT, edgecolors=OBJECT_EDGE, zorder=3))
    for face in order:
        axes.text(*centres[face], str(face), ha='center', va='center', color=INK, zorder=4)
    for (start, end, direction), way in _best_turns(face_map).items():
        axes.add_patch(_arrow(centres[start], centres[end], direction, way.success_rate))
    axes.set(xlim=(-1.45, 1.45), ylim=(-1.4, 1.4))
    axes.axis('off')
    axes.set_title('turns from face to face: the thicker, the surer', fontsize=9, color=INK)


def _arrow(start: np.ndarray, end: np.ndarray, direction: str, rate: float) -> FancyArrowPatch:
    return FancyArrowPatch(
        (float(start[0]), float(start[1])),
        (float(end[0]), float(end[1])),
        connectionstyle='arc3,rad=0.22',
        arrowstyle='-|>',
        mutation_scale=12,
        shrinkA=34,
        shrinkB=34,
        linewidth=max(0.6, THICKEST * (2.0 * rate - 1.0)),
        color=TURN_COLOURS[direction],
        alpha=0.85,
    )


def _best_turns(face_map: FaceMap) -> dict[tuple[int, int, str], Way]:
    """By faces and direction, the surest of all places."""
    best: dict[tuple[int, int, str], Way] = {}
    for way in face_map.ways:
        if way.goal.direction is None:
            continue
        key = way.start.edge, way.goal.edge, way.goal.direction
        if key not in best or way.success_rate > best[key].success_rate:
            best[key] = way
    return best


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
