"""Planning of probes: places at which what may lie in the hand is told apart, squeezed so gently
that nothing tips.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np

from wholearm_ros.estimation.feel import (
    FEWEST,
    Feeler,
    derivatives_by_zeros,
    gave_way,
    pairs_covariance,
)
from wholearm_ros.estimation.hypotheses import alike
from wholearm_ros.estimation.squeeze import Resting, SqueezeModel
from wholearm_ros.estimation.tipping import DOUBT, LESS_DOUBT, NO_DOUBT, Doubt, tipping_torque
from wholearm_ros.model.hand import CLOSING
from wholearm_ros.model.probe import Probe
from wholearm_ros.model.scenario import GoalOnEdge
from wholearm_ros.model.trajectory import ManipulationTrajectory

PLACES = 7
# [rad] that the held finger closes beyond where it was, below zero: opens before it closes to where
# it was; the first one that separates the hypotheses enough is used.
AWAY: tuple[float, ...] = (-0.5, -0.7, -0.9, -1.1)
ON: tuple[float, ...] = (0.08, 0.14, 0.2, 0.3, 0.4)
WIDE = 0.08  # [rad] between the first and the last place that is enough
SEPARATED = 60.0  # χ² between what is expected and the next best that is enough
ENOUGH = (True, SEPARATED)
GRID = 0.05  # [rad] between the angles that are looked at
SAFETY = 1.25  # torque that would tip the object over the torque that is used, at least
MOTOR = 0.0075  # [N m] by which it exceeds that at least: motors misjudge the finger's weight
OPENED = 0.12  # [rad] that both fingers open before they close
REACH = 0.35  # [rad] from its closed limit at which the closing finger must have met the object
STOP_MARGIN = 0.01  # [rad] inside of the closed limit at which a finger is stopped
# [rad] from an edge's rotation within which a planned last pose lies on that edge.
LYING_ANGLE = 0.15


class Caution(NamedTuple):
    """acceleration [rad/s²] of the held finger at most: what it pushes must not run ahead of it;
    swing [N m]: what the closing finger's inertia and damping then add to its torque for each
    radian that it must turn while the held one turns by one; weakest, strongest [N m]: torque of
    the closing finger; doubt: with which what is expected must not tip; others: whether what lies
    otherwise must not, either.
    """

    acceleration: float
    swing: float
    weakest: float
    strongest: float
    doubt: Doubt
    others: bool

    @property
    def enough(self) -> float:
        """[N m] Tipping torque from which a place is safe."""
        return max(SAFETY * self.weakest, self.weakest + MOTOR)

    def torque(self, tipping: float) -> float:
        """[N m] of the closing finger where `tipping` [N m] would tip the object."""
        return float(np.clip(tipping / SAFETY, self.weakest, self.strongest))


CAUTIONS = (
    Caution(3.0, 0.04, 0.03, 0.08, DOUBT, True),
    Caution(1.0, 0.0133, 0.03, 0.08, DOUBT, True),
    Caution(1.0, 0.0133, 0.03, 0.08, DOUBT, False),
    Caution(0.3, 0.0065, 0.02, 0.02, DOUBT, False),
    Caution(0.1, 0.004, 0.02, 0.02, LESS_DOUBT, False),
)


def plan_probe(
    model: SqueezeModel,
    hypotheses: tuple[Resting, ...],
    expected: int,
    held: int,
    ends: np.ndarray,
    shifts: bool = True,
    again: bool = False,
) -> Probe:
    """The probe for what may lie in the hand.

    expected: the place in `hypotheses` of the one believed in, −1 for none; held: the finger that
    is led, unless only the other one can be without tipping what is expected; ends (2,) [rad]:
    where the fingers stand before; shifts: whether the object may end elsewhere on its edge; again:
    whether another probe has just left it open.

    The held finger leads the object away and back to where it lay. Where that might tip what is
    expected, both fingers stay on it and the held one leads it on. Where that might, too, the held
    finger moves more gently, then without regard to what is not expected, then with the least
    torque, and with that for smaller errors only; at last the only place is where it lies. Friction
    may keep the object from being led away, but not on: the second time that is what is done
    wherever it can be.
    """
    world = model.world
    margins = np.array([STOP_MARGIN, -STOP_MARGIN])
    stops = world.limits[[0, 1], [0, 1]] + margins
    ends = np.clip(ends, *(world.limits + margins).T)
    sides = (held, 1 - held) if shifts else (held,)
    away = [Row(model, hypotheses, expected, side, ends[side], AWAY) for side in sides]
    on = [Row(model, hypotheses, expected, side, ends[side], ON) for side in sides if shifts]
    best, row, gentle = Squeezing(ends[[held]], CAUTIONS[0].weakest, 0.0), None, CAUTIONS[0]
    for rows in (on, away) if again else (away + on,):
        if best.is_wide or best.separation >= SEPARATED:
            break
        for caution, other in product(CAUTIONS, rows):
            found = other.squeezing(caution)
            if found.worth > best.worth:
                best, row, gentle = found, other, caution
            if best.worth == ENOUGH:
                break
    opened = OPENED if row is not None and row.opens else 0.0
    side = held if row is None else row.held
    weights = world.finger_weights
    return Probe(
        side, best.places, np.full(2, opened), best.torque, weights, stops, gentle.acceleration
    )


class Squeezing(NamedTuple):
    """places (k,) [rad] of the held finger; torque [N m] of the other one; separation: see
    `_separation`.
    """

    places: np.ndarray
    torque: float
    separation: float

    @property
    def is_wide(self) -> bool:
        """Whether the places are wide apart."""
        return bool(np.ptp(self.places) > WIDE)

    @property
    def worth(self) -> tuple[bool, float]:
        """Whether the places are wide apart; the separation, as far as it counts."""
        return self.is_wide, min(self.separation, SEPARATED)


@dataclass(frozen=True, eq=False)
class Row:
    """Angles of the held finger from `end` [rad] on, over stretches of which probes may be made.

    expected: the place in `hypotheses` of what is believed in, −1 for none; stretches [rad]: that
    the held finger closes, or opens where they are below zero.
    """

    model: SqueezeModel
    hypotheses: tuple[Resting, ...]
    expected: int
    held: int
    end: float
    stretches: tuple[float, ...]

    @property
    def opens(self) -> bool:
        """Whether both fingers open first."""
        return self.stretches[0] < 0.0

    def squeezing(self, caution: Caution) -> Squeezing:
        """At places where nothing tips: over the first of the stretches that separates enough, else
        the one that separates most. Only at `end` without two such places.
        """
        best = Squeezing(np.array([self.end]), caution.weakest, 0.0)
        if len(self.thetas) < 2:
            return best
        tipping = self._tipping_with(caution)
        safe = np.flatnonzero(self._safe(tipping, caution))
        for stretch in self.stretches:
            used = safe[np.abs(self.offsets[safe]) < abs(stretch) + GRID / 2]
            if len(used) < 2:
                break
            first, last = (
                CLOSING[self.held] * np.sort(CLOSING[self.held] * self.thetas[used])[[0, -1]]
            )
            places = np.linspace(first, last, PLACES)
            separation = _separation(self.model, self.hypotheses, self.expected, self.held, places)
            if separation > best.separation:
                torque = caution.torque(float(np.nanmin(tipping[:, used])))
                best = Squeezing(places, torque, separation)
            if best.separation >= SEPARATED:
                break
        return best

    @cached_property
    def offsets(self) -> np.ndarray:
        """(k,) [rad] from `end`, within the finger's limits."""
        low, high = self.model.world.limits[self.held] + [STOP_MARGIN / 2, -STOP_MARGIN / 2]
        steps = np.arange(0.0, abs(self.stretches[-1]) + GRID / 2, GRID)
        offsets = steps * np.sign(self.stretches[0])
        thetas = self.end + CLOSING[self.held] * offsets
        return np.asarray(offsets[(thetas > low) & (thetas < high)])

    @cached_property
    def thetas(self) -> np.ndarray:
        """(k,) [rad] of the held finger."""
        return np.asarray(self.end + CLOSING[self.held] * self.offsets)

    @cached_property
    def angles(self) -> np.ndarray:
        """(h, k) [rad] of the closing finger for each hypothesis, NaN where it is not met."""
        return np.array(
            [self.model.squeeze(one, self.held, self.thetas)[1] for one in self.hypotheses]
        )

    @cached_property
    def surely_met(self) -> np.ndarray:
        """(h, k) bool: where the closing finger cannot pass over the object."""
        shut = self.model.world.limits[1 - self.held, 0 if self.held else 1]
        shorter = self.model.shortened
        by_shorter = [shorter.squeeze(one, self.held, self.thetas)[1] for one in self.hypotheses]
        return np.asarray(np.isfinite(by_shorter) & (np.abs(self.angles - shut) >= REACH))

    @cached_property
    def tipping(self) -> np.ndarray:
        """(h, k) [N m] of the closing finger, NaN where an object is not met; without doubt."""
        told = [self._tipping(h, NO_DOUBT) for h in range(len(self.hypotheses))]
        return np.array(told)

    @cached_property
    def doubtful(self) -> dict[Doubt, np.ndarray]:
        """(k,) [N m] likewise of what is expected, with each doubt that a caution has."""
        return {d: self._tipping(self.expected, d) for d in {c.doubt for c in CAUTIONS}}

    def _tipping(self, h: int, doubt: Doubt) -> np.ndarray:
        """(k,) [N m] of the closing finger, of one hypothesis."""
        model, resting, found = self.model, self.hypotheses[h], np.full(len(self.thetas), np.nan)
        for k in np.flatnonzero(np.isfinite(self.angles[h])):
            theta = self.thetas[k]
            q = np.array([*resting.pose_at(model.slide(resting, self.held, theta)), 0.0, 0.0])
            q[3 + self.held], q[4 - self.held] = theta, self.angles[h, k]
            found[k] = tipping_torque(model.world, resting, self.held, q, doubt, self.opens)
        return found

    def _tipping_with(self, caution: Caution) -> np.ndarray:
        """(h, k) [N m] of what counts, NaN elsewhere, less what the motion adds."""
        polygon, tipping = self.model.scenario.object.polygon, self.tipping.copy()
        for k, one in enumerate(self.hypotheses):
            if not (caution.others and polygon.can_rest_on(one.edge)):
                tipping[k] = np.nan
        if self.expected >= 0:
            turning = np.abs(np.gradient(self.angles[self.expected], GRID))
            tipping[self.expected] = self.doubtful[caution.doubt] - caution.swing * turning
        return tipping

    def _safe(self, tipping: np.ndarray, caution: Caution) -> np.ndarray:
        """(k,) bool: the first stretch of places in which the expected object, and others that are
        met, do not tip; on the way there the expected one does not, either, and fingers that have
        opened meet it.
        """
        missed = ~self.surely_met & ~np.isnan(tipping)
        others, firm = tipping, np.ones(tipping.shape[1], bool)
        good = ~np.isnan(tipping).all(axis=0)
        if self.expected >= 0:
            firm = good = tipping[self.expected] > caution.enough
            firm = firm & ~missed[self.expected] if self.opens else firm
            others = np.delete(tipping, self.expected, axis=0)
        good = good & ~missed.any(axis=0) & ~(others < caution.weakest).any(axis=0)
        keep = np.zeros(tipping.shape[1], bool)
        for k in range(len(keep)):
            if not firm[k] or (keep.any() and not good[k]):
                break
            keep[k] = good[k]
        return keep


