"""A contact plan: the subgoals found by Phase 1, and the legs that lead from start to goal."""

import json
import uuid
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from wholearm_ros.errors import DocumentError, ScenarioError
from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.band import Band
from wholearm_ros.model.certificate import Certificate
from wholearm_ros.model.scenario import GoalOnEdge, Scenario, StartOnEdge
from wholearm_ros.model.scenario_file import parse_scenario, scenario_to_dict

FORMAT = 'wholearm-contact-plan/1'
X_INIT, X_START, X_THROUGH, X_END = 'X_init', 'X_start', 'X_through', 'X_end'
X_GOAL, Y = 'X_goal', 'Y'
FOUND, EXHAUSTED, LIMIT_REACHED = 'found', 'exhausted', 'limit_reached'
TIME_SPENT, NOT_EXECUTABLE = 'time_spent', 'not_executable'
OUTCOMES = (FOUND, EXHAUSTED, LIMIT_REACHED, TIME_SPENT, NOT_EXECUTABLE)
ID_NAMESPACE = uuid.UUID('6f1d2a4e-52a1-5c0e-9a53-0b6f2f6c9d10')
# What reading a damaged document may raise, besides the errors of this package.
DAMAGES = (ValueError, OverflowError, TypeError, KeyError, AttributeError, RecursionError)


@dataclass(frozen=True, eq=False)
class Subgoal:
    """One X or Y of the subgoal network (III-A.2).

    kind: X_INIT to Y above; configuration: (5,) x, y, φ, θ_L, θ_R [m, rad]; contacts: names of the
    closed pairs; direction: sign of the velocity finger's motion towards it, 0 where there is none;
    parent: number of the subgoal before it, or None.
    """

    number: int
    kind: str
    configuration: np.ndarray
    contacts: tuple[str, ...]
    direction: int = 0
    parent: int | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, 'configuration', readonly(self.configuration, (5,)))

    def to_dict(self) -> dict[str, Any]:
        """For documents."""
        return {
            'number': self.number,
            'kind': self.kind,
            'configuration': self.configuration.tolist(),
            'contacts': list(self.contacts),
            'direction': self.direction,
            'parent': self.parent,
        }

    @classmethod
    def from_dict(cls, d: dict[str, Any]) -> 'Subgoal':
        """Raises one of DAMAGES when something is missing or of the wrong kind."""
        return cls(
            d['number'],
            d['kind'],
            d['configuration'],
            tuple(d['contacts']),
            d['direction'],
            d['parent'],
        )


@dataclass(frozen=True, eq=False)
class Leg:
    """The way from one subgoal to the next with the same closed pairs.

    start, end: numbers of the subgoals; mode: of Phase 1, quasi_static, dynamic or caging;
    contacts: names of the closed pairs; configurations: (m, 5) [m, rad] along the way; action: the
    motion primitive of a dynamic leg, {} otherwise.
    """

    start: int
    end: int
    mode: str
    contacts: tuple[str, ...]
    configurations: np.ndarray
    action: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, 'configurations', readonly(self.configurations, (-1, 5)))

    def to_dict(self) -> dict[str, Any]:
        """For documents."""
        return {
            'start': self.start,
            'end': self.end,
            'mode': self.mode,
            'contacts': list(self.contacts),
            'configurations': self.configurations.tolist(),
            'action': self.action,
        }

    @classmethod
    def from_dict(cls, d: dict[str, Any]) -> 'Leg':
        """Raises one of DAMAGES when something is missing or of the wrong kind."""
        return cls(
            d['start'],
            d['end'],
            d['mode'],
            tuple(d['contacts']),
            d['configurations'],
            d['action'],
        )


