"""Motion primitives as ways out of a state: the dynamic manipulation of III-B.2 as a step of the
search.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wholearm_ros.model.configuration import POSE, ROTATION
from wholearm_ros.model.modes import DYNAMIC
from wholearm_ros.model.motion_primitive import MotionPrimitive
from wholearm_ros.model.plan import Leg
from wholearm_ros.rollout.parallel import parallel_map
from wholearm_ros.rollout.primitive_rollout import PERIOD, PrimitiveRecord, Rest, simulate_primitive
from wholearm_ros.rollout.verification import MOST_BEYOND
from wholearm_ros.search.primitive_candidates import (
    GENTLE,
    LONG_SETTLE,
    STYLES,
    THROWS,
    Flings,
    Style,
    flings,
    flings_beside,
    stops_along,
    sweeps,
)
from wholearm_ros.search.state_tree import StateTree
from wholearm_ros.search.ways import way_of_primitive

# Prices, against a radian of the rotation that is left
PRIMITIVE_PRICE = 0.06
STYLE_PRICE = 0.3  # of every further style of sweeps
FLING_PRICE = 0.25  # of looking for one, which may do all that is left
DOUBT_PRICE = 0.1  # of a fling beside which no other one succeeds
SIBLING_PRICE = 0.1  # of every other stop along the same sweep that came to nothing
FLING_ROUNDS = 3  # of flings beside those that came nearest to the top so far,
FLING_SEEDS = 3  # which are so many,
FLING_NEAR = 0.2  # [rad] if they came that near
REACHED = -np.inf


@dataclass
class Sweep:
    """failures: how many of the stops along it came to nothing."""

    failures: int = 0


@dataclass(frozen=True, eq=False)
class PrimitiveWays:
    """To stops along sweeps, which are simulated when it is their turn, and flings."""

    tree: StateTree

    def open(self, k: int) -> None:
        """Queue those that leave state k."""
        for number, style in enumerate(STYLES):
            later = PRIMITIVE_PRICE + number * STYLE_PRICE
            price = self.tree.price_at(k, self.tree.states[k].rest.q) + later
            self.tree.push(k, price, partial(self._try, k, style, later))
        price = self.tree.states[k].paid + FLING_PRICE
        for kind in (GENTLE, THROWS):
            self.tree.push(k, price, partial(self._fling, k, kind))

    def _try(self, k: int, style: Style, later: float) -> None:
        """See where primitives from state k lead."""
        rest, problem = self.tree.states[k].rest, self.tree.problem
        tried = sweeps(problem, rest.q, style)
        for move, record in zip(tried, self._simulate(rest, tried)):
            sweep = Sweep()
            for stop, q in stops_along(problem, rest, move, record):
                self._push(k, stop, q, later, sweep)

    def _fling(self, k: int, kind: Flings) -> None:
        """Flings from state k that carry the object over the top, the surest first: those beside
        which most others do.
        """
        rest, sweep = self.tree.states[k].rest, Sweep()
        missing: dict[MotionPrimitive, float] = {}  # of those tried
        over: dict[MotionPrimitive, np.ndarray] = {}  # where they end
        fresh = flings(self.tree.problem, rest.q, kind)
        for _ in range(FLING_ROUNDS):
            for fling, record in zip(fresh, self._simulate(rest, fresh)):
                missing[fling] = self._missing(record)
                if missing[fling] == REACHED:
                    over[fling] = record.configurations[-1]
            near = sorted(missing, key=lambda fling: missing[fling])[:FLING_SEEDS]
            fresh = [
                beside
                for fling in near
                if missing[fling] < FLING_NEAR
                for beside in flings_beside(fling)
                if beside not in missing
            ]
        for fling, q in over.items():
            beside = flings_beside(fling)
            doubt = 1.0 - sum(other in over for other in beside) / len(beside)
            self._push(k, fling, q, FLING_PRICE + DOUBT_PRICE * doubt, sweep)

    def _missing(self, record: PrimitiveRecord) -> float:
        """What a fling lacks: the rotation from its peak to the top of the last cage [rad]; past
        the top REACHED if the object comes to rest there, else minus the seconds that went well.
        """
        problem = self.tree.problem
        if self._ends_well(record) and problem.rotation_left(record.configurations[-1]) < 0.0:
            return REACHED
        peak = record.configurations[np.argmax(record.configurations[:, ROTATION])]
        left = problem.rotation_left(peak)
        return left if left > 0.0 else -PERIOD * len(record.wanted)

    def _push(
        self, k: int, move: MotionPrimitive, q: np.ndarray, later: float, sweep: Sweep
    ) -> None:
        """Queue a primitive that leaves state k towards q (5,)."""
        if self.tree.known(self.tree.cell(q), self.tree.states[k].belief.loss):
            return
        price = self.tree.price_at(k, q) + later + SIBLING_PRICE * sweep.failures
        work = partial(self._by, k, move, q, later, sweep, sweep.failures)
        self.tree.push(k, price, work)

    def _by(
        self,
        k: int,
        move: MotionPrimitive,
        q: np.ndarray,
        later: float,
        sweep: Sweep,
        failures: int,
    ) -> int | None:
        """By a primitive; later, when others along its sweep came to nothing meanwhile."""
        if sweep.failures > failures:
            self._push(k, move, q, later, sweep)
            return None
        if self.tree.known(self.tree.cell(q), self.tree.states[k].belief.loss):
            return None
        found = self._executed(k, move)
        sweep.failures += found is None
        return found

    def _executed(self, k: int, move: MotionPrimitive) -> int | None:
        state, problem = self.tree.states[k], self.tree.problem
        record = self._brought_to_rest(state.rest, move)
        end = record.configurations[-1]
        if not self._ends_well(record):
            return None
        leg = Leg(
            0, 0, DYNAMIC, self.tree.names(end), record.path(state.rest), record.move.to_dict()
        )
        way, goal = way_of_primitive(state.rest, record, leg), problem.reached(end[POSE])
        after = state.then(k, way, PRIMITIVE_PRICE, goal=goal)
        return self.tree.execute(after, ('goal', k) if goal else self.tree.cell(end))

    def _ends_well(self, record: PrimitiveRecord) -> bool:
        """Whether a primitive ends at rest where something may go on, and never turned the object
        too far on the way.
        """
        problem, most = self.tree.problem, record.configurations[:, ROTATION].max()
        return bool(
            record.at_rest
            and not record.stops_met.any()
            and not problem.hopeless(record.configurations[-1])
            and most <= problem.goal.rotation + MOST_BEYOND
        )

    def _brought_to_rest(self, rest: Rest, move: MotionPrimitive) -> PrimitiveRecord:
        """The primitive simulated, with a longer pause after it where it does not end at rest."""
        (record,) = self._simulate(rest, [move])
        if record.at_rest or record.stops_met.any() or move.settle >= LONG_SETTLE:
            return record
        if self.tree.problem.hopeless(record.configurations[-1]):
            return record
        (record,) = self._simulate(rest, [replace(move, settle=LONG_SETTLE)])
        return record

    def _simulate(self, rest: Rest, moves: Sequence[MotionPrimitive]) -> list[PrimitiveRecord]:
        """The records of primitives from rest."""
        self.tree.primitives += len(moves)
        return list(parallel_map(partial(simulate_primitive, self.tree.problem.world, rest), moves))
