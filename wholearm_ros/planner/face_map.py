"""The face map of an object in a hand: certified ways between its faces, and routes over them.

A way is a turn to the next face, or a slide along the palm; the object is felt between two of them,
so that a route's errors do not add up.
"""

import heapq
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from math import log
from typing import Any, NamedTuple

from wholearm_ros.model.certificate import Certificate
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario import GoalOnEdge, StartOnEdge

FORMAT = 'wholearm-map/1'
PRICE_OF_A_WAY = 0.03  # added to −log of its success rate: of two routes as sure, the shorter one
PRIOR = 12.0  # samples that a certificate counts for beside what happens in a session


class Turn(NamedTuple):
    """From one face to another one, ccw or cw."""

    start: int
    end: int
    direction: str


@dataclass(frozen=True, eq=False)
class Way:
    """A certified turn or slide.

    start: where it begins; reach: how far off the true x may be there [m]; goal: with its
    direction; end: where its surviving rollouts end, the median x; plan: with its certificate;
    succeeded, failed: runs of this session.
    """

    start: StartOnEdge
    reach: float
    goal: GoalOnEdge
    end: StartOnEdge
    plan: ContactPlan
    succeeded: int = 0
    failed: int = 0

    @property
    def certificate(self) -> Certificate:
        """Of the plan; a way has one always."""
        assert self.plan.certificate is not None
        return self.plan.certificate

    @property
    def success_rate(self) -> float:
        """Mean of the posterior: the certificate as PRIOR samples, then what has happened."""
        survived = PRIOR * self.certificate.survived / self.certificate.samples
        tried = PRIOR + self.succeeded + self.failed
        return (survived + self.succeeded + 0.5) / (tried + 1.0)

    @property
    def price(self) -> float:
        """Of a route: the sum of its ways' is −log of its success rate, and what each costs."""
        return PRICE_OF_A_WAY - log(self.success_rate)

    def begins_at(self, place: StartOnEdge) -> bool:
        """Whether it may be executed from there."""
        return place.edge == self.start.edge and abs(place.x - self.start.x) <= self.reach

    def to_dict(self) -> dict[str, Any]:
        """An edge of the map's document."""
        c = self.certificate
        return {
            'from': {'edge': self.start.edge, 'x': self.start.x},
            'to': {'edge': self.end.edge, 'x': self.end.x},
            'direction': self.goal.direction,
            'reach': self.reach,
            'samples': c.samples,
            'survived': c.survived,
            'lower_bound': c.lower_bound,
            'level': c.level,
            'plan': self.plan.id,
        }


@dataclass(frozen=True, eq=False)
class Refused:
    """A way for which there is no plan: from where, to where, and why; moves: simulations at which
    its search was ended, None when it had nothing left to try.
    """

    start: StartOnEdge
    goal: GoalOnEdge
    reason: str
    moves: int | None = None

    def to_dict(self) -> dict[str, Any]:
        """For the map's document."""
        return {
            'from': {'edge': self.start.edge, 'x': self.start.x},
            'to': {'edge': self.goal.edge, 'x': self.goal.x},
            'direction': self.goal.direction,
            'reason': self.reason,
        }


@dataclass(frozen=True, eq=False)
class FaceMap:
    """faces: edges on which the object can rest; ways: certified; refused: tried in vain."""

    faces: tuple[int, ...]
    ways: tuple[Way, ...] = ()
    refused: tuple[Refused, ...] = ()

    def route(self, start: StartOnEdge, goal: GoalOnEdge) -> tuple[Way, ...]:
        """The surest way after way from `start` to the goal's edge, whatever the x there; () when
        there is none, or none is needed.
        """
        return self.routes(start).get(goal.edge, ())

    def routes(self, start: StartOnEdge) -> dict[int, tuple[Way, ...]]:
        """By edge, the surest route from `start` to every face that can be reached, () to the face
        on which it is (Dijkstra).
        """
        open_: list[tuple[float, int, StartOnEdge, tuple[Way, ...]]] = [(0.0, 0, start, ())]
        found: dict[int, tuple[Way, ...]] = {}
        closed: set[Way] = set()
        pushed = 0
        while open_:
            price, _, place, route = heapq.heappop(open_)
            found.setdefault(place.edge, route)
            if route and route[-1] in closed:
                continue
            closed.update(route[-1:])
            for way in self.ways:
                if way.begins_at(place) and way not in closed:
                    pushed += 1
                    entry = (price + way.price, pushed, way.end, (*route, way))
                    heapq.heappush(open_, entry)
        return found

    def best_turns(self) -> dict[Turn, Way]:
        """The surest way of every turn, of all places at which it begins."""
        best: dict[Turn, Way] = {}
        for way in self.ways:
            if way.goal.direction is None:
                continue
            turn = Turn(way.start.edge, way.goal.edge, way.goal.direction)
            if turn not in best or way.success_rate > best[turn].success_rate:
                best[turn] = way
        return best

    def success_rate(self, route: Iterable[Way]) -> float:
        """Of all ways of a route in a row."""
        rate = 1.0
        for way in route:
            rate *= way.success_rate
        return rate

    def after(self, runs: Mapping[str, tuple[int, int]]) -> 'FaceMap':
        """The map after runs of a session: (succeeded, failed) by the plan's id."""
        told = [(way, runs.get(way.plan.id, (0, 0))) for way in self.ways]
        ways = tuple(replace(way, succeeded=s, failed=f) if s + f else way for way, (s, f) in told)
        return replace(self, ways=ways)

    def to_dict(self, name: str) -> dict[str, Any]:
        """The document `wholearm-map/1`; name: of the scenario."""
        return {
            'format': FORMAT,
            'scenario': name,
            'faces': [
                {'edge': face, 'x': sorted({w.start.x for w in self.ways if w.start.edge == face})}
                for face in self.faces
            ],
            'edges': [way.to_dict() for way in self.ways],
            'refused': [refused.to_dict() for refused in self.refused],
            'pairs': [
                {
                    'from': {'edge': start.edge, 'x': start.x},
                    'to': {'edge': face},
                    'ways': len(route),
                    'success_rate': self.success_rate(route),
                }
                for start, face, route in self.all_pairs()
            ],
        }

    def all_pairs(self) -> 'list[tuple[StartOnEdge, int, tuple[Way, ...]]]':
        """(start, other face, route): every start of a way, every other face that is reached."""
        starts = sorted({w.start for w in self.ways}, key=lambda s: (s.edge, s.x))
        return [
            (start, face, routes[face])
            for start in starts
            for routes in [self.routes(start)]
            for face in self.faces
            if face != start.edge and face in routes
        ]
