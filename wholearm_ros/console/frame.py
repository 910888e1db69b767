"""One instant as the page draws it, in mm, degrees and N m, few digits: thirty of them a second."""

from typing import Any

import numpy as np

from wholearm_ros.control.setpoints import Joints
from wholearm_ros.launcher.client import LatestMessages
from wholearm_ros.launcher.live_view import RESTING, moment_of
from wholearm_ros.model.hand import CLOSING
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.report.figures.outlines import touching
from wholearm_ros.report.html.scene import numbers
from wholearm_ros.report.run_view import planned_poses_at
from wholearm_ros.ros.interface.joint_state_serialization import NANOSECONDS

TO_PAGE = np.array([1e3, 1e3, 180.0 / np.pi])  # [m, m, rad] → [mm, mm, °]
Estimated = tuple[np.ndarray, np.ndarray]  # pose (3,) and standard deviations (3,)


def frame(
    scenario: Scenario,
    latest: LatestMessages,
    stamp: int,
    joints: Joints,
    estimated: Estimated | None,
    truth: np.ndarray | None,
) -> dict[str, Any]:
    """Of the joints at `stamp` [ns].

    t [s]; a: both angles; q: both pressing torques, positive towards the other finger; e, d: the
    object as estimated and its standard deviations; o: as it truly is, where somebody tells; n:
    contacts, x, y, normal x, y of one after the other; g: what is planned for now, see `_planned`.
    """
    told: dict[str, Any] = {
        'type': 'frame',
        't': round(stamp / NANOSECONDS, 3),
        'a': numbers(np.degrees(joints.angles), 2),
        'q': numbers(np.array(CLOSING) * joints.efforts, 3),
        'm': latest.mode,
    }
    if estimated is not None and joints.finite:
        pose, deviations = estimated
        told |= {'e': numbers(TO_PAGE * pose, 2), 'd': numbers(TO_PAGE * deviations, 2)}
        points, normals = touching(scenario, np.concatenate([pose, joints.angles]))
        told['n'] = numbers(np.hstack([1e3 * points, normals]).ravel(), 2)
    if truth is not None:
        told['o'] = numbers(TO_PAGE * truth, 2)
    planned = _planned(latest, stamp, joints)
    return told | {'g': planned} if planned else told


def _planned(latest: LatestMessages, stamp: int, joints: Joints) -> dict[str, Any] | None:
    """While a trajectory runs: where object and fingers should be (p, a), the torque-controlled
    finger (s), its torque as planned (q) and its feasible range (r), the time on the trajectory.
    """
    trajectory, start = latest.trajectory, latest.progress.get('trajectory start')
    if trajectory is None or not start or latest.mode in RESTING:
        return None
    if latest.progress.get('goal') != trajectory.plan_id:
        return None
    time = (stamp - int(start)) / NANOSECONDS
    if not 0.0 <= time <= trajectory.duration:
        return None
    moment = moment_of(trajectory, latest.mode, time, joints.angles, joints.efforts)
    sample, side = trajectory.sample(time), moment.torque_side
    return {
        'p': numbers(TO_PAGE * planned_poses_at(trajectory, np.array([time]))[0], 2),
        'a': numbers(np.degrees(sample.angles), 2),
        's': side,
        'q': round(float(CLOSING[side] * sample.efforts[side]), 3),
        'r': None if moment.torque_range is None else numbers(moment.torque_range, 3),
        't': round(time, 3),
        'end': round(trajectory.duration, 3),
    }
