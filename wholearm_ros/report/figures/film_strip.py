"""Figure 8: the run at its changes of mode, planned as outlines against executed, filled."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.report.figures.canvas import new_figure
from wholearm_ros.report.figures.mode_spans import key_instants
from wholearm_ros.report.figures.outlines import hand_outlines, object_outline, touching, view_box
from wholearm_ros.report.figures.palette import (
    INK,
    MODE_COLOURS,
    MODE_NAMES,
    OBJECT,
    OBJECT_EDGE,
    PALM,
    PLANNED,
    SIDE_COLOURS,
)
from wholearm_ros.report.run_view import RunView

WIDTH, COLUMNS = 2.4, 4  # [inch] of a frame; frames in a row
NORMAL = 0.022  # [m] at which a contact normal is drawn


def draw_film(plan: ContactPlan, trajectory: ManipulationTrajectory, run: RunView) -> Figure:
    """Frames from left to right, top to bottom; the normals are of what truly touches."""
    instants = key_instants(trajectory, run, most=2 * COLUMNS)
    poses, angles = run.pose_at(instants), run.angles_at(instants)
    left, right, bottom, top = view_box(plan.scenario, poses, angles)
    rows = -(-len(instants) // COLUMNS)
    tall = WIDTH * (top - bottom) / (right - left)
    figure = new_figure(WIDTH * COLUMNS + 0.3, (tall + 0.3) * rows + 0.25)
    grid = figure.subplots(
        rows,
        COLUMNS,
        squeeze=False,
        gridspec_kw={
            'left': 0.01,
            'right': 0.99,
            'bottom': 0.06 / rows,
            'top': 1 - 0.15 / rows,
            'wspace': 0.05,
            'hspace': 0.16,
        },
    )
    for axes in grid.flat:
        axes.axis('off')
    for k, (axes, t) in enumerate(zip(grid.flat, instants)):
        axes.set(xlim=(left, right), ylim=(bottom, top), aspect='equal')
        _frame(axes, plan.scenario, trajectory, t, poses[k], angles[k])
        mode = trajectory.segment_at(t - 1e-9 if k == len(instants) - 1 else t + 1e-9).mode
        axes.set_title(
            f'{t:.2f} s  {"end" if k == len(instants) - 1 else MODE_NAMES[mode]}',
            fontsize=8,
            pad=3,
            backgroundcolor=MODE_COLOURS[mode],
        )
    figure.text(
        0.5,
        0.012,
        'filled: executed    red outline: planned    bold: normals of what touches',
        fontsize=7.5,
        ha='center',
        color=INK,
    )
    return figure


def _frame(
    axes: Axes,
    scenario: Scenario,
    trajectory: ManipulationTrajectory,
    t: float,
    pose: np.ndarray,
    angles: np.ndarray,
) -> None:
    at = min(int(round(t / trajectory.period)), len(trajectory.angles) - 1)
    q = np.concatenate([trajectory.poses[at], trajectory.angles[at]])
    points, normals = touching(scenario, np.concatenate([pose, angles]))
    axes.add_collection(LineCollection([scenario.palm.vertices], colors=PALM, linewidths=2.5))
    axes.add_collection(
        PolyCollection(
            hand_outlines(scenario, angles),
            facecolors=[c + '66' for c in SIDE_COLOURS],
            edgecolors=SIDE_COLOURS,
            linewidths=0.8,
        )
    )
    x, y = np.array([scenario.hand.left.axis, scenario.hand.right.axis]).T
    axes.scatter(x, y, s=9, color=INK, zorder=5)
    if np.isfinite(pose).all():
        axes.add_collection(
            PolyCollection(
                [object_outline(scenario, pose)],
                facecolors=OBJECT,
                edgecolors=OBJECT_EDGE,
                linewidths=0.9,
            )
        )
    planned = [object_outline(scenario, q[:3]), *hand_outlines(scenario, q[3:])]
    axes.add_collection(
        PolyCollection(
            planned, facecolors='none', edgecolors=PLANNED, linewidths=1.0, linestyles='--'
        )
    )
    marks = list(np.stack([points, points + NORMAL * normals], axis=1))
    axes.add_collection(LineCollection(marks, colors=INK, linewidths=2.2))
