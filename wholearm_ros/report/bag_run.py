"""The runs in a bag (MCAP or sqlite3), read without ROS."""

import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import numpy as np

from wholearm_ros.bag.reader import NANOSECONDS, Bag, Timed, planar_of, stamp_of, values_of
from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.errors import BagError
from wholearm_ros.model.hand import JOINT_NAMES
from wholearm_ros.model.modes import DONE, PLANNED_MODES, STOPPED
from wholearm_ros.model.orientation import start_rotation
from wholearm_ros.model.outcomes import REJECTED, SUCCEEDED
from wholearm_ros.model.perturbation import NOMINAL, Perturbation
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.planner.face_map import FORMAT
from wholearm_ros.report.run_view import RunView
from wholearm_ros.simulation.closed_loop import RunRecord
from wholearm_ros.simulation.outcome import outcome

NEEDED = ('contact_plan', 'manipulation_trajectory', 'velocity_setpoint', 'joint_states')
READ = (
    *NEEDED,
    'object_pose',
    'object_estimate',
    'mode_switcher/mode',
    'mode_switcher/progress',
    'trajectory_generator/result',
    'contact_state_planner/status',
    'contact_state_planner/map',
    'diagnostics',
    'reorientation/feedback',
    'reorientation/result',
)
YEAR_2000 = 946_684_800 * 10**9  # [ns] log times before it are those of a clock that began at 0
ESTIMATE_AGE = 0.1  # [s] up to which an estimate is shown
SETTLE = 0.5  # [s] shown after the end
RUNNING = ('quasi_static', 'dwell', 'dynamic', 'caging')


Told = tuple[ContactPlan, ManipulationTrajectory, RunView]


@dataclass(frozen=True, eq=False)
class RecordedRuns:
    """runs: of a plan each, in order; motions: what the supervisor says came of each motion, those
    that only felt included, as `reorientation/result` has them; none when nobody supervised;
    face_map: the object's as the planner last published it, {} when it did not.
    """

    runs: tuple[Told, ...]
    motions: tuple[dict[str, Any], ...] = ()
    face_map: dict[str, Any] = field(default_factory=dict)

    @property
    def several(self) -> bool:
        """Whether there is more to tell than the last run."""
        return len(self.runs) > 1 or len(self.motions) > 1


def read_bag(path: Path) -> Told:
    """The last run in a bag. Raises BagError when it cannot be read or holds no run."""
    return read_runs(path).runs[-1]


def read_runs(path: Path) -> RecordedRuns:
    """Raises BagError when the bag cannot be read or holds no run."""
    path = Path(path)
    heard = _messages(path)
    lacking = [topic for topic in NEEDED if not heard[topic]]
    if lacking:
        raise BagError(
            f'{path}: holds no run, nothing on {", ".join(lacking)}; '
            'allowed: a bag recorded from planning to the end of a run'
        )
    plans = {p.id: p for p in (ContactPlan.from_json(m.data) for _, m in heard['contact_plan'])}
    runs: list[Told] = []
    for began, until in _runs(heard):
        trajectory = _trajectory(heard, began[0])
        plan = plans.get(trajectory.plan_id)
        if plan is not None:  # else the hand only felt
            view = _view(path, _before(heard, until), plan, trajectory, began)
            runs.append((plan, trajectory, view))
    if not runs:
        raise BagError(
            f'{path}: the plan {trajectory.plan_id} of its trajectory is not in it; '
            'allowed: a bag recorded from planning to the end of a run'
        )
    return RecordedRuns(tuple(runs), _motions(heard), _face_map(heard))


def _messages(path: Path) -> dict[str, Timed]:
    """(log time [ns], message) by topic, whatever the namespace."""
    with Bag(path.parent if path.suffix in ('.mcap', '.db3') else path) as bag:
        return bag.timed_messages(READ)


def _runs(heard: dict[str, Timed]) -> Iterator[tuple[tuple[int, float], float]]:
    """((log time [ns], stamp [s]) of a run's first setpoint, log time of the next run's) of every
    run, in order.
    """
    modes = [(when, message.data) for when, message in heard['mode_switcher/mode']]
    begins = [
        when
        for k, (when, mode) in enumerate(modes)
        if mode in PLANNED_MODES and (k == 0 or modes[k - 1][1] not in PLANNED_MODES)
    ]
    setpoints, firsts = heard['velocity_setpoint'], [0]
    for begin in begins[1:]:  # setpoints of the run before may go on right up to this one
        firsts.append(max(0, sum(when <= begin for when, _ in setpoints) - 1))
    starts = [setpoints[first] for first in firsts]
    ends = [*(when for when, _ in starts[1:]), float('inf')]
    for (when, setpoint), until in zip(starts, ends):
        yield (when, _stamp(setpoint)), until


