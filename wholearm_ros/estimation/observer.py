"""The observer: where the object is, from the finger angles alone, by a small bank of hypotheses.

While a trajectory runs, the object is in one of the contact states of this point of the plan. Four
closed contacts leave one degree of freedom, and two measured angles overdetermine it: they are
projected on the planned path near the clock, which gives a phase and a residual. At rest and while
probing, it lies on an edge: the angle of one finger says where, and so where the other one meets
it.
"""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.estimation.feel import VERTEX_DEVIATION, Feeler
from wholearm_ros.estimation.squeeze import Resting
from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.hand import LEFT, RIGHT
from wholearm_ros.model.trajectory import ManipulationTrajectory

WINDOW = 0.12  # [s] either side of the clock in which the planned path is looked at
PHASE_WEIGHT = 0.05  # [rad/s]: a phase of 100 ms counts as much as a residual of 5 mrad
FITTING = 0.06  # [rad] beyond which not even the best hypothesis is believed
ANGLE_DEVIATION = 0.01  # [rad] of a rotation, standard, when the residual is zero


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """name: for people; pose (3,) [m, m, rad] that it means; residual [rad] of the finger angles.

    phase [s]: how far along the plan it is ahead of the clock.
    """

    name: str
    pose: np.ndarray
    residual: float
    phase: float = 0.0


@dataclass(frozen=True, eq=False)
class Estimate:
    """hypotheses: that can be at all, the one that fits best first."""

    hypotheses: tuple[Hypothesis, ...]

    @property
    def best(self) -> Hypothesis | None:
        """The first one if it fits, None when nothing does."""
        fits = bool(self.hypotheses) and self.hypotheses[0].residual <= FITTING
        return self.hypotheses[0] if fits else None

    def describe(self) -> str:
        """One line for people."""
        if not self.hypotheses:
            return 'unknown: no hypothesis explains these angles'
        first = self.hypotheses[0]
        if self.best is None:
            return f'unknown: nearest is {first.name}, {1e3 * first.residual:.0f} mrad off'
        return first.name

    def to_dict(self) -> dict[str, float | str]:
        """Names and residuals of the best and the next best, and how many there were."""
        told: dict[str, float | str] = {'hypotheses': len(self.hypotheses)}
        for word, one in zip(('best', 'next'), self.hypotheses):
            told[word] = one.name
            told[f'{word} residual rad'] = one.residual
        if self.hypotheses:
            told['phase s'] = self.hypotheses[0].phase
        return told


class Observer:
    """What the angles of a scenario's hand say; holds nothing of what was before."""

    def __init__(self, feeler: Feeler) -> None:
        self.feeler = feeler

    def deviations(self, hypothesis: Hypothesis) -> np.ndarray:
        """(3,) [m, m, rad] standard deviations of its pose: what the residual leaves open."""
        length = VERTEX_DEVIATION + self.feeler.model.world.scale[0] * hypothesis.residual
        return np.array([length, length, ANGLE_DEVIATION + hypothesis.residual])

    def following(
        self, trajectory: ManipulationTrajectory, elapsed: float, angles: np.ndarray
    ) -> Estimate:
        """While a trajectory runs, `elapsed` [s] along it: one hypothesis a contact state."""
        last = len(trajectory.angles) - 1
        first, end = ((elapsed + d) / trajectory.period for d in (-WINDOW, WINDOW))
        rows = np.arange(max(int(first), 0), min(int(np.ceil(end)), last) + 1)
        if not len(rows):
            rows = np.array([0 if elapsed < 0.0 else last])
        off = np.linalg.norm(trajectory.angles[rows] - angles, axis=1)
        ends = np.array([s.end for s in trajectory.segments])
        segments = np.minimum(
            np.searchsorted(ends, rows * trajectory.period, 'right'), len(ends) - 1
        )
        found: dict[str, Hypothesis] = {}
        phases = rows * trajectory.period - elapsed
        for k in np.argsort(off**2 + (PHASE_WEIGHT * phases) ** 2, kind='stable'):
            segment = trajectory.segments[segments[k]]
            name = f'{segment.mode}: {", ".join(segment.contacts) or "contacts unknown"}'
            pose = trajectory.poses[rows[k]]
            found.setdefault(name, Hypothesis(name, pose, float(off[k]), float(phases[k])))
        return Estimate(tuple(found.values()))

    def resting(self, angles: np.ndarray) -> Estimate:
        """At rest: one hypothesis for each edge, alike ones together, and segment of the palm."""
        found = []
        for members in self.feeler.classes:
            one = self.feeler.hypotheses[members[0]]
            edges = ', '.join(str(self.feeler.hypotheses[k].edge) for k in members)
            name = f'on edge {edges}'
            squeezes = [self._squeezed(name, one, held, angles) for held in (LEFT, RIGHT)]
            found.append(min(squeezes, key=lambda h: h.residual))
        found = [h for h in found if np.isfinite(h.residual)]
        return Estimate(tuple(sorted(found, key=lambda h: h.residual)))

    def _squeezed(self, name: str, resting: Resting, held: int, angles: np.ndarray) -> Hypothesis:
        """The object at the held finger; the residual is that of the other one."""
        slides, other = self.feeler.model.squeeze(resting, held, angles[held : held + 1])
        if not np.isfinite(other[0]):
            return Hypothesis(name, resting.pose, np.inf)
        pose = readonly(resting.pose_at(slides[0]), (3,))
        return Hypothesis(name, pose, abs(float(angles[1 - held] - other[0])))
