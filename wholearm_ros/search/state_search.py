"""The search: a tree of states at rest, grown best first by arcs, caging descents and motion
primitives alike.

Every way out of a state is executed in closed loop by the samples that have arrived in it, and what
it leads to becomes a state only if enough of them arrive there: a prefix is simulated once for all
routes through it, a failure costs one way and not a trajectory, and a route that comes out has been
verified on the way. The graph of arcs, without physics, says which of them lead on to the goal.
"""

from collections.abc import Callable, Sequence
from typing import Protocol

from wholearm_ros.planning.problem import PlanningProblem
from wholearm_ros.search.arc_ways import ArcWays
from wholearm_ros.search.arcs import Arcs
from wholearm_ros.search.belief import Samples
from wholearm_ros.search.caging_ways import CagingWays
from wholearm_ros.search.primitive_ways import PrimitiveWays
from wholearm_ros.search.state_tree import StateTree


class Ways(Protocol):
    """Those of one kind."""

    def open(self, k: int) -> None:
        """Queue those that leave state k of the tree."""


Kind = Callable[[StateTree], Ways]
QUASI_STATIC_KINDS: tuple[Kind, ...] = (CagingWays, ArcWays)
KINDS: tuple[Kind, ...] = (*QUASI_STATIC_KINDS, PrimitiveWays)


def build_tree(
    problem: PlanningProblem, samples: Samples, arcs: Arcs, kinds: Sequence[Kind] = KINDS
) -> StateTree:
    """The tree of a problem whose start is the first node of `arcs`."""
    tree = StateTree(problem, samples, arcs)
    tree.openers = tuple(kind(tree).open for kind in kinds)
    tree.open(0)
    return tree


def next_goal(tree: StateTree, limit: int, stop: Callable[[], bool] = lambda: False) -> int | None:
    """Place of the next state at the goal, None without one.

    limit: of simulations in the whole tree; stop: whether to give up, asked now and then.
    """
    while not tree.exhausted and tree.simulated < limit and not stop():
        k = tree.grow()
        if k is not None and tree.states[k].goal:
            return k
    return None
