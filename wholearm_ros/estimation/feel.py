"""Feeling: from pairs of finger angles to where the object lies, how surely, and what else it might
be.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import reduce
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from wholearm_ros.estimation.hypotheses import alike, resting_hypotheses
from wholearm_ros.estimation.squeeze import Resting, SqueezeModel
from wholearm_ros.model.hand import CLOSING
from wholearm_ros.model.outcomes import LYING, NOTHING, UNKNOWN
from wholearm_ros.model.probe import Probe
from wholearm_ros.model.scenario import Scenario

VERTEX_DEVIATION = 0.0006  # [m] each coordinate of a vertex, standard: ±1 mm evenly spread
OFFSET_DEVIATION = 0.001  # [rad] of an encoder's zero
READING_DEVIATION = 0.0005  # [rad] of a pair's angles, noise and rest together
SURE = 0.99  # probability from which a hypothesis is told
MISFIT = 6.0  # χ² for each pair above which not even the best hypothesis fits
# Probability that the object lies off the held finger at a place, where friction kept it.
APART = 0.1
FURTHEST_APART = 0.2  # [rad] by which the closing finger is then more open at most
# [rad] by which the closing finger must have given way for the held one to be touching, too.
PUSHED = 0.002
CONTENDERS = 60.0  # log likelihood below the best from which a hypothesis is out of the question
REFINEMENTS, SAME_OUTLINE = 3, 2e-5  # at most, and [m] between two outlines that end them
FEWEST = 3  # such pairs from which something can be told
MOST_APART = 4  # places at which the object may have lain off the held finger
AT_STOP = 0.03  # [rad] from its stop: the closing finger met nothing
SAME_PLACE = 0.003  # [m] both fingers say the same x

Pair = tuple[float, float]  # angles [rad], left then right


class Squeezes(NamedTuple):
    """What a probe measured where both fingers touched: held, LEFT or RIGHT; pairs (k, 2) [rad]."""

    held: int
    pairs: np.ndarray

    @property
    def closing(self) -> int:
        """LEFT or RIGHT: the other finger."""
        return 1 - self.held


class Fit(NamedTuple):
    """How well an object that lies in one way explains k pairs: log likelihood; misfit: χ² for each
    pair; residual: rms [rad] of the closing finger's angles.
    """

    likelihood: float
    misfit: float
    residual: float


NO_FIT = Fit(-1e9, np.inf, np.inf)


@dataclass(frozen=True)
class Candidate:
    """edges: alike to the fingers; segment of the palm; x [m] of the centroid and its standard
    deviation; residual [rad]: rms of the closing finger's angles; misfit: χ² for each pair;
    probability: among the candidates.
    """

    edges: tuple[int, ...]
    segment: int
    x: float
    x_deviation: float
    residual: float
    misfit: float
    probability: float

    def to_dict(self) -> dict[str, Any]:
        """For documents; what is not finite is None."""
        numbers = ('x', 'x_deviation', 'residual', 'misfit', 'probability')
        told = {n: getattr(self, n) if np.isfinite(getattr(self, n)) else None for n in numbers}
        return {'edges': list(self.edges), 'segment': self.segment, **told}


@dataclass(frozen=True)
class Felt:
    """kind: 'lying' on the first candidate's edge (surely), 'nothing' in the hand, or 'unknown';
    candidates, the most probable first; reason: why unknown; pairs: what the fingers measured, and
    squeezes: those of them that tell something.
    """

    kind: str
    candidates: tuple[Candidate, ...] = ()
    reason: str = ''
    pairs: tuple[Pair, ...] = field(default=(), repr=False)
    squeezes: Squeezes | None = field(default=None, repr=False, compare=False)

    @property
    def best(self) -> Candidate:
        """The most probable candidate."""
        return self.candidates[0]

    def describe(self) -> str:
        """One line for people."""
        if self.kind == NOTHING:
            return 'nothing in the hand'
        if self.kind == UNKNOWN:
            return f'not known: {self.reason}'
        best = self.best
        others = f', or, alike, {_list(best.edges[1:])}' if len(best.edges) > 1 else ''
        return f'on edge {best.edges[0]}{others}, x = {best.x:+.4f} m'

    def to_dict(self) -> dict[str, Any]:
        """For documents."""
        return {
            'kind': self.kind,
            'reason': self.reason,
            'candidates': [c.to_dict() for c in self.candidates],
            'pairs': [[float(a) for a in pair] for pair in self.pairs],
        }


class Feeler:
    """What a scenario's object feels like; built once, asked after every probe."""

    def __init__(self, scenario: Scenario) -> None:
        self.model = SqueezeModel(scenario)
        self.hypotheses = resting_hypotheses(self.model)
        self.classes = alike(self.model, self.hypotheses)

    @property
    def symmetric(self) -> bool:
        """Whether some edges of the object feel alike."""
        return any(len(members) > 1 for members in self.classes)

    def feel(
        self,
        probe: Probe,
        pairs: np.ndarray,
        interrupted: str = '',
        before: Felt | None = None,
    ) -> Felt:
        """What the pairs (k, 2) [rad], left then right, of a probe of k places say.

        interrupted: why the probe ended early, if it did; before: of another probe of the object
        since it came to lie there; where neither says enough, both together may.
        """
        pairs = np.asarray(pairs, float).reshape(-1, 2)
        told = tuple((left, right) for left, right in pairs.tolist())
        if interrupted or len(pairs) != len(probe.places):
            return Felt(UNKNOWN, reason=interrupted or 'the probe was interrupted', pairs=told)
        closing = pairs[:, probe.closing]
        if abs(closing[-1] - probe.stops[probe.closing]) < AT_STOP:
            return Felt(NOTHING, pairs=told)
        both = gave_way(probe.closing, closing)
        both[-1] = True
        squeezes = Squeezes(probe.held, pairs[both])
        felt = self._felt((squeezes,))
        if len(pairs) < FEWEST and felt.kind == UNKNOWN:
            felt = replace(felt, reason=f'{felt.reason}; at others it might tip')
        if felt.kind == UNKNOWN and before is not None and before.kind == UNKNOWN:
            known = before.squeezes and self._felt((before.squeezes, squeezes))
            felt = known if known and known.kind == LYING else felt
        return replace(felt, pairs=told, squeezes=squeezes)

    def _felt(self, measured: tuple[Squeezes, ...]) -> Felt:
        count = sum(len(squeezes.pairs) for squeezes in measured)
        if count < FEWEST:
            reason = f'the fingers squeezed something at {count} places; needed: {FEWEST}'
            return Felt(UNKNOWN, reason=reason)
        return _verdict(self._candidates(measured))

    def _candidates(self, measured: tuple[Squeezes, ...]) -> tuple[Candidate, ...]:
        """One a class of edges that feel alike, the most probable first."""
        found = [
            (first_explanation(self.model, self.hypotheses[members[0]], measured), members)
            for members in self.classes
        ]
        best = max(one.fit.likelihood for one, _ in found)
        found = [
            (refined(self.model, one, measured), members)
            if best - one.fit.likelihood < CONTENDERS
            else (one, members)
            for one, members in found
        ]
        found.sort(key=lambda pair: -pair[0].fit.likelihood)
        weights = np.exp([one.fit.likelihood - found[0][0].fit.likelihood for one, _ in found])
        weights /= weights.sum()
        return tuple(
            self._candidate(one.fit, members, float(weight), _x(one, measured[-1]))
            for weight, (one, members) in zip(weights, found)
        )

    def _candidate(
        self, fit: Fit, members: tuple[int, ...], probability: float, x: tuple[float, float]
    ) -> Candidate:
        edges = tuple(self.hypotheses[k].edge for k in members)
        segment = self.hypotheses[members[0]].segment
        return Candidate(edges, segment, *x, fit.residual, fit.misfit, probability)


