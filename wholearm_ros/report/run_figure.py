"""One figure of a run: joint angles, torques and the object's rotation over time, the plan behind them, the modes."""
from dataclasses import dataclass
from pathlib import Path
from typing import Tuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..model.hand import SIDES
from ..model.trajectory import ManipulationTrajectory

COLOURS = {'quasi_static': '#dbe9f6', 'dwell': '#eeeeee', 'dynamic': '#f9dcc4', 'caging': '#d8f0d3'}
SIDE_COLOURS = ('#1f5fa8', '#c0392b')


@dataclass(frozen=True, eq=False)
class MeasuredRun:
    """times (m,) [s] from the start of the run; joints (m, 3, 2): angles, velocities, efforts;
    pose_times (p,), poses (p, 3)."""

    times: np.ndarray
    joints: np.ndarray
    pose_times: np.ndarray
    poses: np.ndarray


def draw_run(trajectory: ManipulationTrajectory, run: MeasuredRun, ramp: float, title: str) -> Figure:
    """ramp [s]: what passes between the start of the run and that of the trajectory."""
    figure = Figure(figsize=(9, 7), layout='constrained')
    FigureCanvasAgg(figure)
    axes = figure.subplots(3, 1, sharex=True)
    planned = trajectory.times + ramp
    for axis in axes:
        _shade_modes(axis, trajectory, ramp)
    for side, colour in enumerate(SIDE_COLOURS):
        axes[0].plot(planned, trajectory.angles[:, side], ':', color=colour, lw=1)
        axes[0].plot(run.times, run.joints[:, 0, side], color=colour, label=SIDES[side])
        axes[1].plot(run.times, run.joints[:, 2, side], color=colour, label=SIDES[side])
    axes[2].plot(planned, trajectory.poses[:, 2], ':', color='black', lw=1, label='planned')
    axes[2].plot(run.pose_times, run.poses[:, 2], color='black', label='true')
    _label(axes, title)
    return figure


def save(figure: Figure, path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=120)
    return path


def _shade_modes(axis, trajectory, ramp):
    for s in trajectory.segments:
        axis.axvspan(s.start + ramp, s.end + ramp, color=COLOURS[s.mode], lw=0)


def _label(axes: Tuple, title: str):
    for axis, text in zip(axes, ('joint angle [rad]', 'motor torque [N m]', 'object rotation [rad]')):
        axis.set_ylabel(text)
        axis.legend(loc='upper left', fontsize='small')
        axis.margins(x=0.01)
    axes[0].set_title(f'{title}   (' + ', '.join(f'{mode}: {colour}' for mode, colour in _named()) + '; dotted: plan)',
                      fontsize='medium')
    axes[-1].set_xlabel('time [s]')


def _named():
    return (('quasi-static', 'blue'), ('dwell', 'grey'), ('dynamic', 'orange'), ('caging', 'green'))
