"""Caging descents: where the object may be released on an arc, and how it descends between the
fingers (III-B.3).
"""

from collections.abc import Iterator

import numpy as np

from wholearm_ros.kernels import geometry
from wholearm_ros.mechanics.caging import Cage
from wholearm_ros.mechanics.contacts import closed_pairs, closing_angle, pose_on_palm
from wholearm_ros.model.configuration import ROTATION, SIZE
from wholearm_ros.model.modes import CAGING
from wholearm_ros.model.orientation import palm_segment_under
from wholearm_ros.planning.arc import Arc
from wholearm_ros.planning.problem import PlanningProblem

LARGEST_ROLL = 0.08  # [rad] between two samples of a descent


def releases(problem: PlanningProblem, arc: Arc) -> Iterator[tuple[Arc, Arc]]:
    """Check_Caging: (arc up to the release, descent) for the last, the middle and the first sample
    of the arc at which the object may be released.
    """
    angles = arc.configurations[:, ROTATION]
    held = np.any(arc.statics[:, :, 1] >= arc.statics[:, :, 0], axis=1)
    caged = [
        i
        for i, angle in enumerate(angles)
        if held[i] and arc.tangents[i, ROTATION] > 0.0 and problem.cage_at(angle) is not None
    ]
    if not caged or not any(
        geometry.pair_body(c) == geometry.PALM and geometry.pair_kind(c) == geometry.VERTEX_EDGE
        for c in arc.pairs
    ):
        return
    for i in sorted({caged[0], caged[len(caged) // 2], caged[-1]}, reverse=True):
        cage = problem.cage_at(angles[i])
        down = None if cage is None else caging_descent(problem, arc.configurations[i], cage)
        if down is None or i == 0:
            continue
        pairs = closed_pairs(problem.world, down[-1])
        descent = Arc(CAGING, pairs, down, np.empty((0, SIZE)), np.empty((0, 2, 4)), 'landed')
        yield arc.up_to(i + 1, 'caged'), descent


def caging_descent(problem: PlanningProblem, q: np.ndarray, cage: Cage) -> np.ndarray | None:
    """(m, 5) from q (5,): the centroid descends vertically, the object rolls over its lowest
    vertices, both fingers stay closed on it.

    None where a finger has no room on the way.
    """
    w = problem.world
    landed = problem.landed(q, cage)
    if landed is None:
        return None
    steps = max(2, int(np.ceil((cage.landing - q[ROTATION]) / LARGEST_ROLL)))
    samples, segment = [q], palm_segment_under(problem.scenario.palm, q[0])
    for angle in np.linspace(q[ROTATION], cage.landing, steps + 1)[1:-1]:
        pose = pose_on_palm(w, q[0], angle, segment)
        fingers = [closing_angle(w, pose, side) for side in range(2)]
        if np.isnan(fingers).any():
            return None
        samples.append(np.array([*pose, *fingers]))
    return np.array([*samples, landed])
