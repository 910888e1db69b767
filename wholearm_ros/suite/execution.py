"""One run of a planned scenario on a simulated hand: perturbed by a numbered draw, and judged."""

import zlib
from dataclasses import dataclass, replace

import numpy as np

from wholearm_ros.model.backends import JURY
from wholearm_ros.model.perturbation import Perturbation, draw_perturbation
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.planner.legs import Leg
from wholearm_ros.simulation.closed_loop import RunRecord
from wholearm_ros.simulation.jury import Verdict, hear
from wholearm_ros.simulation.outcome import Outcome, outcome
from wholearm_ros.suite.attempts import Attempts
from wholearm_ros.suite.session import HandSession, Pursuit
from wholearm_ros.suite.suite_options import SuiteOptions


@dataclass(frozen=True, eq=False)
class JudgedRun:
    """One run and what came of it.

    scenario: as it was planned; record: of the first attempt; judged: the end of the last one.

    attempts: all of them, and what was claimed; None of a jury.

    verdict: of the jury, when it was asked for; record and judged are then of the first engine that
    missed the goal (`judged.reason` names it), of the first engine when none did.
    """

    scenario: Scenario
    record: RunRecord
    judged: Outcome
    perturbation: Perturbation
    attempts: Attempts | None = None
    verdict: Verdict | None = None


def execute(
    scenario: Scenario,
    first: Leg | None,
    options: SuiteOptions,
    draw: int = 0,
    name: str = '',
) -> JudgedRun:
    """Run the leg `first` under perturbation number `draw` of the task `name`, feel, and go on.

    first: None for a start that is to be felt; name: the scenario's by default.

    Raises HardwareError when the backend is not installed.
    """
    perturbation = drawn_perturbation(scenario, options, draw, name)
    if options.backend == JURY and first is not None:
        verdict = hear(first.scenario, first.trajectory, perturbation, options.loop)
        return _of_jury(scenario, verdict, perturbation)
    with HandSession(scenario, perturbation, options) as session:
        attempts = session.pursue(scenario, Pursuit(scenario, first, options))
    judged = outcome(scenario, attempts.last)
    return JudgedRun(scenario, attempts.motions[0].record, judged, perturbation, attempts)


def drawn_perturbation(
    scenario: Scenario, options: SuiteOptions, draw: int, name: str = ''
) -> Perturbation:
    """Perturbation number `draw` of the task `name`, the scenario's by default."""
    rng = perturbation_rng(options, name or scenario.name, draw)
    return draw_perturbation(rng, options.perturb, scenario, options.hand_errors)


def _of_jury(scenario: Scenario, verdict: Verdict, perturbation: Perturbation) -> JudgedRun:
    one = verdict.decisive
    reason = '' if one.judged.executed else f'{one.engine}: {one.judged.reason}'
    return JudgedRun(
        scenario,
        one.record,
        replace(one.judged, reason=reason),
        perturbation,
        verdict=verdict,
    )


def perturbation_rng(options: SuiteOptions, name: str, draw: int) -> np.random.Generator:
    """The generator of one draw: of the seed, the task's name and the draw's number only."""
    return np.random.default_rng([options.seed, zlib.crc32(name.encode()), draw])
