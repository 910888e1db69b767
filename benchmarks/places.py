"""What a probe makes of an object that lies on each of its faces, at places all along the palm.

    python benchmarks/places.py [SCENARIO ...] [--edges 1 2] [--x -30 0 30] [--levels 1] [--draws 2] [--hand-errors 0]
                                [--backend pybullet] [--verbose]

SCENARIO: a file, or SUITE.json:TASK; all that are shipped by default. The object is set down on a face with its centroid at x [mm],
the fingers closed on it, and felt as after a trajectory that ended there: held by the left finger in even draws, by the
right one in odd ones; and once more from the other side if that leaves it open. A row of the table: runs, felt on the face on which it
truly lies then (regular polygons: up to symmetry), left open, felt on another one, on another face than before the
probes (spoiled), probes with one place only, |felt x − true x| (median, 95 %), seconds of a probe (median, 95 %).
"""

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from wholearm_ros.errors import ScenarioError
from wholearm_ros.estimation.hold import hold_trajectory
from wholearm_ros.mechanics.contacts import start_configuration
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.hand import LEFT, RIGHT
from wholearm_ros.model.outcomes import LYING
from wholearm_ros.model.scenario import GoalOnEdge, Scenario, StartOnEdge
from wholearm_ros.model.scenario_file import load_scenario, parse_scenario
from wholearm_ros.planner.legs import Leg
from wholearm_ros.suite.attempts import true_rest
from wholearm_ros.suite.execution import execute
from wholearm_ros.suite.suite_file import load_suite
from wholearm_ros.suite.suite_options import SuiteOptions

CONFIG = Path(__file__).parents[1] / 'config'
SHIPPED = [
    str(CONFIG / f'{name}.yaml')
    for name in (
        'asymmetric_hexagon', 'regular_hexagon', 'tapered_fingers', 'hooked_fingers', 'unequal_fingers',
        'v_palm',
    )
]  # fmt: skip
X = (-30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0)  # [mm]


@dataclass(frozen=True)
class Lain:
    """One run: what was felt (None when that was left open) and what is true; x_error [m], places: of the first
    probe; seconds [s], reasons: of each.
    """

    felt: tuple[int, ...] | None
    true_edge: int | None
    set_down: int
    x_error: float
    places: int
    seconds: tuple[float, ...]
    reasons: str

    @property
    def right(self) -> bool:
        """Whether it was felt on the edge on which it lies."""
        return self.felt is not None and self.true_edge in self.felt

    @property
    def wrong(self) -> bool:
        """Whether it was felt on another one."""
        return self.felt is not None and not self.right

    @property
    def spoiled(self) -> bool:
        """Whether it no longer lies on the edge on which it was set down."""
        return self.true_edge != self.set_down


def laid(scenario: Scenario, edge: int, x: float) -> Scenario:
    """Lying on an edge at x [m], where it shall be."""
    return replace(scenario, start=StartOnEdge(edge, x), goal=GoalOnEdge(edge))


def felt_at(scenario: Scenario, options: SuiteOptions, draw: int) -> Lain:
    """The object of a scenario felt where it starts. Raises ScenarioError when it cannot lie there."""
    q, weights = start_configuration(scenario), build_world(scenario).finger_weights
    hold = hold_trajectory(q[3:], weights, q[:3], (LEFT, RIGHT)[draw % 2])
    made = execute(scenario, Leg(hold, scenario), options, draw, scenario.name).attempts
    felt, first = made.claim.felt, made.motions[0].record
    edge, x = true_rest(made.last)
    told = felt.best if felt is not None and felt.kind == LYING else None
    return Lain(
        told and told.edges,
        edge,
        true_rest(made.motions[0].before_probe)[0],
        abs(told.x - x) if told else np.nan,
        len(first.pairs),
        tuple(motion.probing_time for motion in made.motions),
        '; '.join(motion.claim.reason for motion in made.motions),
    )


def row(name: str, runs: list[Lain]) -> str:
    """Of the table."""
    x_error = [1e3 * run.x_error for run in runs if np.isfinite(run.x_error)]
    seconds = [run.seconds[0] for run in runs]
    shown = (
        name,
        len(runs),
        sum(run.right for run in runs),
        sum(run.felt is None for run in runs),
        sum(run.wrong for run in runs),
        sum(run.spoiled for run in runs),
        sum(run.places == 1 for run in runs),
        _spread(x_error),
        _spread(seconds),
    )
    return '| ' + ' | '.join(map(str, shown)) + ' |'


def _spread(values: list[float]) -> str:
    return '{:.2f}, {:.2f}'.format(*np.percentile(values, [50, 95])) if values else ''


def scenario_named(name: str) -> Scenario:
    """A file, or a task of a suite: SUITE.json:TASK, the beginning of its name."""
    if ':' not in name:
        return load_scenario(name)
    file, task = name.rsplit(':', 1)
    found = next(t for t in load_suite(Path(file)) if t.name.startswith(task))
    return parse_scenario(found.scenario, found.name)


def main() -> None:
    """Feel everywhere, and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('scenarios', nargs='*', default=SHIPPED)
    parser.add_argument('--edges', nargs='+', type=int, help='all that carry the object')
    parser.add_argument('--x', nargs='+', type=float, default=X, help='of the centroid [mm]')
    parser.add_argument('--levels', nargs='+', type=float, default=[1.0])
    parser.add_argument('--draws', type=int, default=2)
    parser.add_argument('--hand-errors', type=float, default=0.0)
    parser.add_argument('--backend', default='pybullet')
    parser.add_argument('--verbose', action='store_true', help='what was not felt right')
    options = parser.parse_args()
    print(
        '| object, level, edge | runs | right | open | wrong | spoiled | one place | x error, mm (median, p95) '
        '| probe, s (median, p95) |\n' + '|---' * 9 + '|'
    )
    done: list[Lain] = []
    for name in options.scenarios:
        scenario = scenario_named(name)
        for level in options.levels:
            asked = SuiteOptions(
                perturb=level, backend=options.backend, hand_errors=options.hand_errors
            )
            for edge in options.edges or scenario.object.polygon.resting_edges:
                runs = []
                for x in options.x:
                    for draw in range(options.draws):
                        try:
                            run = felt_at(laid(scenario, edge, 1e-3 * x), asked, draw)
                        except ScenarioError:
                            continue  # out of reach
                        if run.set_down != edge:
                            continue  # the true one does not stand there
                        runs.append(run)
                        if options.verbose and (not run.right or run.spoiled):
                            print(
                                f'  {scenario.name} {level:g} edge {edge} x {x:g} draw {draw}: {run}'
                            )
                print(row(f'{scenario.name}, {level:g}, {edge}', runs), flush=True)
                done += runs
    print(row('all', done))


if __name__ == '__main__':
    main()