def gave_way(closing: int, angles: np.ndarray) -> np.ndarray:
    """(k,) bool: places at which the closing finger, at angles (k,) [rad] one after the other, has
    given way to the held one's moves: there both fingers touch.

    Where it did not, friction may hold the object away from the held finger.
    """
    opening = -CLOSING[closing] * angles
    return np.asarray(opening - np.minimum.accumulate(opening) > PUSHED)


@dataclass(frozen=True, eq=False)
class Explanation:
    """How an object that lies in one way, `resting` for the outline of `model`, explains the pairs
    that were measured.

    errors: (2n,) [m] by which its vertices are not those of the believed outline; next_errors:
    (2n,) those that explain the pairs best, by the derivatives taken here.
    """

    model: SqueezeModel
    resting: Resting
    fit: Fit
    errors: np.ndarray
    next_errors: np.ndarray


def first_explanation(
    model: SqueezeModel, resting: Resting, measured: tuple[Squeezes, ...]
) -> Explanation:
    """By the believed outline, the derivatives taken there."""
    errors = np.zeros(2 * len(model.scenario.object.polygon.vertices))
    return _explanation(model, resting, errors, measured)


def refined(
    believed: SqueezeModel, first: Explanation, measured: tuple[Squeezes, ...]
) -> Explanation:
    """With the derivatives taken at the outline that explains the pairs best, as in an iterated
    Kalman update: where another vertex touches, those of the believed outline mislead.
    """
    one = first
    for _ in range(REFINEMENTS):
        if np.abs(one.next_errors - one.errors).max() < SAME_OUTLINE:
            break
        model = believed.displaced(one.next_errors)
        if model is None:
            break
        resting = model.resting(first.resting.edge, first.resting.segment)
        better = _explanation(model, resting, one.next_errors, measured)
        if better.fit is NO_FIT:
            break
        one = better
    return replace(one, fit=one.fit._replace(residual=first.fit.residual))


