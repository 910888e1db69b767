"""A contact plan: the subgoals that were found, and the legs that lead from the start to the goal."""

import json
import uuid
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from wholearm_ros.errors import DocumentError, ScenarioError
from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.certificate import Certificate
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.scenario_file import parse_scenario, scenario_to_dict

FORMAT = 'wholearm-contact-plan/1'
X_INIT, X_START, X_THROUGH, X_END, X_GOAL, Y = (
    'X_init',
    'X_start',
    'X_through',
    'X_end',
    'X_goal',
    'Y',
)
FOUND, EXHAUSTED, LIMIT_REACHED, TIME_SPENT, NOT_EXECUTABLE = (
    'found',
    'exhausted',
    'limit_reached',
    'time_spent',
    'not_executable',
)
OUTCOMES = (FOUND, EXHAUSTED, LIMIT_REACHED, TIME_SPENT, NOT_EXECUTABLE)
ID_NAMESPACE = uuid.UUID('6f1d2a4e-52a1-5c0e-9a53-0b6f2f6c9d10')


@dataclass(frozen=True, eq=False)
class Subgoal:
    """One X or Y of the subgoal network (III-A.2).

    configuration: (5,) x, y, φ, θ_L, θ_R [m, rad]; contacts: names of the closed pairs;
    direction: sign of the velocity finger's motion towards it, 0 where none; parent: number of the subgoal before, or None.
    """

    number: int
    kind: str
    configuration: np.ndarray
    contacts: tuple
    direction: int = 0
    parent: int = None

    def __post_init__(self):
        object.__setattr__(self, 'configuration', readonly(self.configuration, (5,)))


@dataclass(frozen=True, eq=False)
class Leg:
    """The way from one subgoal to the next with the same closed pairs.

    mode: of Phase 1, quasi_static, dynamic or caging; configurations: (m, 5) along the way;
    action: what a dynamic leg does, {} otherwise.
    """

    start: int
    end: int
    mode: str
    contacts: tuple
    configurations: np.ndarray
    action: dict = field(default_factory=dict)

    def __post_init__(self):
        object.__setattr__(self, 'configurations', readonly(self.configurations, (-1, 5)))


@dataclass(frozen=True, eq=False)
class ContactPlan:
    """What Phase 1 answers. `outcome` says whether there is a route; `reason` says why not, or what was found.

    counts: numbers of the search (iterations, arcs, subgoals X and Y); cost: of the route, by name;
    execution: how Phase 2 shall execute it (the choices that verification liked best), {} for the defaults;
    certificate: how surely it succeeds, None when nobody asked.
    """

    scenario: Scenario
    search: str
    seed: int
    outcome: str
    reason: str
    counts: dict
    subgoals: tuple = ()
    path: tuple = ()
    legs: tuple = ()
    cost: dict = field(default_factory=dict)
    execution: dict = field(default_factory=dict)
    certificate: Certificate | None = None

    @property
    def found(self) -> bool:
        return self.outcome == FOUND

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
        return f'plan {self.id[:8]}: {len(self.path)} subgoals on the path, {self.reason}{sure} [{counts}]'

    def with_execution(self, execution: dict) -> 'ContactPlan':
        return replace(self, execution=execution)

    def to_json(self) -> str:
        """The document `wholearm-contact-plan/1`; the same plan gives the same bytes."""
        return json.dumps(
            {'format': FORMAT, 'id': self.id, **self._content()},
            separators=(',', ':'),
            allow_nan=False,
        )

    def _content(self) -> dict:
        return {
            'scenario': scenario_to_dict(self.scenario),
            'search': self.search,
            'seed': self.seed,
            'outcome': self.outcome,
            'reason': self.reason,
            'counts': self.counts,
            'path': list(self.path),
            'subgoals': [
                {
                    'number': s.number,
                    'kind': s.kind,
                    'configuration': s.configuration.tolist(),
                    'contacts': list(s.contacts),
                    'direction': s.direction,
                    'parent': s.parent,
                }
                for s in self.subgoals
            ],
            'legs': [
                {
                    'start': leg.start,
                    'end': leg.end,
                    'mode': leg.mode,
                    'contacts': list(leg.contacts),
                    'configurations': leg.configurations.tolist(),
                    'action': leg.action,
                }
                for leg in self.legs
            ],
            'cost': self.cost,
            'execution': self.execution,
            **({'certificate': self.certificate.to_dict()} if self.certificate else {}),
        }

    @classmethod
    def from_json(cls, text: str) -> 'ContactPlan':
        """Raises DocumentError when `text` is damaged, of another format, or its content does not match its id."""
        try:
            d = json.loads(text)
            if d.get('format') != FORMAT:
                raise DocumentError(
                    f'plan document: format is {d.get("format")!r}; allowed: {FORMAT!r}'
                )
            plan = cls(
                parse_scenario(d['scenario'], 'plan document'),
                d['search'],
                d['seed'],
                d['outcome'],
                d['reason'],
                d['counts'],
                tuple(
                    Subgoal(
                        s['number'],
                        s['kind'],
                        s['configuration'],
                        tuple(s['contacts']),
                        s['direction'],
                        s['parent'],
                    )
                    for s in d['subgoals']
                ),
                tuple(d['path']),
                tuple(
                    Leg(
                        leg['start'],
                        leg['end'],
                        leg['mode'],
                        tuple(leg['contacts']),
                        leg['configurations'],
                        leg['action'],
                    )
                    for leg in d['legs']
                ),
                d['cost'],
                d['execution'],
                Certificate(**d['certificate']) if d.get('certificate') else None,
            )
            got = d['id']
        except DocumentError:
            raise
        except (
            ValueError,
            OverflowError,
            TypeError,
            KeyError,
            AttributeError,
            RecursionError,
            ScenarioError,
        ) as error:
            raise DocumentError(
                f'plan document is damaged: {type(error).__name__}: {error}'
            ) from error
        if plan.id != got:
            raise DocumentError(
                f'plan document: its content has the id {plan.id}, it says {got}; it was changed on its way'
            )
        return plan