@dataclass(frozen=True, eq=False)
class ContactPlan:
    """The answer of Phase 1: a route, or the reason why there is none.

    search, seed: how it was searched for; outcome: one of OUTCOMES; reason: in words, what was
    found or why nothing was; counts: figures of the search by name; subgoals: all that were found;
    path: numbers of those on the route, X_init first; legs: along it; cost: of the route, by name;
    execution: options of Phase 2 chosen by verification, {} for the defaults; certificate: how
    surely it succeeds, None when none was asked for; band, courses: of the fingers in the surviving
    samples; strayed: courses of samples that ended elsewhere; then: the turns that are meant to
    follow, each from where the one before ends; overall: the certificate of all of them in a row.
    """

    scenario: Scenario
    search: str
    seed: int
    outcome: str
    reason: str
    counts: dict[str, Any]
    subgoals: tuple[Subgoal, ...] = ()
    path: tuple[int, ...] = ()
    legs: tuple[Leg, ...] = ()
    cost: dict[str, Any] = field(default_factory=dict)
    execution: dict[str, Any] = field(default_factory=dict)
    certificate: Certificate | None = None
    band: Band | None = None
    courses: np.ndarray | None = None
    strayed: np.ndarray | None = None
    then: 'tuple[ContactPlan, ...]' = ()
    overall: Certificate | None = None

    def __post_init__(self) -> None:
        for name in ('courses', 'strayed'):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, readonly(getattr(self, name), (-1, -1, 2)))

    @property
    def found(self) -> bool:
        """Whether there is a route."""
        return self.outcome == FOUND

    @property
    def turn(self) -> 'ContactPlan':
        """The plan without the turns that follow."""
        return replace(self, then=(), overall=None) if self.then else self

    @property
    def unfelt_end(self) -> StartOnEdge | None:
        """Where the turn that follows a slide begins, None for other plans. The end of such a slide
        is not felt: the object lies on the edge on which it lay, between both fingers, and a probe
        may lead it away from there again.
        """
        start, goal = self.scenario.start, self.scenario.goal
        if not self.then or not isinstance(start, StartOnEdge) or not isinstance(goal, GoalOnEdge):
            return None
        follows = self.then[0].scenario.start
        return follows if goal.edge == start.edge and isinstance(follows, StartOnEdge) else None

    @property
    def route_alone(self) -> 'ContactPlan':
        """The plan without the subgoals that the search found aside from its route."""
        before = dict(zip(self.path[1:], self.path))
        on_route = [s for s in self.subgoals if s.number in self.path]
        chained = tuple(replace(s, parent=before.get(s.number)) for s in on_route)
        return replace(self, subgoals=chained)

    @cached_property
    def id(self) -> str:
        """A UUID made of the content: equal plans have equal ids."""
        return str(uuid.uuid5(ID_NAMESPACE, json.dumps(self._content(), sort_keys=True)))

    def object_path(self) -> np.ndarray:
        """(n, 3) object poses along the route, (0, 3) when there is none."""
        if not self.legs:
            return np.empty((0, 3))
        return np.vstack([leg.configurations[:, :3] for leg in self.legs])

    def summary(self) -> str:
        """One line for people."""
        counts = ', '.join(
            f'{value} {name.replace("_", " ")}' for name, value in self.counts.items()
        )
        if not self.found:
            return f'no plan ({self.outcome}): {self.reason} [{counts}]'
        sure = f'; {self.certificate}' if self.certificate else ''
        route = f'{len(self.path)} subgoals on the path, {self.reason}'
        more = f'; {len(self.then)} more to follow, in a row {self.overall}' if self.then else ''
        return f'plan {self.id[:8]}: {route}{sure}{more} [{counts}]'

    def with_execution(self, execution: dict[str, Any]) -> 'ContactPlan':
        """The same route, to be executed with those options."""
        return replace(self, execution=execution)

    def to_json(self) -> str:
        """The document `wholearm-contact-plan/1`; the same plan gives the same bytes."""
        return json.dumps(
            {'format': FORMAT, 'id': self.id, **self._content()},
            separators=(',', ':'),
            allow_nan=False,
        )

    def _content(self) -> dict[str, Any]:
        return {
            'scenario': scenario_to_dict(self.scenario),
            'search': self.search,
            'seed': self.seed,
            'outcome': self.outcome,
            'reason': self.reason,
            'counts': self.counts,
            'path': list(self.path),
            'subgoals': [subgoal.to_dict() for subgoal in self.subgoals],
            'legs': [leg.to_dict() for leg in self.legs],
            'cost': self.cost,
            'execution': self.execution,
            **({'certificate': self.certificate.to_dict()} if self.certificate else {}),
            **({'band': self.band.to_dict()} if self.band else {}),
            **({} if self.courses is None else {'courses': self.courses.tolist()}),
            **({} if self.strayed is None else {'strayed': self.strayed.tolist()}),
            **({'then': [turn._content() for turn in self.then]} if self.then else {}),
            **({'overall': self.overall.to_dict()} if self.overall else {}),
        }

    @classmethod
    def from_json(cls, text: str) -> 'ContactPlan':
        """Raises DocumentError when `text` is damaged, of another format, or its content does not
        match its id.
        """
        try:
            d = json.loads(text)
            if d.get('format') != FORMAT:
                raise DocumentError(
                    f'plan document: format is {d.get("format")!r}; allowed: {FORMAT!r}'
                )
            plan, got = cls._from_content(d), d['id']
        except (*DAMAGES, ScenarioError) as error:
            raise DocumentError(
                f'plan document is damaged: {type(error).__name__}: {error}'
            ) from error
        if plan.id != got:
            raise DocumentError(
                f'plan document: its content has the id {plan.id}, it says {got}; '
                'it was changed after it was written'
            )
        return plan

    @classmethod
    def _from_content(cls, d: dict[str, Any]) -> 'ContactPlan':
        return cls(
            parse_scenario(d['scenario'], 'plan document'),
            d['search'],
            d['seed'],
            d['outcome'],
            d['reason'],
            d['counts'],
            tuple(map(Subgoal.from_dict, d['subgoals'])),
            tuple(d['path']),
            tuple(map(Leg.from_dict, d['legs'])),
            d['cost'],
            d['execution'],
            Certificate(**d['certificate']) if d.get('certificate') else None,
            Band.from_dict(d['band']) if d.get('band') else None,
            d.get('courses'),
            (d['strayed'] or np.empty((0, 0, 2))) if 'strayed' in d else None,
            tuple(map(cls._from_content, d.get('then', ()))),
            Certificate(**d['overall']) if d.get('overall') else None,
        )
