"""Advice: the smallest change of a scenario without a plan that gives it one."""

from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Any

from wholearm_ros.errors import ScenarioError
from wholearm_ros.model.finger_shape import Rectangle
from wholearm_ros.model.hand import LEFT, RIGHT, SIDES
from wholearm_ros.model.plan import NOT_EXECUTABLE
from wholearm_ros.model.scenario import CCW, CW, GoalOnEdge, Scenario, StartOnEdge
from wholearm_ros.model.scenario_file import parse_scenario, scenario_to_dict
from wholearm_ros.planner.planner import Progress, plan_and_verify
from wholearm_ros.planner.request import PlanRequest, PlanResult
from wholearm_ros.planner.stopwatch import Stopwatch

STEPS_PER_LENGTH = 15  # changes are whole steps of this part of a finger's length: 1 cm of 15 cm
# What one step costs someone at the bench: to set the object down elsewhere, to turn it the other
# way, to move the axes, to build other fingers.
PLACE, TURN, AXES, FINGERS = 1.0, 2.5, 2.0, 3.0
Table = dict[str, Any]


@dataclass(frozen=True, eq=False)
class Change:
    """What is changed, in words; its cost; the scenario that results."""

    what: str
    cost: float
    scenario: Scenario


@dataclass(frozen=True, eq=False)
class Trial:
    """A change and how it was planned; primitives: whether motion primitives were tried, too."""

    change: Change
    result: PlanResult
    primitives: bool

    @property
    def works(self) -> bool:
        """Whether there is a certified plan."""
        return self.result.trajectory is not None

    def to_dict(self) -> Table:
        """For documents."""
        return {
            'change': self.change.what,
            'cost': self.change.cost,
            'primitives': self.primitives,
            **told_of(self.result),
        }


def told_of(result: PlanResult) -> Table:
    """What documents say of a planning call."""
    plan = result.plan
    return {
        'works': result.trajectory is not None,
        'outcome': plan.outcome,
        'reason': plan.reason,
        'certificate': plan.certificate.to_dict() if plan.certificate else None,
    }


def advise(
    scenario: Scenario,
    request: PlanRequest,
    time_budget: float,
    progress: Progress = lambda line: None,
) -> Iterator[Trial]:
    """Trials of one change after the other, the cheapest first, until one works or the budget [s]
    is spent.

    All are tried with arcs alone, which is quick; then, while there is time, with motion primitives
    as well, those first whose arcs have routes that did not survive. request.time_budget [s] is for
    each trial.
    """
    watch, missed = Stopwatch(time_budget), []
    for trial in _trials(changes(scenario), replace(request, moves=0), watch, progress):
        yield trial
        if trial.works:
            return
        missed.append(trial)
    missed.sort(key=lambda trial: trial.result.plan.outcome != NOT_EXECUTABLE)  # else by cost
    for trial in _trials([trial.change for trial in missed], request, watch, progress):
        yield trial
        if trial.works:
            return


def _trials(
    options: list[Change], request: PlanRequest, watch: Stopwatch, progress: Progress
) -> Iterator[Trial]:
    how = 'with motion primitives' if request.moves else 'arcs alone'
    for number, change in enumerate(options, 1):
        left = watch.budget - watch.elapsed()
        if left <= 0.0:
            return
        progress(f'{number} of {len(options)}, {how}: {change.what}')
        asked = replace(request, time_budget=min(request.time_budget, left))
        yield Trial(change, plan_and_verify(change.scenario, asked), request.moves > 0)


def changes(scenario: Scenario) -> list[Change]:
    """Single changes by their cost; those that are no possible scenario are left out."""
    told = scenario_to_dict(scenario)
    found = []
    for what, cost, table in _tables(scenario, told):
        try:
            found.append(Change(what, cost, parse_scenario(table)))
        except ScenarioError:
            continue
    return sorted(found, key=lambda change: change.cost)


def _tables(scenario: Scenario, told: Table) -> Iterator[tuple[str, float, Table]]:
    start, goal, hand = scenario.start, scenario.goal, scenario.hand
    step = min(hand.left.shape.length, hand.right.shape.length) / STEPS_PER_LENGTH
    if isinstance(start, StartOnEdge):
        for steps in (1, -1, 2, -2, 3, -3):
            x = round(start.x + steps * step, 6)
            yield _told('start.x', start.x, x), PLACE * abs(steps), _with(told, ('start', 'x'), x)
    if isinstance(goal, GoalOnEdge) and goal.direction is not None:
        other = CW if goal.direction == CCW else CCW
        what = f'goal.direction: {other} instead of {goal.direction}'
        yield what, TURN, _with(told, ('goal', 'direction'), other)
    for steps in (1, -1, 2, -2, 3, -3):
        by, words = steps * step, f'{1e3 * abs(steps) * step:.4g} mm'
        apart = 'farther out' if steps > 0 else 'farther in'
        height, size = ('higher', 'longer') if steps > 0 else ('lower', 'shorter')
        yield f'both axes {words} {apart}', AXES * abs(steps), _moved(told, (-by, 0), (by, 0))
        yield f'both axes {words} {height}', AXES * abs(steps), _moved(told, (0, by), (0, by))
        if all(isinstance(hand[side].shape, Rectangle) for side in (LEFT, RIGHT)):
            yield f'both fingers {words} {size}', FINGERS * abs(steps), _stretched(told, by)


def _told(key: str, old: float, new: float) -> str:
    return f'{key}: {new:g} m instead of {old:g} m'


def _with(told: Table, keys: tuple[str, str], value: object) -> Table:
    return {**told, keys[0]: {**told[keys[0]], keys[1]: value}}


def _moved(told: Table, *by: tuple[float, float]) -> Table:
    """The axes of both fingers moved by (x, y) [m] each."""
    table = deepcopy(told)
    for side, move in zip(SIDES, by):
        axis = table['hand'][side]['axis']
        table['hand'][side]['axis'] = [round(a + d, 6) for a, d in zip(axis, move)]
    return table


def _stretched(told: Table, by: float) -> Table:
    """Both fingers longer by `by` [m]."""
    table = deepcopy(told)
    for side in SIDES:
        table['hand'][side]['length'] = round(table['hand'][side]['length'] + by, 6)
    return table
