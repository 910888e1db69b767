"""`wholearm run` in a terminal: step, the hand, mode, joint angles, the torque within its feasible
range.
"""

import time
from dataclasses import dataclass, replace
from typing import Optional, Union

import numpy as np
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rich.console import Console, Group
from rich.live import Live
from rich.panel import Panel
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from wholearm_ros.launcher.client import Client
from wholearm_ros.launcher.drawing import draw_outlines
from wholearm_ros.model.hand import CLOSING, SIDES
from wholearm_ros.model.modes import CAGING, DONE, DWELL, DYNAMIC, IDLE, QUASI_STATIC, STOPPED
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.report.figures.outlines import hand_outlines, object_outline, view_box
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.joint_state_serialization import NANOSECONDS, read_joints
from wholearm_ros.ros.interface.messages import to_joints

RATE = 10.0  # [1/s] at which the picture is drawn anew
BAR = 48  # characters
RESTING = ('', IDLE)
MODE_STYLES = {
    QUASI_STATIC: 'black on bright_blue',
    DWELL: 'black on white',
    DYNAMIC: 'black on yellow',
    CAGING: 'black on green',
    DONE: 'bold green',
    STOPPED: 'white on red',
}


@dataclass(frozen=True)
class Moment:
    """What is shown of one instant.

    time: on the trajectory's clock, and duration [s]; angles: (2,) [rad]; torque_side: the
    torque-controlled finger; torque: it presses with; torque_range: (low, high), None where there
    is none; highest: torque of the plan [N m]; drawing: the hand, and the object as it is planned.
    """

    mode: str
    time: float
    duration: float
    angles: tuple[float, ...]
    torque_side: int
    torque: float
    torque_range: Optional[tuple[float, float]]
    highest: float
    drawing: str = ''


def moment_of(
    trajectory: ManipulationTrajectory,
    mode: str,
    time: float,
    angles: np.ndarray,
    efforts: np.ndarray,
) -> Moment:
    """What is shown at `time` [s] of the trajectory's clock.

    angles, efforts: (2,) of both joints, left then right [rad, N m].
    """
    held = float(np.clip(time, 0.0, trajectory.duration))
    segment = trajectory.segment_at(held)
    side, sign = segment.torque_finger, CLOSING[segment.torque_finger]
    # A sample between two segments has no range.
    at = min(int(held / trajectory.period) + 1, len(trajectory.times) - 1)
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


def picture(step: str, moment: Optional[Moment] = None) -> Panel:
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
    drawn = [Text(moment.drawing)] if moment.drawing else []
    return Panel(
        Group(Text(step), *drawn, rows), title='wholearm run', title_align='left', width=BAR + 34
    )


def torque_bar(moment: Moment) -> Text:
    """The pressing torque as a mark on a line, red outside of the shaded feasible range."""
    bottom, top = -0.2 * moment.highest, 1.6 * moment.highest

    def place(torque: float) -> int:
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
    """A context that draws in a terminal, called with each step of a run.

    `on_client_ready` gives it the client whose run is shown.
    """

    def __init__(self, console: Console) -> None:
        self._step, self._since = '', time.monotonic()
        self._client: Optional[Client] = None
        self._joints: Optional[bytes] = None
        self._live = Live(self, console=console, refresh_per_second=RATE, transient=True)

    def __enter__(self) -> 'LiveView':
        self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._live.stop()

    def __call__(self, step: str, share: float = 0.0) -> None:
        """The run is at `step`."""
        if step != self._step:
            self._step, self._since = step, time.monotonic()

    def on_client_ready(self, client: Client) -> None:
        """Listens to the joints: raw bytes, which cost next to nothing until they are drawn."""
        newest = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        client.node.create_subscription(
            channels.JOINT_STATES.type,
            channels.JOINT_STATES.name,
            self._on_states,
            newest,
            raw=True,
        )
        self._client = client

    def _on_states(self, data: bytes) -> None:
        self._joints = data

    def __rich__(self) -> Panel:
        moment = self._moment()
        waited = f', {time.monotonic() - self._since:.0f} s' if moment is None else ''
        return picture(self._step + waited, moment)

    def _moment(self) -> Optional[Moment]:
        latest = self._client.latest if self._client else None
        if (
            latest is None
            or latest.trajectory is None
            or latest.mode in RESTING
            or self._joints is None
        ):
            return None
        start = latest.progress.get('trajectory start')
        if not start:
            return None
        stamp, joints = to_joints(read_joints(self._joints))
        now = (stamp - int(start)) / NANOSECONDS
        trajectory, plan = latest.trajectory, latest.plan
        moment = moment_of(trajectory, latest.mode, now, joints.angles, joints.known_efforts)
        if plan is None:
            return moment
        return replace(moment, drawing=draw_hand(plan.scenario, trajectory, now, joints.angles))


def draw_hand(
    scenario: Scenario, trajectory: ManipulationTrajectory, now: float, angles: np.ndarray
) -> str:
    """Palm and fingers as they are, the object as planned at `now` [s]; angles: (2,) [rad]."""
    at = int(np.clip(now / trajectory.period, 0, len(trajectory.poses) - 1))
    outlines = [*hand_outlines(scenario, angles), object_outline(scenario, trajectory.poses[at])]
    box = view_box(scenario, trajectory.poses, trajectory.angles)
    there_and_back = np.vstack([scenario.palm.vertices, scenario.palm.vertices[::-1]])
    return draw_outlines([there_and_back, *outlines], box, BAR)


class PlainView:
    """The same without a terminal: each step once, as a line."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._last: Optional[str] = None

    def __enter__(self) -> 'PlainView':
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def __call__(self, step: str, share: float = 0.0) -> None:
        """The run is at `step`."""
        if step != self._last:
            self._console.print(Text(step), soft_wrap=True)
        self._last = step

    def on_client_ready(self, client: Client) -> None:
        """Nothing is drawn."""


def view_on(console: Console) -> Union[LiveView, PlainView]:
    """What fits the console."""
    return LiveView(console) if console.is_terminal else PlainView(console)
