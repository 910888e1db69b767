"""Figure 7: torque of the torque-controlled finger with its feasible range, and angle and error of
the other finger.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from wholearm_ros.model.hand import SIDES
from wholearm_ros.model.modes import PLANNED_MODES
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.report.figures.canvas import new_figure
from wholearm_ros.report.figures.mode_spans import executed_spans, merged, planned_spans
from wholearm_ros.report.figures.palette import EXECUTED, INK, MODE_COLOURS, MODE_NAMES, PLANNED
from wholearm_ros.report.run_view import Controlled, RunView, controlled

AFTER = 0.5  # [s] that are shown after the trajectory: what the hand feels then was not planned
NARROW = 0.035  # share of the width below which a mode's name is left out of its band


def draw_times(trajectory: ManipulationTrajectory, run: RunView, title: str = '') -> Figure:
    """(a) torque and modes; (b) angle and its error."""
    run = run.until(trajectory.duration + AFTER)
    both = controlled(trajectory, run)
    figure = new_figure(9.5, 7.2, layout='constrained')
    bands, torque, angle, error = figure.subplots(
        4, 1, sharex=True, height_ratios=[0.55, 3, 2.2, 1.3]
    )
    span = float(run.times[0]), float(run.times[-1])
    _bands(bands, trajectory, run, both, span)
    for axes in (torque, angle, error):
        for start, end, mode in planned_spans(trajectory):
            axes.axvspan(start, end, color=MODE_COLOURS[mode], alpha=0.28, lw=0)
        axes.grid(alpha=0.25, lw=0.6)
    _torque(torque, run, both)
    _angle(angle, error, run, both)
    bands.set_xlim(*span)
    error.set_xlabel('time along the trajectory [s]')
    bands.set_title(title, fontsize='medium', loc='left')
    # The modes are named beside the title: the shortest stretches have no room for it.
    bands.legend(
        # Named beside the title: the shortest stretches have no room for it.
        handles=[
            Patch(facecolor=MODE_COLOURS[mode], label=MODE_NAMES[mode]) for mode in PLANNED_MODES
        ],
        fontsize=7,
        loc='lower right',
        bbox_to_anchor=(1.0, 0.98),
        borderaxespad=0.0,
        frameon=False,
        ncols=len(PLANNED_MODES),
    )
    return figure


def _bands(
    axes: Axes,
    trajectory: ManipulationTrajectory,
    run: RunView,
    both: Controlled,
    span: tuple[float, float],
) -> None:
    """Three rows: the mode planned, the mode executed, the finger that is torque-controlled."""
    fingers = merged(
        (a, b, SIDES[s])
        for a, b, s in zip(run.times, [*run.times[1:], run.times[-1]], both.torque_side)
    )
    rows = (planned_spans(trajectory), executed_spans(run), fingers)
    for row, spans in enumerate(rows):
        for start, end, what in spans:
            colour = MODE_COLOURS.get(what, '#ffffff')
            axes.broken_barh(
                [(start, end - start)], (-row, 0.86), facecolor=colour, edgecolor='#777777', lw=0.4
            )
            name = MODE_NAMES.get(what, what)
            if end - start > NARROW * len(name) / 5 * (span[1] - span[0]):
                axes.text(
                    (start + end) / 2,
                    0.4 - row,
                    name,
                    ha='center',
                    va='center',
                    fontsize=7,
                    color=INK,
                )
    axes.set_yticks([0.43, -0.57, -1.57], ['planned mode', 'executed', 'torque finger'], fontsize=7)
    axes.set_ylim(-2.05, 0.95)
    axes.tick_params(length=0)
    for side in axes.spines.values():
        side.set_visible(False)


def _torque(axes: Axes, run: RunView, both: Controlled) -> None:
    low, high = both.torque_range.T
    if np.isfinite(high).any():
        axes.fill_between(
            run.times,
            low,
            high,
            facecolor='none',
            edgecolor='#707070',
            hatch='///',
            lw=0.6,
            label='feasible range (τ_min, τ_max)',
        )
    axes.plot(run.times, both.planned_torque, color=PLANNED, lw=2.8, alpha=0.75, label='planned')
    axes.plot(run.times, both.torque, color=EXECUTED, lw=1.0, label='executed')
    bottom, top, note = torque_window(both)
    axes.text(
        0.995,
        0.97,
        note,
        transform=axes.transAxes,
        ha='right',
        va='top',
        fontsize=7,
        color='#555555',
    )
    axes.set_ylim(bottom, top)
    axes.set_ylabel('(a) pressing torque\n[N m]')
    axes.legend(
        loc='lower left',
        bbox_to_anchor=(0.0, 1.0),
        borderaxespad=0.2,
        frameon=False,
        fontsize=7,
        ncols=3,
    )


def torque_window(both: Controlled) -> tuple[float, float, str]:
    """(bottom, top [N m], what is beyond): the torques that occur fill the picture, not the ends of
    the range.
    """
    low, high = both.torque_range.T
    used = np.concatenate([both.torque, both.planned_torque, low[np.isfinite(low)], [0.0]])
    bottom, top = float(used.min()), float(used.max())
    span = max(top - bottom, 0.2)
    if not np.isfinite(high).any():
        note = 'no quasi-static stretch, so no feasible range'
        return bottom - 0.1 * span, top + 0.2 * span, note
    highest = float(np.nanmax(high))
    window = top + max(0.6 * span, 0.4)
    if highest > window:
        return bottom - 0.1 * span, window, f'the range goes on to {highest:.1f} N m'
    return bottom - 0.1 * span, max(highest, top) + 0.1 * span, ''


def _angle(angle: Axes, error: Axes, run: RunView, both: Controlled) -> None:
    jump = np.flatnonzero(np.diff(both.torque_side))
    planned, executed = np.degrees(both.planned_angle), np.degrees(both.angle)
    wrong = 1e3 * both.angle_error
    for values in (planned, executed, wrong):
        values[jump] = np.nan  # the line is broken where the other finger takes over
    angle.plot(run.times, planned, color=PLANNED, lw=2.2, alpha=0.8, label='planned')
    angle.plot(run.times, executed, color=EXECUTED, lw=1.0, label='executed')
    for start in (0, *(jump + 1)):
        angle.annotate(
            f' {SIDES[1 - both.torque_side[start]]} finger',
            (run.times[start], np.degrees(both.angle[start])),
            fontsize=7.5,
            color=INK,
            va='bottom',
        )
    angle.set_ylabel('(b) velocity finger\nangle [°]')
    angle.legend(loc='best', fontsize=7)
    angle.margins(y=0.15)
    error.axhline(0.0, color='#888888', lw=0.6)
    error.plot(run.times, wrong, color=EXECUTED, lw=1.0)
    error.set_ylabel('error [mrad]')
