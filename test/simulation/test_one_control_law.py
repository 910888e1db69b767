"""What is verified is what is run: the compiled rollout and the closed loop without ROS give the same commands."""

from dataclasses import replace

import numpy as np
import pytest
from problems import ASYMMETRIC, REGULAR

from wholearm_ros.control.mode_switch import course_of
from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.model.band import Band
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.rollout.perturbed_samples import (
    build_perturbed_samples,
    follow_course,
    start_at_rest,
)
from wholearm_ros.simulation.closed_loop import LoopOptions, run

SETTLE = 0.2  # [s]
DRAWS = 3


@pytest.fixture(scope='module', params=[ASYMMETRIC, REGULAR], ids=lambda s: s.name)
def planned(request):
    return request.param, plan_and_verify(
        request.param, PlanRequest(samples=2, certificate_samples=0, time_budget=3600.0)
    ).trajectory


def both(scenario, trajectory, level, draw, controls=ControlOptions(), hand_errors=0.0):
    """(the rollout of one perturbed sample, the record of the closed loop on the planar hand with the same perturbation)."""
    sample = build_perturbed_samples(scenario, draw + 1, level, 11, hand_errors)[draw + 1]
    record = run(
        scenario,
        trajectory,
        backend='planar',
        perturbation=sample.perturbation,
        loop=LoopOptions(controls=controls, settle=SETTLE),
    )
    rolled = follow_course(
        sample, course_of(trajectory), start_at_rest(sample), controls, SETTLE, len(record.times)
    )
    return rolled, record


@pytest.mark.parametrize('level, hand_errors', [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (1.0, 1.0)])
@pytest.mark.parametrize('draw', range(DRAWS))
def test_a_rollout_and_the_closed_loop_give_the_same_joint_commands(
    planned, level, hand_errors, draw
):
    """Every command of the run, of both motors, to 1e-9 N m, with delay, noise, friction, weak motors, another mass and shape, errors of the hand."""
    rolled, record = both(*planned, level, draw, hand_errors=hand_errors)
    assert not rolled.stopped and not record.reason
    np.testing.assert_allclose(rolled.commands, record.efforts, atol=1e-9, rtol=0.0)
    np.testing.assert_allclose(rolled.q[:3], record.poses[-1], atol=1e-4)


def test_both_stop_on_the_same_tracking_error(planned):
    """With a tenth of the allowed error: the rollout ends where the closed loop's mode switch stops."""
    controls = ControlOptions(max_tracking_error=0.005)
    rolled, record = both(*planned, 2.0, 0, controls)
    stopped = record.modes.index('stopped')
    assert f'{rolled.switch.error:+.3f} rad' in record.reason
    np.testing.assert_allclose(
        rolled.commands[:stopped], record.efforts[:stopped], atol=1e-9, rtol=0.0
    )


def narrow(trajectory, planned_angles):
    """The trajectory with a band of 1 mrad round what one run did."""
    period = 0.02
    rows = planned_angles[:: int(period * 1000)]
    return replace(trajectory, band=Band(period, rows - 0.001, rows + 0.001, 0.02))


def test_both_stop_where_the_same_run_leaves_its_band(planned):
    """A band round the nominal run, and another sample: the same segment, time and residuals, and the same commands until then."""
    scenario, trajectory = planned
    controls = ControlOptions(stop_outside=True)
    nominal = run(scenario, trajectory, backend='planar', loop=LoopOptions(settle=SETTLE))
    ramp = int(round(1000 * controls.ramp))
    rolled, record = both(scenario, narrow(trajectory, nominal.angles[ramp:]), 2.0, 0, controls)
    outside, stopped = rolled.switch.outside, record.modes.index('stopped')
    assert rolled.stopped and rolled.switch.error == 0.0
    assert f't = {outside.deviated:.2f} s' in record.reason and record.reason == record.deviated
    assert f'{outside.left:+.3f} rad' in record.reason and f'{outside.right:+.3f}' in record.reason
    np.testing.assert_allclose(
        rolled.commands[:stopped], record.efforts[:stopped], atol=1e-9, rtol=0.0
    )
