"""NEW_SUBGOAL: drive the velocity-controlled finger from a four-contact subgoal to the next event
(III-A.4).
"""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.kernels import arc_tracing, geometry
from wholearm_ros.mechanics.contacts import closed_pairs
from wholearm_ros.model.configuration import POSE
from wholearm_ros.model.modes import CAGING
from wholearm_ros.planning.arc import Arc, arc_to_goal, tangent, trace
from wholearm_ros.planning.caging_descent import releases
from wholearm_ros.planning.problem import PlanningProblem

WIDE_ENOUGH = 0.4  # [N m] robust half widths beyond this count as equal
CHANGE_COST = 1.0  # of one contact-state change, against motion in rad
MOST_THROUGH = 12  # X_through in one expansion
UNREACHED, REACHED, NEW_Y = 'unreached', 'reached', 'new_y'


@dataclass(frozen=True, eq=False)
class Expansion:
    """What NEW_SUBGOAL found: the arcs, with an X_through between each two, and how it ended.

    outcome: NEW_Y with the `pairs` closed at the end, REACHED at the goal, or UNREACHED.
    """

    arcs: tuple[Arc, ...]
    outcome: str
    pairs: tuple[int, ...] = ()

    @property
    def end(self) -> np.ndarray:
        """(5,) the last configuration [m, rad]."""
        return np.asarray(self.arcs[-1].configurations[-1])

    def margin(self) -> float:
        """Least robust half width [N m] of the quasi-static arcs, each with the better assignment
        of the fingers; at most WIDE_ENOUGH.
        """
        widths = [
            arc.robust_half_width().max()
            for arc in self.arcs
            if arc.mode != CAGING and len(arc.statics) > 1
        ]
        return float(min([WIDE_ENOUGH, *widths]))

    def cost(self, scale: np.ndarray) -> float:
        """Contact-state changes plus motion in scaled coordinates [rad]; scale: (5,) of those."""
        return float(sum(CHANGE_COST + arc.length(scale) for arc in self.arcs))


def new_subgoal(
    problem: PlanningProblem,
    q: np.ndarray,
    pairs: tuple[int, ...],
    toward: np.ndarray,
    driver: int = -1,
) -> tuple[Expansion, ...]:
    """NEW_SUBGOAL from X = (q, pairs), q (5,), towards the side of `toward` (5,): all expansions.

    There is more than one when the object can be released on the way: each release ends one, and
    so does the arc itself. driver: the velocity-controlled finger (LEFT or RIGHT), which must not
    reverse, or −1 when either may drive.
    """
    ends: list[Expansion] = []
    done: list[Arc] = []
    for _ in range(MOST_THROUGH):
        arc, event, which = trace(problem, q, pairs, toward, driver)  # steps 1–6, 10
        if len(arc.configurations) == 0:
            break
        goal = arc_to_goal(problem, arc)
        if goal is not None:  # step 7
            return (*ends, Expansion((*done, goal), REACHED))
        for before, descent in releases(problem, arc):  # steps 4 and 7: gravity does the rest
            outcome = REACHED if problem.reached(descent.configurations[-1, POSE]) else NEW_Y
            ends.append(Expansion((*done, before, descent), outcome, descent.pairs))
        done.append(arc)
        q = arc.configurations[-1]
        if event == arc_tracing.CLOSED:  # step 8
            after = closed_pairs(problem.world, q)
            if len(after) > 4:
                return (*ends, Expansion(tuple(done), NEW_Y, after))
        if event != arc_tracing.EDGE_END:  # step 5
            break
        following = int(arc_tracing.next_pair_at_end(problem.world, which, q))
        if following < 0 or following in pairs:
            break
        pairs = tuple(sorted(following if c == which else c for c in pairs))  # step 9: X_through
        if driver < 0:
            toward = _onto_edge(problem, q, pairs, following)
    return tuple(ends) or (Expansion(tuple(done), UNREACHED),)


def _onto_edge(
    problem: PlanningProblem, q: np.ndarray, pairs: tuple[int, ...], pair: int
) -> np.ndarray:
    """(5,) the tangent along which the contact point of `pair`, at the end of its edge, moves onto
    that edge.
    """
    t = tangent(problem, q, pairs)
    here = geometry.contact(problem.world, pair, q)
    there = geometry.contact(problem.world, pair, q + 1e-6 * t)
    away_from_start = there[5] - here[5]
    at_start = here[5] < 0.5 * here[6]
    return t if (away_from_start > 0.0) == at_start else -t
