"""Stretches of time in one mode, planned and executed."""

from collections.abc import Iterable

import numpy as np

from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.report.run_view import RunView

Span = tuple[float, float, str]


def executed_spans(run: RunView) -> list[Span]:
    """(start, end [s], mode) of what the mode switch led through."""
    return merged(
        (t, u, mode) for t, u, mode in zip(run.times, [*run.times[1:], run.times[-1]], run.modes)
    )


def planned_spans(trajectory: ManipulationTrajectory) -> list[Span]:
    """(start, end [s], mode) of the trajectory."""
    return merged((s.start, s.end, s.mode) for s in trajectory.segments)


def merged(spans: Iterable[Span]) -> list[Span]:
    """Neighbours of the same mode as one."""
    result: list[Span] = []
    for start, end, mode in spans:
        if result and result[-1][2] == mode:
            result[-1] = (result[-1][0], end, mode)
        else:
            result.append((start, end, mode))
    return result


def key_instants(
    trajectory: ManipulationTrajectory, run: RunView, most: int = 8, apart: float = 0.12
) -> np.ndarray:
    """Instants [s] worth a picture: the start, every change of mode or of contact state, the end;
    at least `apart`, long stretches halved while there is room.
    """
    changes = [s.start for s in trajectory.segments if s.end - s.start > apart]
    instants: list[float] = []
    for t in sorted({0.0, *changes, *(a for a, _, _ in planned_spans(trajectory))}):
        if not instants or t - instants[-1] >= apart:
            instants.append(t)
    end = min(trajectory.duration, run.times[-1])
    instants = [t for t in instants if end - t >= apart] + [end]
    while len(instants) < most:
        gaps = np.diff(instants)
        widest = int(np.argmax(gaps))
        if gaps[widest] < 4 * apart:
            break
        instants.insert(widest + 1, instants[widest] + gaps[widest] / 2)
    while len(instants) > most:
        del instants[1 + int(np.argmin(np.diff(instants)[1:]))]
    return np.array(instants)
