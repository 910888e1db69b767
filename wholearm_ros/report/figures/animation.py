"""The run as an animated GIF, drawn with Pillow."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.report.figures.outlines import hand_outlines, object_outline, view_box
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

WIDTH, BAND, FINE = (
    480,
    26,
    2,
)  # [pixel] of the picture, of the mode band; how much finer it is drawn than shown
RATE, HOLD = 20, 1.2  # [1/s] frames; [s] at the end before it begins again
COLOURS = 64


def write_animation(
    path: Path, plan: ContactPlan, trajectory: ManipulationTrajectory, run: RunView
) -> Path:
    """Real time; planned as a red outline, executed filled. Returns `path`."""
    times = np.arange(max(run.times[0], -0.1), run.times[-1], 1.0 / RATE)
    frames = [frame.quantize(COLOURS) for frame in draw_frames(plan, trajectory, run, times)]
    path.parent.mkdir(parents=True, exist_ok=True)
    durations = [1000 // RATE] * (len(frames) - 1) + [int(1000 * HOLD)]
    frames[0].save(
        path, save_all=True, append_images=frames[1:], duration=durations, loop=0, optimize=True
    )
    return path


def draw_frames(
    plan: ContactPlan, trajectory: ManipulationTrajectory, run: RunView, times: np.ndarray
) -> list:
    """One RGB image an instant."""
    scenario, poses, angles = plan.scenario, run.pose_at(times), run.angles_at(times)
    box = view_box(scenario, poses, angles)
    scale = FINE * WIDTH / (box[1] - box[0])
    size = FINE * WIDTH, int(scale * (box[3] - box[2])) // (2 * FINE) * (2 * FINE) + FINE * BAND

    def put(points: np.ndarray) -> Any:
        return [(scale * (x - box[0]), size[1] - scale * (y - box[2])) for x, y in points]

    places = np.searchsorted(run.times, times, side='right') - 1
    return [
        _frame(size, put, scenario, trajectory, t, pose, pair, run.modes[max(k, 0)])
        for t, pose, pair, k in zip(times, poses, angles, places)
    ]


def _frame(
    size: tuple[int, int],
    put: Callable[[Any], Any],
    scenario: Scenario,
    trajectory: ManipulationTrajectory,
    t: float,
    pose: np.ndarray,
    angles: np.ndarray,
    mode: str,
) -> Image.Image:
    image = Image.new('RGB', size, 'white')
    pen = ImageDraw.Draw(image)
    at = int(np.clip(round(t / trajectory.period), 0, len(trajectory.angles) - 1))
    pen.line(put(scenario.palm.vertices), fill=PALM, width=4 * FINE)
    for outline, colour in zip(hand_outlines(scenario, angles), SIDE_COLOURS):
        pen.polygon(put(outline), fill=_pale(colour), outline=colour, width=FINE)
    if np.isfinite(pose).all():
        pen.polygon(
            put(object_outline(scenario, pose)), fill=OBJECT, outline=OBJECT_EDGE, width=FINE
        )
    for outline in (
        object_outline(scenario, trajectory.poses[at]),
        *hand_outlines(scenario, trajectory.angles[at]),
    ):
        pen.polygon(put(outline), outline=PLANNED, width=max(1, FINE // 2))
    for finger in (scenario.hand.left, scenario.hand.right):
        (x, y), r = put([finger.axis])[0], 4 * FINE
        pen.ellipse((x - r, y - r, x + r, y + r), fill=INK)
    pen.rectangle((0, 0, size[0], FINE * BAND), fill=MODE_COLOURS.get(mode, '#ffffff'))
    font = ImageFont.load_default(FINE * BAND * 0.55)
    pen.text(
        (8 * FINE, FINE * BAND / 2), MODE_NAMES.get(mode, mode), fill=INK, font=font, anchor='lm'
    )
    pen.text(
        (size[0] - 8 * FINE, FINE * BAND / 2),
        f'{max(t, 0.0):.2f} s',
        fill=INK,
        font=font,
        anchor='rm',
    )
    return image.resize((size[0] // FINE, size[1] // FINE), Image.Resampling.LANCZOS)


def _pale(colour: str) -> tuple:
    return tuple(int(0.45 * int(colour[k : k + 2], 16) + 0.55 * 255) for k in (1, 3, 5))
