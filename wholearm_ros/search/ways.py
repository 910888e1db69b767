"""Ways: how one state at rest is left for another, as legs of a plan and as a course."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from wholearm_ros.control.mode_switch import course_of
from wholearm_ros.kernels.switch_law import Course
from wholearm_ros.kernels.world import World
from wholearm_ros.model.plan import Leg
from wholearm_ros.rollout.primitive_rollout import PrimitiveRecord, Rest
from wholearm_ros.search.arcs import Arcs
from wholearm_ros.trajectory.execution_options import ExecutionOptions
from wholearm_ros.trajectory.joint_trajectory import TrajectoryBuilder
from wholearm_ros.trajectory.main_trajectory import append


@dataclass(frozen=True, eq=False)
class Way:
    """legs: along it, as in a plan; rest: where it ends, and course: of the setpoints that lead
    there; finger: the velocity-controlled one at its end. numbers: of the subgoals on it in the
    network of `arcs`, to which the legs belong, or () when they belong to none.
    """

    legs: tuple[Leg, ...]
    rest: Rest
    course: Course
    finger: int
    arcs: Arcs | None = None
    numbers: tuple[int, ...] = ()


def way_along(world: World, start: Rest, legs: Sequence[Leg]) -> Way | None:
    """Along arcs or down a cage; None when the contacts cannot be kept closed, or nothing
    moves.
    """
    builder = TrajectoryBuilder(world, start, ExecutionOptions())
    try:
        append(builder, legs)
    except ValueError:
        return None
    made = builder.finish('', ())
    if not made.segments:
        return None
    end = Rest(legs[-1].configurations[-1], made.efforts[-1])
    return Way(tuple(legs), end, course_of(made), made.segments[-1].velocity_finger)


def way_of_primitive(start: Rest, record: PrimitiveRecord, leg: Leg) -> Way:
    """By a motion primitive that was simulated."""
    finger = record.move.velocity_finger
    return Way((leg,), record.rest(), record.course(start), finger)


def executed(leg: Leg, **action: Any) -> Leg:
    """The leg, executed otherwise than the rest of its plan."""
    return replace(leg, action=action)
