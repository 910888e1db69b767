"""Check_Dwell: whether the contacts carry the torque path of a dwell at which five of them bear.

A dwell leads at rest from one torque range to the next, between which the paper knows only motion
(III-B.1); so its path is certified by the constraints of problem (6).
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from wholearm_ros.kernels.world import World
from wholearm_ros.mechanics.contacts import closed_pairs, pair_name
from wholearm_ros.mechanics.quasistatic import build_quasistatics
from wholearm_ros.mechanics.torque_path import build_torque_path, solve_torque_path
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.modes import DWELL, QUASI_STATIC
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory, Segment

FIVE = 5  # contacts from which on the torques do not determine the forces


@dataclass(frozen=True)
class DwellReport:
    """A dwell between quasi-static motions at which five contacts and more bear.

    start, end [s]; contacts: names of the closed pairs; torques: of the torque finger at both ends
    [N m]; certified: whether the contacts carry every torque between them.
    """

    start: float
    end: float
    contacts: tuple[str, ...]
    torques: tuple[float, float]
    certified: bool


def check_dwells(scenario: Scenario, trajectory: ManipulationTrajectory) -> tuple[DwellReport, ...]:
    """The reports of all such dwells of a trajectory, which was made for `scenario`."""
    world = build_world(scenario)
    dwells = [
        dwell
        for before, (dwell, after) in zip(trajectory.segments, pairwise(trajectory.segments[1:]))
        if dwell.mode == DWELL and before.mode == after.mode == QUASI_STATIC
    ]
    reports = (_report(world, trajectory, dwell) for dwell in dwells)
    return tuple(report for report in reports if report is not None)


def _report(world: World, trajectory: ManipulationTrajectory, dwell: Segment) -> DwellReport | None:
    """None where fewer than five contacts are closed."""
    first, last = (int(round(t / trajectory.period)) for t in (dwell.start, dwell.end))
    q = np.concatenate([trajectory.poses[last], trajectory.angles[last]])
    pairs = closed_pairs(world, q)
    if len(pairs) < FIVE:
        return None
    torques = trajectory.efforts[[first, last], dwell.torque_finger]
    model = build_quasistatics(world, pairs, q)
    path = solve_torque_path(
        build_torque_path(model, dwell.torque_finger, torques, world.torque_limits)
    )
    names, (start, end) = tuple(map(pair_name, pairs)), torques.tolist()
    return DwellReport(dwell.start, dwell.end, names, (start, end), path.certified)