def _separation(
    model: SqueezeModel,
    hypotheses: tuple[Resting, ...],
    expected: int,
    held: int,
    places: np.ndarray,
) -> float:
    """χ² by which squeezes at `places` (k,) [rad] of the object as expected miss those of the next
    best hypothesis that does not feel the same; without an expected one, the least over all of
    them.
    """
    classes = alike(model, hypotheses)
    told = {m: model.predict(hypotheses[m[0]], held, places) for m in classes}
    least = np.inf
    for members in classes:
        true = told[members].angles
        if (expected >= 0 and expected not in members) or not np.isfinite(true).all():
            continue
        touched = gave_way(1 - held, true)
        if touched.sum() < FEWEST:
            return 0.0
        for others in classes:
            one = told[others]
            rows = touched & np.isfinite(one.angles) & np.isfinite(one.by_vertices).all(axis=1)
            if others == members and not rows[touched].all():
                return 0.0
            if others == members or not rows.any():
                continue
            by_held, innovation = one.by_held[rows], (true - one.angles)[rows]
            covariance = pairs_covariance(
                one.by_vertices[rows], derivatives_by_zeros(held, by_held), by_held
            )
            least = min(least, float(innovation @ np.linalg.solve(covariance, innovation)))
    return least


def probe_after(feeler: Feeler, trajectory: ManipulationTrajectory, again: bool = False) -> Probe:
    """The probe after a trajectory: what is expected is the edge on which its last pose lies, if it
    lies on one; again: see `plan_probe`, and from the other side than `trajectory` holds.
    """
    finger = trajectory.segments[-1].velocity_finger
    held = 1 - finger if again else finger
    expected = nearest_resting(feeler.hypotheses, trajectory.poses[-1])
    goal = feeler.model.scenario.goal
    shifts = isinstance(goal, GoalOnEdge) and goal.x is None
    ends = trajectory.angles[-1]
    return plan_probe(feeler.model, feeler.hypotheses, expected, held, ends, shifts, again)


def probe_of_the_unknown(feeler: Feeler, held: int, angles: np.ndarray) -> Probe:
    """The probe of whatever lies in the hand; angles (2,) [rad]: where the fingers stand."""
    return plan_probe(feeler.model, feeler.hypotheses, -1, held, angles)


def nearest_resting(hypotheses: tuple[Resting, ...], pose: np.ndarray) -> int:
    """The place in `hypotheses` of the one in which an object at `pose` (3,) lies, −1 when it lies
    in none.
    """
    off = [
        abs((float(pose[2] - h.pose[2]) + np.pi) % (2.0 * np.pi) - np.pi)
        + (abs(pose[0] - h.pose[0]) > h.reach)
        for h in hypotheses
    ]
    best = int(np.argmin(off))
    return best if off[best] < LYING_ANGLE else -1