def _explanation(
    model: SqueezeModel, resting: Resting, errors: np.ndarray, measured: tuple[Squeezes, ...]
) -> Explanation:
    innovations, by_vertices, by_zeros, by_held, openings = [], [], [], [], []
    for held, pairs in measured:
        prediction = model.predict(resting, held, pairs[:, held])
        innovations.append(pairs[:, 1 - held] - prediction.angles + prediction.by_vertices @ errors)
        by_vertices.append(prediction.by_vertices)
        by_held.append(prediction.by_held)
        by_zeros.append(derivatives_by_zeros(held, prediction.by_held))
        opening = np.full(len(pairs), -float(CLOSING[1 - held]))
        opening[-1] = 0.0  # whatever happened before: this is where it lies now
        openings.append(opening)
    innovation, outline = np.concatenate(innovations), np.vstack(by_vertices)
    if not np.isfinite(innovation).all() or not np.isfinite(outline).all():
        return Explanation(model, resting, NO_FIT, errors, errors)
    covariance = pairs_covariance(outline, np.vstack(by_zeros), np.concatenate(by_held))
    fit, touching = _with_gaps(innovation, covariance, np.concatenate(openings))
    gain = np.linalg.solve(covariance[np.ix_(touching, touching)], innovation[touching])
    likely = VERTEX_DEVIATION**2 * outline[touching].T @ gain
    return Explanation(model, resting, fit, errors, likely)


def derivatives_by_zeros(held: int, by_held: np.ndarray) -> np.ndarray:
    """(k, 2) of the closing finger's angles with respect to the zeros of both encoders."""
    zeros = np.ones((len(by_held), 2))
    zeros[:, held] = -by_held
    return zeros


def pairs_covariance(outline: np.ndarray, zeros: np.ndarray, by_held: np.ndarray) -> np.ndarray:
    """(k, k) [rad²] of the closing finger's angles: the outline's errors and the zeros of both
    encoders, which all pairs share, and the readings' noise. outline (k, 2n) [rad/m], zeros (k, 2),
    by_held (k,): derivatives.
    """
    return np.asarray(
        VERTEX_DEVIATION**2 * outline @ outline.T
        + OFFSET_DEVIATION**2 * zeros @ zeros.T
        + READING_DEVIATION**2 * np.diag(1.0 + by_held**2)
    )


