"""Set_BoundarySubgoal: a route cut into segments, at each of which the hand stops (III-B.5, steps 2
to 4).
"""

from dataclasses import dataclass

from wholearm_ros.kernels.world import World
from wholearm_ros.model.modes import QUASI_STATIC
from wholearm_ros.trajectory.check_transition import TransitionReport, check_transition
from wholearm_ros.trajectory.monotone_segments import Piece


@dataclass(frozen=True, eq=False)
class MonotoneSegment:
    """Pieces through which one velocity finger turns one way without a stop; a caging descent and a
    motion primitive are segments of one piece.

    transitions: the reports of those looked at, the one at its end included; untransitable: the
    report of the transition at its beginning, where the ranges part under one velocity finger (the
    untransitFlag of the paper), else None.
    """

    pieces: tuple[Piece, ...]
    transitions: tuple[TransitionReport, ...] = ()
    untransitable: TransitionReport | None = None

    @property
    def velocity_finger(self) -> int:
        """LEFT or RIGHT, the same for all of its pieces."""
        return self.pieces[0].velocity_finger

    @property
    def mode(self) -> str:
        """QUASI_STATIC, DYNAMIC or CAGING."""
        return self.pieces[0].mode

    @property
    def turn(self) -> float:
        """Angle [rad] through which the velocity finger turns."""
        return sum(piece.turn for piece in self.pieces)


def boundary_subgoals(world: World, pieces: list[Piece]) -> list[MonotoneSegment]:
    """The segments of a route, in order."""
    segments: list[MonotoneSegment] = []
    begin, untransitable = 0, None
    while begin < len(pieces):
        end, transitions = _boundary(world, pieces, begin)
        segments.append(MonotoneSegment(tuple(pieces[begin:end]), transitions, untransitable))
        untransitable = None
        if end < len(pieces) and transitions:
            one_finger = pieces[end].velocity_finger == segments[-1].velocity_finger
            reached = pieces[end].mode == QUASI_STATIC and one_finger
            untransitable = (
                transitions[-1] if reached and not transitions[-1].quasi_static else None
            )
        begin = end
    return segments


def _boundary(
    world: World, pieces: list[Piece], begin: int
) -> tuple[int, tuple[TransitionReport, ...]]:
    """Where the segment that begins with a piece ends: before the piece at which the velocity
    finger reverses or changes, or the torque ranges part; and the reports of Check_Transition.
    """
    if pieces[begin].mode != QUASI_STATIC:
        return begin + 1, ()
    reports: list[TransitionReport] = []
    for k in range(begin + 1, len(pieces)):
        before, after = pieces[k - 1], pieces[k]
        report = check_transition(world, before, after)
        if report is None:
            return k, tuple(reports)
        reports.append(report)
        turns_on = after.direction == before.direction
        if after.velocity_finger != before.velocity_finger or not turns_on:
            return k, tuple(reports)
        if not report.quasi_static:
            return k, tuple(reports)
    return len(pieces), tuple(reports)
