"""The observer against simulated runs: it tells where the object is without having seen it."""

import numpy as np
import pytest
from problems import ASYMMETRIC, REGULAR

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.estimation.feel import Feeler
from wholearm_ros.estimation.observer import FITTING, Observer
from wholearm_ros.model.modes import DWELL, QUASI_STATIC
from wholearm_ros.planning.routes import plan
from wholearm_ros.rollout.perturbed_samples import build_perturbed_samples
from wholearm_ros.rollout.verification import roll_out
from wholearm_ros.trajectory.execution_options import ExecutionOptions
from wholearm_ros.trajectory.main_trajectory import generate

OBSERVER = Observer(Feeler(ASYMMETRIC))
TRAJECTORY = generate(ASYMMETRIC, plan(ASYMMETRIC), ExecutionOptions())


def test_on_the_plan_its_pose_is_the_estimate_and_its_segment_the_state():
    for t in np.linspace(0.0, TRAJECTORY.duration, 40):
        k = int(round(t / TRAJECTORY.period))
        found = OBSERVER.following(TRAJECTORY, k * TRAJECTORY.period, TRAJECTORY.angles[k])
        assert found.best.residual == pytest.approx(0.0, abs=1e-9)
        planned = TRAJECTORY.poses[k]
        assert np.abs(found.best.pose - planned).max() < 0.02 or 'caging' in found.best.name


def test_a_run_that_is_late_is_seen_in_the_phase():
    """Angles of 50 ms before, where the fingers move: the phase is −50 ms, the residual as good as nothing."""
    k = int(np.abs(TRAJECTORY.velocities).sum(axis=1).argmax())
    late = int(round(0.05 / TRAJECTORY.period))
    found = OBSERVER.following(TRAJECTORY, k * TRAJECTORY.period, TRAJECTORY.angles[k - late]).best
    assert found.phase == pytest.approx(-0.05, abs=1.5 * TRAJECTORY.period)
    assert found.residual < 1e-9


def test_angles_that_no_hypothesis_explains_are_not_known():
    found = OBSERVER.following(TRAJECTORY, 0.0, TRAJECTORY.angles[0] + [0.0, 2.0 * FITTING])
    assert found.best is None and found.describe().startswith('unknown')
    assert found.to_dict()['best residual rad'] > FITTING


@pytest.mark.parametrize('scenario', [ASYMMETRIC, REGULAR], ids=lambda s: s.name)
def test_at_rest_the_edge_is_told_alike_ones_together(scenario):
    """Every edge that carries the object, squeezed: the residual of the true one is zero and its pose exact."""
    observer = Observer(Feeler(scenario))
    for resting in observer.feeler.hypotheses:
        slides, other = observer.feeler.model.squeeze(resting, 0, np.array([2.0]))
        if not np.isfinite(other[0]):
            continue
        found = observer.resting(np.array([2.0, other[0]]))
        assert found.hypotheses[0].residual < 1e-6
        told = [int(e) for e in found.best.name.removeprefix('on edge ').split(', ')]
        assert resting.edge in told
        assert len(told) == (6 if scenario is REGULAR else 1)


def test_a_perturbed_run_is_followed_as_long_as_the_fingers_hold_the_object():
    """A nominal rollout and one at level 1, until caging begins: rotation within 0.1 rad."""
    free = next(s.start for s in TRAJECTORY.segments if s.mode not in (QUASI_STATIC, DWELL))
    for sample in build_perturbed_samples(ASYMMETRIC, 1, 1.0, 3):
        rolled = roll_out(TRAJECTORY, sample, ControlOptions())
        for t, q in zip(rolled.times[rolled.times < free], rolled.configurations):
            found = OBSERVER.following(TRAJECTORY, t, q[3:]).best
            assert found is not None and abs(found.pose[2] - q[2]) < 0.1