def _x(one: Explanation, last: Squeezes) -> tuple[float, float]:
    """(x [m], its standard deviation) where the fingers stand at last: the closing one touches, the
    held one may not.
    """
    resting, pair = one.resting, last.pairs[-1]
    slides = [one.model.slide(resting, side, pair[side]) for side in (last.closing, last.held)]
    centroids = [float(resting.pose_at(slide)[0]) for slide in slides]
    if np.isnan(centroids).any():
        return next((x for x in centroids if np.isfinite(x)), np.nan), np.nan
    apart = abs(centroids[1] - centroids[0])
    x = float(np.mean(centroids)) if apart < SAME_PLACE else centroids[0]
    return x, VERTEX_DEVIATION + apart / 2


def _with_gaps(
    residuals: np.ndarray, covariance: np.ndarray, opening: np.ndarray
) -> tuple[Fit, np.ndarray]:
    """Over all ways in which the object may have lain off the held finger at some of the places,
    but FEWEST: there the closing finger is more open than predicted, anything up to
    FURTHEST_APART. opening (k,): sign in which its angle opens, 0 where it surely touched. χ² and
    residual are those of the best way, and with them the places at which it touched then.
    """
    k, best, touched = len(residuals), Fit(-np.inf, np.inf, np.inf), np.arange(len(residuals))
    densities = []
    apart = (opening * residuals > 0.0) & (opening * residuals < FURTHEST_APART)
    for off in _subsets(np.flatnonzero(apart), min(k - FEWEST, MOST_APART)):
        touching = np.setdiff1d(np.arange(k), off)
        factor = np.linalg.cholesky(covariance[np.ix_(touching, touching)])
        white = np.linalg.solve(factor, residuals[touching])
        squares = float(white @ white)
        density = -0.5 * squares - float(np.log(np.diag(factor)).sum())
        density -= 0.5 * len(touching) * np.log(2.0 * np.pi)
        density += len(touching) * np.log(1.0 - APART) + len(off) * np.log(APART / FURTHEST_APART)
        densities.append(density)
        if density > best.likelihood:
            rms = float(np.sqrt(np.mean(residuals[touching] ** 2)))
            best, touched = Fit(density, squares / len(touching), rms), touching
    return best._replace(likelihood=float(reduce(np.logaddexp, densities))), touched


def _subsets(items: np.ndarray, most: int) -> Iterator[tuple[int, ...]]:
    """Those with at most so many of the items, the smallest first."""
    for size in range(min(most, len(items)) + 1):
        yield from combinations(items, size)


def fits(candidate: Candidate) -> bool:
    """Whether an object on that edge may have been squeezed so at all."""
    return candidate.misfit <= MISFIT


def _verdict(candidates: tuple[Candidate, ...]) -> Felt:
    best = candidates[0]
    if not fits(best):
        off = (
            f'{1e3 * best.residual:.0f} mrad off' if np.isfinite(best.residual) else 'never met so'
        )
        reason = (
            f'no edge fits: wedged, or another object (nearest: {_list(best.edges)}, {off}, '
            f'χ² {best.misfit:.0f} for each pair; allowed: {MISFIT:.0f})'
        )
        return Felt(UNKNOWN, candidates, reason)
    if best.probability < SURE:
        likely = [c for c in candidates if c.probability > (1.0 - SURE) / len(candidates)]
        reason = 'not distinguishable: ' + ', '.join(
            f'{_list(c.edges)} ({c.probability:.0%})' for c in likely
        )
        return Felt(UNKNOWN, candidates, reason)
    return Felt(LYING, candidates)


def _list(edges: tuple[int, ...]) -> str:
    return f'edge {edges[0]}' if len(edges) == 1 else 'edges ' + ', '.join(map(str, edges))