def _before(heard: dict[str, Timed], until: float) -> dict[str, Timed]:
    """What was logged before a time [ns]."""
    if until == float('inf'):
        return heard
    return {topic: [t for t in timed if t[0] < until] for topic, timed in heard.items()}


def _trajectory(heard: dict[str, Timed], began: int) -> ManipulationTrajectory:
    """The newest when a run began."""
    told = heard['manipulation_trajectory']
    before = [timed for timed in told if timed[0] <= began] or told[:1]
    return ManipulationTrajectory.from_json(before[-1][1].data)


def _motions(heard: dict[str, Timed]) -> tuple[dict[str, Any], ...]:
    """Of the last goal of the supervisor; none when what it says cannot be read."""
    results = [values_of(message) for _, message in heard['reorientation/result']]
    said = [values for values in results if values.get('outcome') != REJECTED]
    said = said or [values_of(message) for _, message in heard['reorientation/feedback'][-1:]]
    try:
        told = json.loads(said[-1].get('tries') or '[]') if said else []
    except ValueError:
        return ()
    return tuple(one for one in told if isinstance(one, dict)) if isinstance(told, list) else ()


def _face_map(heard: dict[str, Timed]) -> dict[str, Any]:
    """The last one; {} when there is none that can be read."""
    try:
        told = [json.loads(message.data) for _, message in heard['contact_state_planner/map'][-1:]]
    except ValueError:
        return {}
    ours = (one for one in told if isinstance(one, dict) and one.get('format') == FORMAT)
    return next(ours, {})


def _view(
    path: Path,
    heard: dict[str, Timed],
    plan: ContactPlan,
    trajectory: ManipulationTrajectory,
    began: tuple[int, float],
) -> RunView:
    result = _result(heard, began[1])
    over = float(result.get('stamp', 0) or 0) / 1e9 or _stamp(heard['velocity_setpoint'][-1][1])
    joints = _joints(heard['joint_states'])
    joints = joints[(joints[:, 0] >= began[1]) & (joints[:, 0] <= over + SETTLE)]
    if len(joints) < 2:
        raise BagError(
            f'{path}: no joint_states of the run; '
            'allowed: a bag recorded from planning to the end of a run'
        )
    start = _trajectory_start(heard, began[1], over)
    stamps, times = joints[:, 0], joints[:, 0] - start
    poses, known = _poses(heard['object_pose'], stamps, plan.scenario)
    stopped = any(m.data == STOPPED for when, m in heard['mode_switcher/mode'] if when > began[0])
    ended = result.get('outcome') == SUCCEEDED or (bool(result) and not stopped)
    reason = '' if ended else result.get('reason', 'the bag ends before the run does')
    modes = _modes(trajectory, times, STOPPED if reason and result else '', over - start)
    judged = None
    if known:
        nothing, perturbation = np.zeros_like(poses), _perturbation(heard['diagnostics'])
        judged = outcome(
            plan.scenario,
            RunRecord(
                times,
                joints[:, 1:3],
                joints[:, 3:5],
                joints[:, 5:7],
                poses,
                nothing,
                modes,
                reason,
                perturbation.applied(plan.scenario),
                perturbation,
            ),
        )
    return RunView(
        times,
        joints[:, 1:3],
        joints[:, 3:5],
        joints[:, 5:7],
        poses,
        modes,
        judged,
        reason,
        _facts(path, heard, began, result),
        _estimates(heard['object_estimate'], stamps),
    )


def _perturbation(messages: Timed) -> Perturbation:
    """Of a simulated hand that tells it, else nominal: the truth by which a run is judged."""
    for _, message in messages:
        for status in message.status:
            told = values_of(status).get('perturbation')
            if told is None:
                continue
            try:
                return Perturbation.from_dict(json.loads(told))
            except (ValueError, TypeError):
                return NOMINAL
    return NOMINAL


def _trajectory_start(heard: dict[str, Timed], began: float, over: float) -> float:
    """The stamp [s] at which the trajectory's time is zero, as the mode switcher says; in bags of
    before it said so, a ramp of the default length after the first setpoint.
    """
    for _, message in reversed(heard['mode_switcher/progress']):
        told = values_of(message)
        start = int(told.get('trajectory start') or 0) / NANOSECONDS
        if began <= start and began <= int(told['stamp']) / NANOSECONDS <= over:
            return start
    return began + ControlOptions().ramp


