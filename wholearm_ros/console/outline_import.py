"""The outline in a drawing (SVG, DXF) as a polygon in mm, y up, counter-clockwise."""

import io
from collections.abc import Iterable, Iterator
from typing import Any

import ezdxf
import numpy as np
import svgelements
from ezdxf import edgeminer, edgesmith, units
from ezdxf.enums import InsertUnits
from ezdxf.path import make_path

from wholearm_ros.errors import WholeArmError
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.report.html.scene import numbers

PIXEL = 25.4 / 96.0  # [mm], as SVG defines it
SAGITTA = 0.2  # [mm] between a curve and its chords in a DXF
CHORDS = 8  # of a curve in an SVG
SAME = 0.05  # [mm] nearer points are one
STRAIGHT = 2e-3  # sine of a turn that is no corner
MOST_POINTS = 20_000
CLOSED = ('LWPOLYLINE', 'POLYLINE', 'CIRCLE', 'ELLIPSE', 'SPLINE')


def imported(kind: str, text: str) -> list[list[float]]:
    """Vertices [mm] of the largest outline in `text`, its lower left corner at the origin.

    kind: 'svg' or 'dxf'. Raises WholeArmError when there is none, or the drawing cannot be read.
    """
    try:
        outlines = list(_svg(text) if kind == 'svg' else _dxf(text))
    except WholeArmError:
        raise
    except Exception as error:  # of two foreign parsers, on whatever somebody drew
        raise WholeArmError(f'{kind}: cannot be read: {type(error).__name__}: {error}') from error
    outlines = [cleaned for points in outlines if len(cleaned := _cleaned(points)) >= 3]
    if not outlines:
        raise WholeArmError(f'{kind}: got no outline; allowed: a closed path with corners')
    best = max(outlines, key=lambda points: abs(Polygon(points).area))
    if Polygon(best).area < 0.0:
        best = best[::-1]
    rounded: list[list[float]] = numbers(best - best.min(axis=0), 3)
    return rounded


def _svg(text: str) -> Iterator[np.ndarray]:
    """Of every shape, with its transforms; SVG's y points down."""
    if '<!DOCTYPE' in text.upper() and '<!ENTITY' in text.upper():
        raise WholeArmError('svg: got entities; allowed: a drawing without')
    for element in svgelements.SVG.parse(io.StringIO(text), reify=True).elements():
        if isinstance(element, svgelements.Shape):
            for part in svgelements.Path(element).as_subpaths():
                points = list(_points(svgelements.Path(part)))
                if len(points) > MOST_POINTS:
                    raise WholeArmError(f'svg: got over {MOST_POINTS} points; allowed: fewer')
                if points:
                    yield np.array(points) * [PIXEL, -PIXEL]


def _points(path: Iterable[Any]) -> Iterator[tuple[float, float]]:
    """The ends of lines, and points on curves."""
    for segment in path:
        if isinstance(segment, (svgelements.Line, svgelements.Close, svgelements.Move)):
            if segment.end is not None:
                yield segment.end.x, segment.end.y
        else:
            for k in range(1, CHORDS + 1):
                point = segment.point(k / CHORDS)
                yield point.x, point.y


def _dxf(text: str) -> Iterator[np.ndarray]:
    """Of closed curves, and of lines and arcs that meet; without a unit, in mm."""
    document = ezdxf.read(io.StringIO(text))  # type: ignore[attr-defined]
    scale = _millimetres(document.units)
    space = document.modelspace()
    for entity in space:
        if entity.dxftype() in CLOSED and edgesmith.is_closed_entity(entity):
            yield _flat(make_path(entity), scale)
    edges = list(edgesmith.edges_from_entities_2d(space))
    for chain in edgeminer.find_all_simple_chains(edgeminer.Deposit(edges)) if edges else ():
        yield _flat(edgesmith.path2d_from_chain(chain), scale)


def _millimetres(unit: int) -> float:
    known = InsertUnits(unit) if unit else InsertUnits.Millimeters
    return float(units.conversion_factor(known, InsertUnits.Millimeters))


def _flat(path: Any, scale: float) -> np.ndarray:
    points = [(p.x * scale, p.y * scale) for p in path.flattening(SAGITTA / scale)]
    if len(points) > MOST_POINTS:
        raise WholeArmError(f'dxf: got over {MOST_POINTS} points; allowed: fewer')
    return np.array(points)


def _cleaned(points: np.ndarray) -> np.ndarray:
    """Without points that are given twice or lie on a straight edge."""
    kept: list[np.ndarray] = []
    for point in points:
        if not kept or np.hypot(*(point - kept[-1])) > SAME:
            kept.append(point)
    if len(kept) > 1 and np.hypot(*(kept[0] - kept[-1])) <= SAME:
        kept.pop()
    corners = np.array(kept).reshape(-1, 2)
    before, after = corners - np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0) - corners
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    sizes = np.hypot(*before.T) * np.hypot(*after.T)
    return corners[np.abs(cross) > STRAIGHT * sizes] if len(corners) > 2 else corners
