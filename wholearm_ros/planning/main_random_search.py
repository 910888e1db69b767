"""MAIN_RANDOM_SEARCH: the paper's randomized search for contact-state transitions (III-A.3)."""

from typing import Callable, Optional

import numpy as np

from wholearm_ros.mechanics.contacts import four_contact_subsets
from wholearm_ros.model.hand import RIGHT
from wholearm_ros.model.plan import EXHAUSTED, FOUND, LIMIT_REACHED, TIME_SPENT
from wholearm_ros.planning.new_subgoal import REACHED, new_subgoal
from wholearm_ros.planning.problem import PlanningProblem
from wholearm_ros.planning.subgoal_network import SubgoalNetwork

DIRECTIONS = (1, -1)


def main_random_search(
    task: PlanningProblem,
    rng: np.random.Generator,
    limit: int,
    velocity_finger: int = RIGHT,
    stop: Callable[[], bool] = lambda: False,
) -> tuple[str, SubgoalNetwork, Optional[int], int]:
    """Steps 1–5. Returns (outcome, network, number of the goal subgoal or None, iterations).

    limit: of iterations, i_max; stop: whether to give up, asked in each of them."""
    network = SubgoalNetwork(task)
    open_choices = [_choices(network.nodes[0])]
    for iteration in range(1, limit + 1):
        candidates = [k for k, choices in enumerate(open_choices) if choices]
        if not candidates:
            return EXHAUSTED, network, None, iteration - 1
        if stop():
            return TIME_SPENT, network, None, iteration - 1
        k = candidates[rng.integers(len(candidates))]  # step 2: Y_rand
        pairs, direction = open_choices[k].pop(
            int(rng.integers(len(open_choices[k])))
        )  # step 3: X_start, dir_joint
        node = network.nodes[k]
        toward = np.zeros(5)
        toward[3 + velocity_finger] = direction
        expansion = new_subgoal(task, node.configuration, pairs, toward, velocity_finger)[
            0
        ]  # step 4
        if not expansion.arcs:
            continue
        attached = network.attach(node, pairs, direction, expansion)
        if expansion.outcome == REACHED:
            return FOUND, network, attached.node.number, iteration
        if attached.new:
            open_choices.append(_choices(attached.node))
    return LIMIT_REACHED, network, None, limit


def _choices(node):
    return [
        (pairs, direction) for pairs in four_contact_subsets(node.pairs) for direction in DIRECTIONS
    ]
