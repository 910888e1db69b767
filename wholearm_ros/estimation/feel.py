"""Feeling: from pairs of finger angles to where the object lies, how surely, and what else it might be."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from wholearm_ros.estimation.hypotheses import alike, resting_hypotheses
from wholearm_ros.estimation.squeeze import Prediction, Resting, SqueezeModel
from wholearm_ros.model.hand import CLOSING
from wholearm_ros.model.outcomes import LYING, NOTHING, UNKNOWN
from wholearm_ros.model.probe import Probe
from wholearm_ros.model.scenario import Scenario

VERTEX_DEVIATION = 0.0006  # [m] each coordinate of a vertex, standard: ±1 mm evenly spread
OFFSET_DEVIATION = 0.001  # [rad] of an encoder's zero
READING_DEVIATION = 0.0005  # [rad] of a pair's angles, noise and rest together
SURE = 0.99  # probability from which a hypothesis is told
MISFIT = 6.0  # χ² for each pair above which not even the best hypothesis fits
APART = (
    0.1  # probability that the object lies off the held finger at a place, where friction kept it
)
FURTHEST_APART = 0.2  # [rad] by which the closing finger is then more open at most
PUSHED = 0.002  # [rad] by which the closing finger must have given way for the held one to be touching, too
FEWEST = 3  # such pairs from which something can be told
AT_STOP = 0.03  # [rad] from its stop: the closing finger met nothing
SAME_PLACE = 0.003  # [m] both fingers say the same x


@dataclass(frozen=True)
class Candidate:
    """edges: alike to the fingers; segment of the palm; x [m] of the centroid and its standard deviation; residual [rad]:
    rms of the closing finger's angles; misfit: χ² for each pair; probability: among the candidates.
    """

    edges: tuple
    segment: int
    x: float
    x_deviation: float
    residual: float
    misfit: float
    probability: float

    def to_dict(self) -> dict:
        """For documents; what is not finite is None."""
        numbers = ('x', 'x_deviation', 'residual', 'misfit', 'probability')
        told = {n: getattr(self, n) if np.isfinite(getattr(self, n)) else None for n in numbers}
        return {'edges': list(self.edges), 'segment': self.segment, **told}


@dataclass(frozen=True)
class Felt:
    """kind: 'lying' on the first candidate's edge (surely), 'nothing' in the hand, or 'unknown'; candidates, the most
    probable first; reason: why unknown; pairs: what the fingers measured.
    """

    kind: str
    candidates: tuple = ()
    reason: str = ''
    pairs: tuple = field(default=(), repr=False)

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

    def to_dict(self) -> dict:
        """For documents."""
        return {
            'kind': self.kind,
            'reason': self.reason,
            'candidates': [c.to_dict() for c in self.candidates],
            'pairs': [[float(a) for a in pair] for pair in self.pairs],
        }


class Feeler:
    """What a scenario's object feels like; built once, asked after every probe."""

    def __init__(self, scenario: Scenario):
        self.model = SqueezeModel(scenario)
        self.hypotheses = resting_hypotheses(self.model)
        self.classes = alike(self.model, self.hypotheses)

    @property
    def symmetric(self) -> bool:
        """Whether some edges of the object feel alike."""
        return any(len(members) > 1 for members in self.classes)

    def feel(self, probe: Probe, pairs: np.ndarray, interrupted: str = '') -> Felt:
        """What the pairs (k, 2) [rad], left then right, of a probe of k places say; interrupted: why the probe ended early, if it did."""
        pairs = np.asarray(pairs, float).reshape(-1, 2)
        told = tuple(map(tuple, pairs.tolist()))
        if interrupted or len(pairs) != len(probe.places):
            return Felt(UNKNOWN, reason=interrupted or 'the probe was interrupted', pairs=told)
        closing = pairs[:, probe.closing]
        if abs(closing[-1] - probe.stops[probe.closing]) < AT_STOP:
            return Felt(NOTHING, pairs=told)
        both = squeezed(probe, pairs)
        both[-1] = True
        if both.sum() < FEWEST:
            reason = f'the fingers squeezed something at {both.sum()} places; needed: {FEWEST}'
            return Felt(UNKNOWN, reason=reason, pairs=told)
        return _verdict(self._candidates(probe.held, pairs[both], pairs[-1]), told)

    def _candidates(self, held: int, pairs: np.ndarray, last: np.ndarray) -> tuple:
        found = []
        for members in self.classes:
            resting = self.hypotheses[members[0]]
            prediction = self.model.predict(resting, held, pairs[:, held])
            likelihood, misfit, residual = _likelihood(
                prediction, pairs[:, 1 - held], -CLOSING[1 - held]
            )
            edges = tuple(self.hypotheses[k].edge for k in members)
            found.append((likelihood, misfit, residual, edges, resting))
        found.sort(key=lambda c: -c[0])
        weights = np.exp(np.array([c[0] for c in found]) - found[0][0])
        weights /= weights.sum()
        return tuple(
            Candidate(
                edges, resting.segment, *self._x(resting, held, last), residual, misfit, float(p)
            )
            for p, (_, misfit, residual, edges, resting) in zip(weights, found)
        )

    def _x(self, resting: Resting, held: int, pair: np.ndarray) -> tuple:
        """(x [m], its standard deviation) where the fingers stand at last: the closing one touches, the held one may not."""
        slides = [self.model.slide(resting, side, pair[side]) for side in (1 - held, held)]
        centroids = [float(resting.pose_at(slide)[0]) for slide in slides]
        if np.isnan(centroids).any():
            return next((x for x in centroids if np.isfinite(x)), np.nan), np.nan
        x = np.mean(centroids) if abs(centroids[1] - centroids[0]) < SAME_PLACE else centroids[0]
        return float(x), VERTEX_DEVIATION + abs(centroids[1] - centroids[0]) / 2


