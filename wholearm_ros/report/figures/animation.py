"""The run as an animated GIF, drawn with Pillow."""

from dataclasses import dataclass
from pathlib import Path

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

WIDTH, BAND = 480, 26  # [pixel] of the picture, of the mode band
FINE = 2  # how much finer it is drawn than shown
RATE, HOLD = 20, 1.2  # [1/s] frames; [s] at the end before it begins again
COLOURS = 64


@dataclass(frozen=True)
class Frame:
    """The picture as it is drawn. scale [pixel/m]; left, bottom [m] of what is seen; size
    [pixel].
    """

    scale: float
    left: float
    bottom: float
    size: tuple[int, int]

    def put(self, points: np.ndarray) -> list[tuple[float, float]]:
        """Pixels of points (k, 2) [m]."""
        scale, height = self.scale, self.size[1]
        return [(scale * (x - self.left), height - scale * (y - self.bottom)) for x, y in points]


@dataclass(frozen=True, eq=False)
class Instant:
    """What was executed at a time [s]: pose (3,) [m, m, rad], angles (2,) [rad], mode."""

    time: float
    pose: np.ndarray
    angles: np.ndarray
    mode: str


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
) -> list[Image.Image]:
    """One RGB image for each of `times` (k,) [s]."""
    scenario, poses, angles = plan.scenario, run.pose_at(times), run.angles_at(times)
    left, right, bottom, top = view_box(scenario, poses, angles)
    scale = FINE * WIDTH / (right - left)
    height = int(scale * (top - bottom)) // (2 * FINE) * (2 * FINE) + FINE * BAND
    frame = Frame(scale, left, bottom, (FINE * WIDTH, height))
    places = np.searchsorted(run.times, times, side='right') - 1
    return [
        _drawn(frame, scenario, trajectory, Instant(t, pose, pair, run.modes[max(k, 0)]))
        for t, pose, pair, k in zip(times, poses, angles, places)
    ]


def _drawn(
    frame: Frame, scenario: Scenario, trajectory: ManipulationTrajectory, now: Instant
) -> Image.Image:
    image = Image.new('RGB', frame.size, 'white')
    pen, put, width = ImageDraw.Draw(image), frame.put, frame.size[0]
    at = int(np.clip(round(now.time / trajectory.period), 0, len(trajectory.angles) - 1))
    pen.line(put(scenario.palm.vertices), fill=PALM, width=4 * FINE)
    for outline, colour in zip(hand_outlines(scenario, now.angles), SIDE_COLOURS):
        pen.polygon(put(outline), fill=_pale(colour), outline=colour, width=FINE)
    if np.isfinite(now.pose).all():
        outline = object_outline(scenario, now.pose)
        pen.polygon(put(outline), fill=OBJECT, outline=OBJECT_EDGE, width=FINE)
    for outline in (
        object_outline(scenario, trajectory.poses[at]),
        *hand_outlines(scenario, trajectory.angles[at]),
    ):
        pen.polygon(put(outline), outline=PLANNED, width=max(1, FINE // 2))
    for finger in (scenario.hand.left, scenario.hand.right):
        (x, y), r = put(finger.axis[None])[0], 4 * FINE
        pen.ellipse((x - r, y - r, x + r, y + r), fill=INK)
    pen.rectangle((0, 0, width, FINE * BAND), fill=MODE_COLOURS.get(now.mode, '#ffffff'))
    font = ImageFont.load_default(FINE * BAND * 0.55)
    middle, name, time = FINE * BAND / 2, MODE_NAMES.get(now.mode, now.mode), max(now.time, 0.0)
    pen.text((8 * FINE, middle), name, fill=INK, font=font, anchor='lm')
    pen.text((width - 8 * FINE, middle), f'{time:.2f} s', fill=INK, font=font, anchor='rm')
    return image.resize((width // FINE, frame.size[1] // FINE), Image.Resampling.LANCZOS)


def _pale(colour: str) -> tuple[int, int, int]:
    red, green, blue = (int(0.45 * int(colour[k : k + 2], 16) + 0.55 * 255) for k in (1, 3, 5))
    return red, green, blue
