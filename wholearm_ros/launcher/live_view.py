"""`wholearm run` in a terminal: step, progress, mode, joint angles, and the torque within its
feasible range, as they change.
"""

from dataclasses import dataclass

import numpy as np
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rich.console import Console, Group
from rich.live import Live
from rich.panel import Panel
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from wholearm_ros.model.hand import CLOSING, JOINT_NAMES, SIDES
from wholearm_ros.model.trajectory import QUASI_STATIC, ManipulationTrajectory
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.messages import NANOSECONDS, to_nanoseconds

RATE = 10.0  # [1/s] at which the picture is drawn anew
BAR = 48  # characters
RESTING = ('', 'idle')
MODE_STYLES = {
    'quasi_static': 'black on bright_blue',
    'dwell': 'black on white',
    'dynamic': 'black on yellow',
    'caging': 'black on green',
    'done': 'bold green',
    'stopped': 'white on red',
}


@dataclass(frozen=True)
class Moment:
    """What is shown of one instant: time on the trajectory's clock and duration [s], angles (2,)
    [rad], the torque-controlled finger, its pressing torque and the feasible range (low, high) [N
    m] or None where there is none, and the highest torque of the plan [N m].
    """

    mode: str
    time: float
    duration: float
    angles: tuple
    torque_side: int
    torque: float
    torque_range: tuple
    highest: float


def moment_of(
    trajectory: ManipulationTrajectory, mode: str, time: float, angles, efforts
) -> Moment:
    """angles, efforts: (2,) of both joints, left then right [rad, N m]."""
    held = float(np.clip(time, 0.0, trajectory.duration))
    segment = trajectory.segment_at(held)
    side, sign = segment.torque_finger, CLOSING[segment.torque_finger]
    at = min(
        int(held / trajectory.period) + 1, len(trajectory.times) - 1
    )  # a sample between two segments has no range
    low, high = (float(v) for v in trajectory.torque_ranges[at][:: int(sign)] * sign)
    known = segment.mode == QUASI_STATIC and low <= high
    return Moment(
        mode,
        time,
        trajectory.duration,
        tuple(angles),
        side,
        float(sign * efforts[side]),
        (low, high) if known else None,
        max(0.5, highest_torque(trajectory)),
    )


def highest_torque(trajectory: ManipulationTrajectory) -> float:
    """[N m] of the torque-controlled finger, whichever it is, over the whole trajectory."""
    places = [
        (np.searchsorted(trajectory.times, [s.start, s.end]), s.torque_finger)
        for s in trajectory.segments
    ]
    return max(
        float(np.abs(trajectory.efforts[first : last + 1, side]).max())
        for (first, last), side in places
    )


def picture(step: str, moment: Moment = None) -> Panel:
    """The step alone while there is no run, else all of it."""
    if moment is None:
        return Panel(Text(step), title='wholearm run', title_align='left', width=BAR + 34)
    rows = Table.grid(padding=(0, 2))
    rows.add_row(
        'time',
        ProgressBar(moment.duration, max(0.0, min(moment.time, moment.duration)), width=BAR),
        f'{max(moment.time, 0.0):.2f} of {moment.duration:.2f} s',
    )
    rows.add_row(
        'mode', Text(f' {moment.mode.replace("_", "-")} ', MODE_STYLES.get(moment.mode, '')), ''
    )
    for side, angle in enumerate(moment.angles):
        role = 'torque' if side == moment.torque_side else 'velocity'
        rows.add_row(
            SIDES[side],
            ProgressBar(
                180.0,
                float(np.clip(np.degrees(angle), 0.0, 180.0)),
                width=BAR,
                complete_style='cyan',
                finished_style='cyan',
            ),
            f'{np.degrees(angle):6.1f}° {role}',
        )
    rows.add_row('torque', torque_bar(moment), f'{moment.torque:+.2f} N m')
    return Panel(Group(Text(step), rows), title='wholearm run', title_align='left', width=BAR + 34)


def torque_bar(moment: Moment) -> Text:
    """The pressing torque as a mark on a line; the feasible range is shaded, the mark red outside
    of it.
    """
    bottom, top = -0.2 * moment.highest, 1.6 * moment.highest

    def place(torque):
        return int(np.clip((torque - bottom) / (top - bottom) * (BAR - 1), 0, BAR - 1))

    line, good = Text('·' * BAR, 'dim'), True
    if moment.torque_range is not None:
        low, high = moment.torque_range
        good = low - 0.02 <= moment.torque <= high + 0.02
        a, b = place(low), place(high)
        line = (
            Text('·' * a, 'dim')
            + Text('▒' * (b - a + 1), 'green')
            + Text('·' * (BAR - 1 - b), 'dim')
        )
    at = place(moment.torque)
    return line[:at] + Text('┃', 'bold' if good else 'bold red') + line[at + 1 :]


class LiveView:
    """A context that draws in a terminal. Called with each step; `on_client_ready` gives it the
    client whose run is shown.
    """

    def __init__(self, console: Console) -> None:
        self._step, self._client, self._joints = '', None, None
        self._live = Live(self, console=console, refresh_per_second=RATE, transient=True)

    def __enter__(self):
        self._live.start()
        return self

    def __exit__(self, *_):
        self._live.stop()

    def __call__(self, step: str, share: float = 0.0):
        self._step = step

    def on_client_ready(self, client) -> None:
        """Listens to the joints: raw bytes, so that a message costs next to nothing until one is
        drawn.
        """
        newest = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        client.node.create_subscription(
            channels.JOINT_STATES.type, channels.JOINT_STATES.name, self._hear, newest, raw=True
        )
        self._client = client

    def _hear(self, data: bytes) -> None:
        self._joints = data

    def __rich__(self):
        return picture(self._step, self._moment())

    def _moment(self):
        latest = self._client and self._client.latest
        if (
            not latest
            or latest.trajectory is None
            or latest.mode in RESTING
            or self._joints is None
        ):
            return None
        start = latest.progress.get('trajectory start')
        if not start:
            return None
        message = deserialize_message(self._joints, channels.JOINT_STATES.type)
        time = (to_nanoseconds(message.header.stamp) - int(start)) / NANOSECONDS
        order = [list(message.name).index(name) for name in JOINT_NAMES]
        return moment_of(
            latest.trajectory,
            latest.mode,
            time,
            np.array(message.position)[order],
            np.array(message.effort)[order],
        )


class PlainView:
    """The same without a terminal: each step once, as a line."""

    def __init__(self, console: Console) -> None:
        self._console, self._last = console, None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def __call__(self, step: str, share: float = 0.0):
        if step != self._last:
            self._console.print(Text(step), soft_wrap=True)
        self._last = step

    def on_client_ready(self, client) -> None:
        """Nothing to draw, nothing to hear."""


def view_on(console: Console):
    """What fits the console."""
    return LiveView(console) if console.is_terminal else PlainView(console)
