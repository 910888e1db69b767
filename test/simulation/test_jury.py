"""The jury: engines that move alike do not part; where they part, the first contact that differs is named."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wholearm_ros.mechanics.contacts import start_configuration
from wholearm_ros.model.backends import installed_backends
from wholearm_ros.model.perturbation import NOMINAL
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.simulation.closed_loop import RunRecord
from wholearm_ros.simulation.jury import Testimony as Witness
from wholearm_ros.simulation.jury import disagreements, first_difference, hear
from wholearm_ros.simulation.outcome import outcome

SCENARIO = load_scenario(Path(__file__).parents[2] / 'config/asymmetric_hexagon.yaml')
Q = start_configuration(SCENARIO)


def lifted(engine: str, height: float, since: int) -> Witness:
    """100 rows at the start; from row `since` on the object is `height` [m] higher and has turned."""
    poses = np.tile(Q[:3], (100, 1))
    poses[since:, 1] += height
    still = np.zeros((100, 2))
    record = RunRecord(
        times=np.arange(100) * 1e-3,
        angles=np.tile(Q[3:], (100, 1)),
        velocities=still,
        efforts=still,
        poses=poses,
        object_velocities=np.zeros((100, 3)),
        modes=('left velocity',) * 100,
        reason='',
        truth=SCENARIO,
        perturbation=NOMINAL,
    )
    return Witness(engine, record, outcome(SCENARIO, record), 0.0)


def test_runs_that_are_alike_do_not_part():
    assert first_difference(lifted('a', 0.0, 0), lifted('b', 5e-4, 30)) is None


@pytest.mark.parametrize('swap', [False, True])
def test_the_first_contact_that_differs_is_named_with_its_time(swap):
    pair = [lifted('stays', 0.0, 0), lifted('rises', 0.004, 30)]
    found = first_difference(*(pair[::-1] if swap else pair))
    assert found.time == pytest.approx(0.030)
    assert (found.touching, found.apart, found.gap) == ('stays', 'rises', pytest.approx(0.004))
    assert found.pair in ('v0:palm.e0', 'v1:palm.e0') and found.mode == 'left velocity'


def test_only_pairs_that_judge_differently_are_reported():
    stays, rises = lifted('stays', 0.0, 0), lifted('rises', 0.004, 30)
    assert disagreements([stays, rises]) == ()  # neither has reached the goal
    reached = replace(stays, judged=replace(stays.judged, executed=True, reason=''))
    [found] = disagreements([reached, rises])
    assert (found.reached, found.missed) == ('stays', 'rises') and found.first.time > 0.02


def test_every_engine_carries_out_the_hexagons_plan():
    answer = plan_and_verify(SCENARIO, PlanRequest(candidates=3, moves=0))
    verdict = hear(SCENARIO, answer.trajectory, NOMINAL)
    assert [t.engine for t in verdict.testimonies] == list(installed_backends())
    assert verdict.executed and verdict.disagreements == ()
    ends = np.array([t.judged.pose for t in verdict.testimonies])
    np.testing.assert_allclose(ends, np.tile(ends[0], (len(ends), 1)), atol=2e-3)
    assert max(t.penetration for t in verdict.testimonies) < 1.5e-3
    assert set(verdict.to_dict()['engines']) == set(installed_backends())
