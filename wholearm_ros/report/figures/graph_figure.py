"""Figure 6: the contact-state transition graph."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import Collection, LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from wholearm_ros.model.plan import ContactPlan, Subgoal
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.report.figures.canvas import new_figure
from wholearm_ros.report.figures.graph_layout import GraphLayout, lay_out
from wholearm_ros.report.figures.outlines import contact_marks, hand_outlines, object_outline
from wholearm_ros.report.figures.palette import (
    INK,
    OBJECT,
    OBJECT_EDGE,
    PALM,
    PLANNED,
    SIDE_COLOURS,
)

CELL = 1.25  # [inch] width of a subgoal's drawing
HEADER = 0.2  # [inch] above it, for its number and direction
GAP_X, GAP_Y = 0.36, 0.16
NORMAL = 0.024  # [m] length at which a contact normal is drawn
MARGIN = np.array([0.045, 0.02])  # [m] seen around the object
WIDE = 8  # columns beside which the caption has room on one line
ROTATION = {1: '↺', -1: '↻', 0: ''}
Place = tuple[float, float]  # x to the right, y downwards [inch]


@dataclass(frozen=True)
class Cell:
    """What is seen in the drawing of every subgoal: left, right, bottom, top [m]."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def scale(self) -> float:
        """[inch/m]."""
        return CELL / (self.right - self.left)

    @property
    def tall(self) -> float:
        """[inch] with its header."""
        return self.scale * (self.top - self.bottom) + HEADER

    def put(self, points: np.ndarray, place: Place) -> np.ndarray:
        """(k, 2) [inch] of points (k, 2) [m] in the drawing whose upper left corner is `place`."""
        across = place[0] + (points[:, 0] - self.left) * self.scale
        return np.column_stack([across, place[1] + HEADER + (self.top - points[:, 1]) * self.scale])


def draw_graph(plan: ContactPlan, layout: GraphLayout | None = None) -> Figure:
    """Subgoals as small drawings, reachable ones joined, the route from X_init to X_goal thick and
    red.
    """
    layout = layout or lay_out(plan)
    cell = _cell(plan, layout)
    width = max(layout.columns * (CELL + GAP_X) + 0.3, 6.0)
    height = layout.rows * (cell.tall + GAP_Y) + 0.7
    figure = new_figure(width, height)
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, width), ylim=(height, 0))
    axes.axis('off')
    places = {
        n: (0.25 + c * (CELL + GAP_X), 0.6 + r * (cell.tall + GAP_Y))
        for n, (c, r) in layout.cells.items()
    }
    _edges(axes, layout, places, cell.tall)
    for subgoal in plan.subgoals:
        if subgoal.number in places:
            _subgoal(axes, plan.scenario, subgoal, layout, places[subgoal.number], cell)
    axes.text(0.25, 0.3, _caption(plan, layout), fontsize=9, va='center', color=INK)
    return figure


def _cell(plan: ContactPlan, layout: GraphLayout) -> Cell:
    """The object's reach and a margin."""
    poses = [s.configuration[:3] for s in plan.subgoals if s.number in layout.cells]
    points = np.vstack([object_outline(plan.scenario, pose) for pose in poses])
    (left, bottom), (right, top) = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
    return Cell(left, right, bottom, top)


def _edges(axes: Axes, layout: GraphLayout, places: dict[int, Place], tall: float) -> None:
    """Right-angled lines; those that start from different subgoals of a column turn at different
    places.
    """
    lines: list[list[Place]] = []
    thick: list[list[Place]] = []
    lanes = _lanes(layout)
    for a, b, on_route in layout.edges:
        (x0, y0), (x1, y1) = places[a], places[b]
        turn, ya, yb = x0 + CELL + GAP_X * lanes[a], y0 + tall / 2, y1 + tall / 2
        (thick if on_route else lines).append([(x0 + CELL, ya), (turn, ya), (turn, yb), (x1, yb)])
    axes.add_collection(LineCollection(lines, colors='#9a9a9a', linewidths=1.0, zorder=1))
    axes.add_collection(LineCollection(thick, colors=PLANNED, linewidths=3.2, zorder=2))


