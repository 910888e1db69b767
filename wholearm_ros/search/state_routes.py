"""Routes of the search over states at rest, as contact plans."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from wholearm_ros.model.modes import DYNAMIC, QUASI_STATIC
from wholearm_ros.model.plan import (
    EXHAUSTED,
    FOUND,
    LIMIT_REACHED,
    NOT_EXECUTABLE,
    TIME_SPENT,
    X_END,
    X_GOAL,
    Leg,
    Subgoal,
    Y,
)
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.planning.problem import PlanningProblem
from wholearm_ros.planning.routes import Found, Routes, SearchOptions, Stop
from wholearm_ros.search.arcs import Arcs, whole_graph
from wholearm_ros.search.belief import Samples
from wholearm_ros.search.state_search import (
    KINDS,
    QUASI_STATIC_KINDS,
    Kind,
    build_tree,
    next_goal,
)
from wholearm_ros.search.state_tree import State
from wholearm_ros.search.ways import Way

GOOD_LOSS = 0.2  # of a goal that is given as soon as it is found
GIVEN_UP = 10  # routes that failed on the way to a goal with more loss, which is then not given
REPORT_EVERY = 1000  # simulations
FIVE = 5  # contacts of a Y
NO_LIMIT = 10**9


class StateRoutes(Routes):
    """Routes through the tree of states at rest, each on another way to the goal, whichever leg
    failed. beliefs: the samples of a problem; progress: is called with a line for people now and
    then; kinds: of ways.
    """

    def __init__(
        self,
        scenario: Scenario,
        options: SearchOptions,
        beliefs: Callable[[PlanningProblem], Samples],
        stop: Stop = lambda: False,
        progress: Callable[[str], None] = lambda line: None,
        kinds: Sequence[Kind] | None = None,
    ) -> None:
        super().__init__(scenario, options, stop)
        self._progress = progress
        if kinds is None:
            kinds = KINDS if options.move_limit else QUASI_STATIC_KINDS
        self.arcs = whole_graph(self.problem, options.limit, stop)
        self.tree = build_tree(self.problem, beliefs(self.problem), self.arcs, kinds)
        self._limit = options.move_limit or NO_LIMIT
        self._given: int | None = None  # place of the last goal
        self._poor: list[int] = []  # places of goals that are yet to be given

    def _search(self, failed_leg: int | None) -> Found:
        if failed_leg is not None:
            self.tree.refuse(self._place_after(failed_leg))
        k = self._given = self._next_goal()
        network = self.arcs.graph.network
        counts = {
            'expansions': self.arcs.graph.traced,
            'states_at_rest': len(self.tree.states),
            'simulations': self.tree.simulated,
            **network.counts(),
        }
        if k is None:
            return Found(*self._why_none(), counts, tuple(network.subgoals))
        writer = _RouteWriter(self.arcs)
        for place in self.tree.places_to(k):
            writer.append(self.tree.states[place])
        goal = self.tree.states[k]
        return Found(
            FOUND,
            _reason(goal, writer.legs),
            {**counts, 'subgoals': len(writer.subgoals)},
            tuple(writer.subgoals),
            tuple(writer.path),
            tuple(writer.legs),
            {**_margin_of(goal, writer.legs), 'total': goal.paid},
        )

    def _next_goal(self) -> int | None:
        """See `next_goal`: good ones as they are found, the others, the best first, when nothing is
        left to search; with a line for people now and then.
        """
        tree = self.tree
        while tree.simulated < self._limit and not (tree.exhausted or self.stop()):
            k = next_goal(tree, min(self._limit, tree.simulated + REPORT_EVERY), self.stop)
            self._progress(f'{tree.simulated} simulations, {len(tree.states)} states at rest')
            if k is None:
                continue
            if tree.states[k].belief.loss <= GOOD_LOSS:
                return k
            self._poor.append(k)
        self._poor = [k for k in self._poor if tree.refusals(tree.states[k].parent) < GIVEN_UP]
        if not self._poor:
            return None
        self._poor.sort(key=lambda k: -tree.states[k].belief.loss)
        return self._poor.pop()

    def _place_after(self, leg: int) -> int:
        """Of the state to which a leg of the last route leads."""
        assert self._given is not None, 'a leg can only fail of a route that was given'
        for place in self.tree.places_to(self._given):
            way = self.tree.states[place].way
            leg -= len(way.legs) if way else 0
            if leg < 0:
                break
        return place

    def _why_none(self) -> tuple[str, str]:
        """(outcome, reason) of a search that ended without a route."""
        tree, graph = self.tree, self.arcs.graph
        nearest = min(max(0.0, self.problem.rotation_left(s.rest.q)) for s in tree.states)
        reached = (
            f'no sequence of arcs and dynamic primitives was found in {tree.simulated} '
            f'simulations, the nearest of {len(tree.states)} states at rest is {nearest:.2f} rad '
            'from the goal'
        )
        if self.stop():
            return TIME_SPENT, f'the time was spent before the search found a route: {reached}'
        if 0 in self.arcs.prospects:
            return NOT_EXECUTABLE, f'no route along arcs survives; {reached}'
        if graph.exhausted:
            arcs = 'the graph of contact states is exhausted and holds no route to the goal'
            return EXHAUSTED, f'{arcs}; {reached}'
        return LIMIT_REACHED, f'the limit of expansions was reached before a route; {reached}'


def _margin_of(goal: State, legs: list[Leg]) -> dict[str, float]:
    """The torque margin of a route [N m], where it has arcs."""
    return {'margin': goal.margin} if any(leg.mode == QUASI_STATIC for leg in legs) else {}


def _reason(goal: State, legs: list[Leg]) -> str:
    """What was found."""
    kinds = ', '.join(dict.fromkeys(leg.mode.replace('_', '-') for leg in legs))
    told = f'{len(legs)} legs ({kinds})'
    for margin in _margin_of(goal, legs).values():
        narrow = 'no torque margin where it is narrowest'
        told += f', torque margin {margin:.3f} N m' if margin > 0.0 else f', {narrow}'
    return told


class _RouteWriter:
    """Puts the ways of a route together: the subgoals of the first graph of arcs keep their
    numbers, others get new ones.
    """

    def __init__(self, root: Arcs) -> None:
        network = root.graph.network
        self.subgoals, self.path = list(network.subgoals), [1]
        self.legs: list[Leg] = []
        # numbers by those in the network of each graph
        self._numbers = {root: {s.number: s.number for s in network.subgoals}}

    def append(self, state: State) -> None:
        """The way to a state."""
        assert state.way is not None
        if state.way.arcs is None:
            self._append_leg(state, *state.way.legs)
        else:
            self._append_arcs(state.way, state.way.arcs)

    def _append_leg(self, state: State, leg: Leg) -> None:
        """A leg between two states, of no graph."""
        here, number = self.path[-1], len(self.subgoals) + 1
        kind = X_GOAL if state.goal else Y if len(leg.contacts) >= FIVE else X_END
        turn = int(np.sign(leg.action['turn'])) if leg.mode == DYNAMIC else 0
        self.subgoals.append(Subgoal(number, kind, state.rest.q, leg.contacts, turn, here))
        self.legs.append(replace(leg, start=here, end=number))
        self.path.append(number)

    def _append_arcs(self, way: Way, arcs: Arcs) -> None:
        """Part of an edge."""
        numbers = self._numbers.setdefault(arcs, {1: self.path[-1]})
        for number in way.numbers:
            if number not in numbers:
                old = arcs.graph.network.subgoals[number - 1]
                numbers[number] = len(self.subgoals) + 1
                self.subgoals.append(replace(old, number=numbers[number], parent=self.path[-1]))
            self.path.append(numbers[number])
        self.legs.extend(
            replace(leg, start=numbers[leg.start], end=numbers[leg.end]) for leg in way.legs
        )
