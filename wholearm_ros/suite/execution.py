"""One run of a planned scenario on a simulated hand: perturbed by a numbered draw, and judged."""

import zlib
from dataclasses import dataclass

import numpy as np

from wholearm_ros.model.perturbation import Perturbation, draw_perturbation
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.simulation.closed_loop import RunRecord, run
from wholearm_ros.simulation.outcome import Outcome, outcome
from wholearm_ros.suite.suite_options import SuiteOptions


@dataclass(frozen=True, eq=False)
class Execution:
    """scenario: as it was planned; record: of the run; judged: against the scenario's goal."""

    scenario: Scenario
    record: RunRecord
    judged: Outcome
    perturbation: Perturbation


def execute(
    scenario: Scenario,
    trajectory: ManipulationTrajectory,
    options: SuiteOptions,
    draw: int = 0,
    name: str = '',
    view: bool = False,
) -> Execution:
    """Run `trajectory` once under perturbation number `draw` of the task `name` (default: the scenario's).

    Raises HardwareError when the backend is not installed.
    """
    perturbation = draw_perturbation(
        perturbation_rng(options, name or scenario.name, draw), options.perturb, scenario
    )
    record = run(
        scenario,
        trajectory,
        backend=options.backend,
        rate=options.rate,
        perturbation=perturbation,
        controls=options.controls,
        view=view,
    )
    return Execution(scenario, record, outcome(scenario, record), perturbation)


def perturbation_rng(options: SuiteOptions, name: str, draw: int) -> np.random.Generator:
    """The generator of one draw: of the seed, the task's name and the draw's number only."""
    return np.random.default_rng([options.seed, zlib.crc32(name.encode()), draw])