def squeezed(probe: Probe, pairs: np.ndarray) -> np.ndarray:
    """(k,) bool: pairs at which both fingers touch: the closing one gave way to the held one's last move.

    Where it did not, friction may hold the object away from the held finger.
    """
    closing = pairs[:, probe.closing]
    gave_way = -CLOSING[probe.closing] * np.diff(closing, prepend=closing[:1])
    return gave_way > PUSHED


def _likelihood(prediction: Prediction, measured: np.ndarray, opening: float) -> tuple:
    """(log likelihood, χ² for each pair, rms residual [rad]) of the closing finger's angles (k,).

    opening: sign in which its angle opens. The covariance has the outline's errors, which all pairs share, the zeros of both encoders, and the readings' noise.
    """
    residuals, k = measured - prediction.angles, len(measured)
    if not np.isfinite(residuals).all() or not np.isfinite(prediction.by_vertices).all():
        return -1e9, np.inf, np.inf
    held = prediction.by_held
    covariance = (
        VERTEX_DEVIATION**2 * prediction.by_vertices @ prediction.by_vertices.T
        + OFFSET_DEVIATION**2 * (np.ones((k, k)) + np.outer(held, held))
        + READING_DEVIATION**2 * np.diag(1.0 + held**2)
    )
    return _with_gaps(residuals, covariance, opening)


def _with_gaps(residuals: np.ndarray, covariance: np.ndarray, opening: float) -> tuple:
    """The same over all ways in which the object may have lain off the held finger at some of the places, but FEWEST: there
    the closing finger is more open than predicted, anything up to FURTHEST_APART. χ² and residual are those of the best way.
    """
    k, best, terms = len(residuals), (-np.inf, np.inf, np.inf), []
    apart = (opening * residuals > 0.0) & (opening * residuals < FURTHEST_APART)
    apart[-1] = False  # whatever happened before: this is where it lies now
    for off in _subsets(np.flatnonzero(apart), k - FEWEST):
        touching = np.setdiff1d(np.arange(k), off)
        factor = np.linalg.cholesky(covariance[np.ix_(touching, touching)])
        white = np.linalg.solve(factor, residuals[touching])
        squares = float(white @ white)
        density = -0.5 * squares - float(np.log(np.diag(factor)).sum())
        density -= 0.5 * len(touching) * np.log(2.0 * np.pi)
        density += len(touching) * np.log(1.0 - APART) + len(off) * np.log(APART / FURTHEST_APART)
        terms.append(density)
        if density > best[0]:
            rms = float(np.sqrt(np.mean(residuals[touching] ** 2)))
            best = density, squares / len(touching), rms
    return float(np.logaddexp.reduce(terms)), best[1], best[2]


def _subsets(items: np.ndarray, most: int) -> Iterator[tuple]:
    for size in range(min(most, len(items)) + 1):
        yield from combinations(items, size)


def fits(candidate: Candidate) -> bool:
    """Whether an object on that edge may have been squeezed so at all."""
    return candidate.misfit <= MISFIT


def _verdict(candidates: tuple, pairs: tuple) -> Felt:
    best = candidates[0]
    if not fits(best):
        off = (
            f'{1e3 * best.residual:.0f} mrad off' if np.isfinite(best.residual) else 'never met so'
        )
        reason = (
            f'no edge fits: wedged, or another object (nearest: {_list(best.edges)}, {off}, '
            f'χ² {best.misfit:.0f} for each pair; allowed: {MISFIT:.0f})'
        )
        return Felt(UNKNOWN, candidates, reason, pairs)
    if best.probability < SURE:
        likely = [c for c in candidates if c.probability > (1.0 - SURE) / len(candidates)]
        reason = 'not distinguishable: ' + ', '.join(
            f'{_list(c.edges)} ({c.probability:.0%})' for c in likely
        )
        return Felt(UNKNOWN, candidates, reason, pairs)
    return Felt(LYING, candidates, '', pairs)


def _list(edges: tuple) -> str:
    return f'edge {edges[0]}' if len(edges) == 1 else 'edges ' + ', '.join(map(str, edges))