def _modes(
    trajectory: ManipulationTrajectory, times: np.ndarray, stopped: str, over: float
) -> tuple[str, ...]:
    """The switch follows the trajectory's clock, so its modes follow from the time; a stop is told
    in the result.
    """
    ends = np.array([s.end for s in trajectory.segments])
    names = np.array([*(s.mode for s in trajectory.segments), DONE])[
        np.searchsorted(ends, times, side='right')
    ]
    if stopped:
        names = np.where(times >= over, stopped, names)
    return tuple(str(name) for name in names)


def _result(heard: dict[str, Timed], began: float) -> dict[str, str]:
    """Of the run that began at a stamp [s]; empty when the bag ends before it."""
    for _, message in reversed(heard['trajectory_generator/result']):
        values = values_of(message)
        if float(values.get('stamp', 0) or 0) / 1e9 >= began:
            return values
    return {}


def _joints(messages: Timed) -> np.ndarray:
    """(m, 7) stamp, angles, velocities, efforts, left then right; equal stamps once."""
    rows = {}
    for _, m in messages:
        order = [list(m.name).index(name) for name in JOINT_NAMES]
        efforts = m.effort if len(m.effort) else np.full(len(m.name), np.nan)  # not measured
        rows[_stamp(m)] = np.concatenate(
            [[_stamp(m)], *(values[order] for values in (m.position, m.velocity, efforts))]
        )
    return np.array([rows[stamp] for stamp in sorted(rows)])


def _poses(messages: Timed, stamps: np.ndarray, scenario: Scenario) -> tuple[np.ndarray, bool]:
    """(m, 3) at `stamps`, the rotation continuous from the scenario's start; and whether there are
    any.
    """
    rows = {_stamp(m): planar_of(m.pose) for _, m in messages}
    kept = [stamp for stamp in sorted(rows) if stamps[0] - 1.0 <= stamp <= stamps[-1] + 1.0]
    if len(kept) < 2:
        return np.full((len(stamps), 3), np.nan), False
    poses = np.array([rows[stamp] for stamp in kept])
    poses[:, 2] = np.unwrap(poses[:, 2])
    poses[:, 2] += 2 * np.pi * np.round((start_rotation(scenario) - poses[0, 2]) / (2 * np.pi))
    return np.column_stack([np.interp(stamps, kept, poses[:, k]) for k in range(3)]), True


def _estimates(messages: Timed, stamps: np.ndarray) -> np.ndarray | None:
    """(m, 3) at `stamps`, each the newest of then, NaN where that is older than ESTIMATE_AGE.

    None when there are none.
    """
    if not messages:
        return None
    rows = {_stamp(m): planar_of(m.pose.pose) for _, m in messages}
    told = np.array(sorted(rows))
    newest = np.searchsorted(told, stamps, side='right') - 1
    old = (newest < 0) | (stamps - told[newest] > ESTIMATE_AGE)
    poses = np.array([rows[stamp] for stamp in told])[newest]
    return np.where(old[:, None], np.nan, poses)


def _facts(
    path: Path, heard: dict[str, Timed], began: tuple[int, float], result: dict[str, str]
) -> dict[str, Any]:
    path = Path(path).absolute()
    facts = {'source': path.name if path.name != 'bag' else f'{path.parent.name}/bag'}
    if began[0] > YEAR_2000:
        date = datetime.fromtimestamp(began[0] / NANOSECONDS, timezone.utc)
        facts['recorded'] = date.strftime('%Y-%m-%d %H:%M:%S UTC')
    if result.get('claimed'):
        facts['claimed'] = f'{result["claimed"]}: {result.get("reason", "")}'
    for when, message in heard['contact_state_planner/status'][::-1]:
        values = values_of(message)
        if 'plan_ms' in values and when <= began[0]:
            facts |= {
                f'{name.removesuffix("_ms")} time': f'{float(values[name]):.0f} ms'
                for name in ('plan_ms', 'generate_ms', 'verify_ms')
                if name in values
            }
            break
    said = [
        message.data
        for when, message in heard['mode_switcher/mode']
        if when >= began[0] - 1_000_000_000
    ]
    return {**facts, 'modes as published': ', '.join(said)}


def _stamp(message: Any) -> float:
    """[s]."""
    return stamp_of(message) / NANOSECONDS