def _lanes(layout: GraphLayout) -> dict[int, float]:
    """Share of the gap behind a column at which the lines of each subgoal in it turn, the lowest
    subgoal's first.
    """
    columns: dict[int, list[int]] = {}
    for a in dict.fromkeys(a for a, _, _ in layout.edges):
        columns.setdefault(layout.cells[a][0], []).append(a)
    return {
        a: (k + 1) / (len(column) + 1)
        for column in columns.values()
        for k, a in enumerate(sorted(column, key=lambda n: -layout.cells[n][1]))
    }


def _subgoal(
    axes: Axes,
    scenario: Scenario,
    subgoal: Subgoal,
    layout: GraphLayout,
    place: Place,
    cell: Cell,
) -> None:
    x, y = place
    on_route = subgoal.number in layout.route
    frame = FancyBboxPatch(
        (x, y),
        CELL,
        cell.tall,
        boxstyle='round,pad=0,rounding_size=0.05',
        facecolor='white',
        edgecolor=PLANNED if on_route else '#9a9a9a',
        linewidth=2.4 if on_route else 0.8,
        zorder=3,
    )
    frame.set_gid(f'subgoal-{subgoal.number}')
    axes.add_patch(frame)
    for artist in _drawing(scenario, subgoal, partial(cell.put, place=place)):
        artist.set_clip_path(frame)
        axes.add_artist(artist)
    axes.text(
        x + 0.06,
        y + 0.11,
        f'#{subgoal.number}',
        fontsize=7.5,
        weight='bold',
        zorder=8,
        color=PLANNED if on_route else INK,
        va='center',
    )
    note = {'X_init': 'init', 'X_goal': 'goal', 'Y': 'Y'}.get(subgoal.kind, '')
    axes.text(
        x + CELL - 0.06,
        y + 0.11,
        f'{note} {ROTATION[subgoal.direction]}'.strip(),
        fontsize=8,
        zorder=8,
        ha='right',
        va='center',
        color=INK,
    )
    if layout.hidden.get(subgoal.number):
        axes.text(
            x + CELL + 0.03,
            y + cell.tall - 0.03,
            f'+{layout.hidden[subgoal.number]}',
            fontsize=6.5,
            zorder=8,
            color='#666666',
        )


def _drawing(
    scenario: Scenario, subgoal: Subgoal, put: Callable[[np.ndarray], np.ndarray]
) -> list[Collection]:
    """Palm, fingers, object and contact normals, on top of each other in this order."""
    q = subgoal.configuration
    points, normals = contact_marks(scenario, q, subgoal.contacts)
    ends = np.stack([points, points + NORMAL * normals], axis=1).reshape(-1, 2)
    return [
        LineCollection([put(scenario.palm.vertices)], colors=PALM, linewidths=2.0, zorder=4),
        PolyCollection(
            [put(o) for o in hand_outlines(scenario, q[3:])],
            facecolors=[c + '55' for c in SIDE_COLOURS],
            edgecolors=SIDE_COLOURS,
            linewidths=0.8,
            zorder=5,
        ),
        PolyCollection(
            [put(object_outline(scenario, q[:3]))],
            facecolors=OBJECT,
            edgecolors=OBJECT_EDGE,
            linewidths=0.9,
            zorder=6,
        ),
        LineCollection(
            list(put(ends).reshape(-1, 2, 2)), colors=INK, linewidths=2.2, capstyle='butt', zorder=7
        ),
    ]


def _caption(plan: ContactPlan, layout: GraphLayout) -> str:
    finger = 'direction of the velocity-controlled finger: ↺ counter-clockwise, ↻ clockwise'
    left_out = len(plan.subgoals) - len(layout.cells) - layout.merged
    parts = [
        f'{len(plan.subgoals)} subgoals ({layout.merged} share a configuration with one drawn)'
        + (f', {left_out} further ones not drawn (+n)' if left_out else ''),
        'red: the route' if plan.found else f'no route ({plan.outcome})',
        finger,
    ]
    return '   '.join(parts) if layout.columns > WIDE else '\n'.join(parts)
