"""What the page of a run is given as JSON: everything at 100 Hz, rounded; lengths in mm, angles in
degrees.
"""

from typing import Any

import numpy as np

from wholearm_ros.model.hand import SIDES
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.report.figures.mode_spans import executed_spans, planned_spans
from wholearm_ros.report.figures.outlines import touching
from wholearm_ros.report.figures.palette import MODE_COLOURS, MODE_NAMES
from wholearm_ros.report.figures.time_figure import torque_window
from wholearm_ros.report.html.scene import numbers, scene
from wholearm_ros.report.run_view import RunView, controlled, planned_poses_at, setpoints_at

RATE = 100.0  # [1/s]


def run_data(plan: ContactPlan, trajectory: ManipulationTrajectory, run: RunView) -> dict[str, Any]:
    """Of one run; NaN becomes null."""
    every = max(1, round(1.0 / (RATE * float(np.median(np.diff(run.times))))))
    rows = np.arange(0, len(run.times), every)
    both, times = controlled(trajectory, run), run.times[rows]
    planned_angles = setpoints_at(trajectory, times)[1]
    bottom, top, note = torque_window(both)
    return {
        'times': numbers(times, 4),
        'modes': [run.modes[k] for k in rows],
        'pose': _pose(run.poses[rows]),
        'estimate': _pose(_estimates(run)[rows]),
        'planned_pose': _pose(planned_poses_at(trajectory, times)),
        'angles': numbers(np.degrees(run.angles[rows]), 3),
        'planned_angles': numbers(np.degrees(planned_angles), 3),
        'touches': _touches(plan.scenario, run, rows),
        'torque_side': both.torque_side[rows].tolist(),
        'torque': numbers(both.torque[rows], 4),
        'planned_torque': numbers(both.planned_torque[rows], 4),
        'low': numbers(both.torque_range[rows, 0], 4),
        'high': numbers(both.torque_range[rows, 1], 4),
        'angle': numbers(np.degrees(both.angle[rows]), 3),
        'planned_angle': numbers(np.degrees(both.planned_angle[rows]), 3),
        'error': numbers(1e3 * both.angle_error[rows], 3),
        'torque_window': [bottom, top],
        'torque_note': note,
        'planned_modes': [
            [round(a, 4), round(b, 4), mode] for a, b, mode in planned_spans(trajectory)
        ],
        'executed_modes': [
            [round(float(a), 4), round(float(b), 4), mode] for a, b, mode in executed_spans(run)
        ],
        'subgoal_times': subgoal_times(plan, trajectory),
        'colours': MODE_COLOURS,
        'names': MODE_NAMES,
        'sides': SIDES,
        'scene': scene(plan.scenario, run.poses[rows], run.angles[rows]),
    }


def subgoal_times(plan: ContactPlan, trajectory: ManipulationTrajectory) -> dict[int, float]:
    """Number → time [s] at which the planned trajectory comes nearest to each subgoal of the route,
    in their order.
    """
    way = np.hstack([trajectory.poses, trajectory.angles]) / [0.1, 0.1, 1.0, 1.0, 1.0]
    configurations = {s.number: s.configuration for s in plan.subgoals}
    found, begin = {}, 0
    for number in plan.path:
        away = np.abs(way[begin:] - configurations[number] / [0.1, 0.1, 1.0, 1.0, 1.0]).sum(axis=1)
        begin += int(np.argmin(away))
        found[number] = round(float(trajectory.times[begin]), 3)
    return found


def _estimates(run: RunView) -> np.ndarray:
    """(m, 3), NaN where there is none."""
    return np.full((len(run.times), 3), np.nan) if run.estimates is None else run.estimates


def _touches(scenario: Scenario, run: RunView, rows: np.ndarray) -> list[Any]:
    """A row an instant: x, y, normal x, normal y of each contact, one after the other [mm, mm, 1,
    1].
    """
    result = []
    for k in rows:
        points, normals = touching(scenario, np.concatenate([run.poses[k], run.angles[k]]))
        result.append(numbers(np.hstack([1e3 * points, normals]).ravel(), 2))
    return result


def _pose(poses: np.ndarray) -> Any:
    """A row a pose [mm, mm, °]."""
    return numbers(poses * [1e3, 1e3, 180.0 / np.pi], 3)
