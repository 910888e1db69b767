"""The jury: one run on every engine that is installed, and where two of them part first.

A plan that only one engine carries out lives on that engine's peculiarities. The engines get the
same plan, the same perturbation and the same noise; what is compared are the contacts of the exact
polygons, not what an engine reports.
"""

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from wholearm_ros.mechanics.contacts import gap_table, pair_name
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.backends import installed_backends
from wholearm_ros.model.perturbation import Perturbation
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.simulation.closed_loop import LoopOptions, RunRecord, run
from wholearm_ros.simulation.outcome import Outcome, outcome

TOUCHING = 2e-4  # [m] a pair with a smaller gap touches; PyBullet rounds corners by 0.1 mm
APART = 1e-3  # [m] a pair with a larger gap does not


@dataclass(frozen=True, eq=False)
class Testimony:
    """What one engine made of the run.

    penetration [m]: the deepest of the exact polygons, at any time.
    """

    engine: str
    record: RunRecord
    judged: Outcome
    penetration: float


@dataclass(frozen=True)
class Difference:
    """Where the contacts of two engines part.

    The first time [s] at which `pair` touches in engine `touching` and is `gap` [m] apart in engine
    `apart`.
    """

    time: float
    pair: str
    touching: str
    apart: str
    gap: float
    mode: str

    def __str__(self) -> str:
        return (
            f'at {self.time:.3f} s, {self.mode}: {self.pair} touches in {self.touching}, '
            f'is {1e3 * self.gap:.1f} mm apart in {self.apart}'
        )


@dataclass(frozen=True, eq=False)
class Disagreement:
    """Two engines of which one reached the goal.

    first: where their contacts part; None when they do not.
    """

    reached: str
    missed: str
    reason: str
    first: Difference | None

    def __str__(self) -> str:
        where = self.first or 'the same contacts throughout'
        return f'{self.reached} reaches the goal, {self.missed} does not ({self.reason}); {where}'


@dataclass(frozen=True, eq=False)
class Verdict:
    """What all engines say: a disagreement for each pair of engines that judge differently."""

    testimonies: tuple[Testimony, ...]
    disagreements: tuple[Disagreement, ...]

    @property
    def executed(self) -> bool:
        """Whether the goal is reached in every engine."""
        return all(t.judged.executed for t in self.testimonies)

    @property
    def decisive(self) -> Testimony:
        """The first that missed the goal; the first of all when none did."""
        return next((t for t in self.testimonies if not t.judged.executed), self.testimonies[0])

    def lines(self) -> list[str]:
        """What a person is told: a line an engine, and one for each disagreement."""
        engines = [
            f'{t.engine}: {t.judged.reason or "at rest at the goal"}; '
            f'deepest penetration {1e3 * t.penetration:.3f} mm'
            for t in self.testimonies
        ]
        return engines + [str(d) for d in self.disagreements]

    def to_dict(self) -> dict[str, Any]:
        """For result documents."""
        return {
            'engines': {t.engine: _told(t) for t in self.testimonies},
            'disagreements': [
                {
                    'reached': d.reached,
                    'missed': d.missed,
                    'first_difference': None if d.first is None else vars(d.first),
                    'text': str(d),
                }
                for d in self.disagreements
            ],
        }


def hear(
    scenario: Scenario,
    trajectory: ManipulationTrajectory,
    perturbation: Perturbation,
    loop: LoopOptions = LoopOptions(),
    engines: tuple[str, ...] | None = None,
) -> Verdict:
    """Execute `trajectory` in every engine (default: all that are installed).

    Raises HardwareError when an engine is not installed.
    """
    testimonies = []
    for engine in engines or installed_backends():
        record = run(scenario, trajectory, engine, perturbation, loop)
        testimonies.append(testify(engine, scenario, record))
    return Verdict(tuple(testimonies), disagreements(testimonies))


def testify(engine: str, scenario: Scenario, record: RunRecord) -> Testimony:
    """What is kept of a run in `engine`; scenario: as it was planned."""
    depth = max(0.0, -float(_gaps(record)[0].min()))
    return Testimony(engine, record, outcome(scenario, record), depth)


def disagreements(testimonies: list[Testimony]) -> tuple[Disagreement, ...]:
    """One for each pair of engines that judge differently."""
    found = []
    for pair in combinations(testimonies, 2):
        missed, reached = sorted(pair, key=lambda t: t.judged.executed)
        if missed.judged.executed != reached.judged.executed:
            first = first_difference(reached, missed)
            found.append(Disagreement(reached.engine, missed.engine, missed.judged.reason, first))
    return tuple(found)


def first_difference(a: Testimony, b: Testimony) -> Difference | None:
    """Where the contacts of two runs of one plan part.

    Of a gap between TOUCHING and APART nothing is said.
    """
    (gaps_a, codes_a), (gaps_b, codes_b) = _gaps(a.record), _gaps(b.record)
    rows = min(len(gaps_a), len(gaps_b))
    gaps_a, gaps_b = gaps_a[:rows], gaps_b[:rows]
    only_a = (gaps_a < TOUCHING) & (gaps_b > APART)  # (rows, entries)
    only_b = (gaps_b < TOUCHING) & (gaps_a > APART)
    parted = np.argwhere(only_a | only_b)
    if not len(parted):
        return None
    row, entry = parted[0]
    in_a = bool(only_a[row, entry])
    touching, apart = (a, b) if in_a else (b, a)
    return Difference(
        time=float(a.record.times[row]),
        pair=pair_name(int((codes_a if in_a else codes_b)[row, entry])),
        touching=touching.engine,
        apart=apart.engine,
        gap=float((gaps_b if in_a else gaps_a)[row, entry]),
        mode=touching.record.modes[row],
    )


def _gaps(record: RunRecord) -> tuple[np.ndarray, np.ndarray]:
    """(gaps (m, entries) [m], pair codes (m, entries)) of the true polygons, a row a period."""
    world = build_world(record.truth)
    tables = [gap_table(world, q) for q in np.hstack([record.poses, record.angles])]
    return np.array([gaps for gaps, _ in tables]), np.array([codes for _, codes in tables])


def _told(testimony: Testimony) -> dict[str, Any]:
    judged = testimony.judged
    return {
        'executed': judged.executed,
        'reason': judged.reason,
        'final_pose': judged.pose.tolist(),
        'penetration': testimony.penetration,
    }
