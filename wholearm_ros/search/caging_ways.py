"""Caging descents as ways out of a state."""

from dataclasses import dataclass, replace
from functools import partial

from wholearm_ros.model.configuration import POSE, ROTATION
from wholearm_ros.model.modes import CAGING
from wholearm_ros.model.plan import Leg
from wholearm_ros.planning.caging_descent import caging_descent
from wholearm_ros.search.state_tree import State, StateTree
from wholearm_ros.search.ways import executed, way_along
from wholearm_ros.trajectory.execution_options import FRONT, REAR

# velocity finger and torque [N m] in caging, the most promising first
CAGING_EXECUTIONS = ((FRONT, 0.1), (REAR, 0.1), (FRONT, 0.02), (REAR, 0.3), (FRONT, 0.3))
DESCENT_PRICE = 0.01  # against a radian of the rotation that is left
LATER = 0.03  # of another way to execute the same descent


@dataclass(frozen=True, eq=False)
class CagingWays:
    """Down from every state in which gravity alone turns the object on."""

    tree: StateTree

    def open(self, k: int) -> None:
        """Queue those that leave state k."""
        state = self.tree.states[k]
        leg = self._descent(state)
        if leg is None:
            return
        price = self.tree.price_at(k, leg.configurations[-1])
        for number, (finger, torque) in enumerate(CAGING_EXECUTIONS):
            down = executed(leg, caging_finger=finger, caging_torque=torque)
            self.tree.push(k, price + number * LATER, partial(self._down, k, down))

    def _descent(self, state: State) -> Leg | None:
        """That of the edge on which the state lies, or one of its own."""
        if state.descent is not None:
            assert state.arcs is not None
            return state.arcs.legs(state.descent)[-1]
        problem = self.tree.problem
        cage = problem.cage_at(state.rest.q[ROTATION])
        down = caging_descent(problem, state.rest.q, cage) if cage else None
        return None if down is None else Leg(0, 0, CAGING, self.tree.names(down[-1]), down)

    def _down(self, k: int, leg: Leg) -> int | None:
        state, end = self.tree.states[k], leg.configurations[-1]
        edge, goal = state.descent, self.tree.problem.reached(end[POSE])
        node = edge.end if edge else None
        key = (k, *leg.action.values()) if goal else self.tree.key(state.arcs, node, end)
        if self.tree.known(key, state.belief.loss):
            return None
        way = way_along(self.tree.problem.world, state.rest, [leg])
        if way is None:
            return None
        if edge is None or state.arcs is None:
            return self.tree.execute(state.then(k, way, DESCENT_PRICE, goal=goal), key)
        numbers = edge.numbers[-1:]
        if node is not None:
            numbers = (*numbers, state.arcs.number(node))
        way = replace(way, arcs=state.arcs, numbers=numbers)
        after = state.then(k, way, DESCENT_PRICE, arcs=state.arcs, node=node, goal=goal)
        return self.tree.execute(after, key)
