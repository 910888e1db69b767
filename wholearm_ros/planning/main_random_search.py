"""MAIN_RANDOM_SEARCH: the paper's randomized search for contact-state transitions (III-A.3)."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from wholearm_ros.mechanics.contacts import four_contact_subsets
from wholearm_ros.model.configuration import SIZE, joint_index
from wholearm_ros.model.hand import RIGHT
from wholearm_ros.model.plan import EXHAUSTED, FOUND, LIMIT_REACHED, TIME_SPENT
from wholearm_ros.planning.new_subgoal import REACHED, new_subgoal
from wholearm_ros.planning.problem import PlanningProblem
from wholearm_ros.planning.subgoal_network import Node, SubgoalNetwork

DIRECTIONS = (1, -1)
Choice = tuple[tuple[int, ...], int]  # four pairs to keep, and dir_joint


class RandomSearchResult(NamedTuple):
    """outcome: see ContactPlan; goal: number of the goal subgoal in the network, None without one;
    iterations: how many were made.
    """

    outcome: str
    network: SubgoalNetwork
    goal: int | None
    iterations: int


def main_random_search(
    problem: PlanningProblem,
    rng: np.random.Generator,
    limit: int,
    velocity_finger: int = RIGHT,
    stop: Callable[[], bool] = lambda: False,
) -> RandomSearchResult:
    """Steps 1–5 of the paper.

    limit: of iterations, i_max; velocity_finger: LEFT or RIGHT throughout; stop: whether to give
    up, asked in each iteration.
    """
    network = SubgoalNetwork(problem)
    open_choices = [_choices(network.nodes[0])]
    for iteration in range(1, limit + 1):  # steps 1, 5
        candidates = [k for k, choices in enumerate(open_choices) if choices]
        if not candidates:
            return RandomSearchResult(EXHAUSTED, network, None, iteration - 1)
        if stop():
            return RandomSearchResult(TIME_SPENT, network, None, iteration - 1)
        k = candidates[rng.integers(len(candidates))]  # step 2: Y_rand
        choice = int(rng.integers(len(open_choices[k])))
        pairs, direction = open_choices[k].pop(choice)  # step 3: X_start, dir_joint
        node, toward = network.nodes[k], np.zeros(SIZE)
        toward[joint_index(velocity_finger)] = direction
        expansions = new_subgoal(problem, node.configuration, pairs, toward, velocity_finger)
        expansion = expansions[0]  # step 4
        if not expansion.arcs:
            continue
        attached = network.attach(node, pairs, direction, expansion)
        if attached.node is not None and expansion.outcome == REACHED:
            return RandomSearchResult(FOUND, network, attached.node.number, iteration)
        if attached.node is not None and attached.new:
            open_choices.append(_choices(attached.node))
    return RandomSearchResult(LIMIT_REACHED, network, None, limit)


def _choices(node: Node) -> list[Choice]:
    return [
        (pairs, direction) for pairs in four_contact_subsets(node.pairs) for direction in DIRECTIONS
    ]
