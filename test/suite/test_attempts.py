"""Attempts on the planar hand: what is claimed is what is, and a second try begins where the first one ended."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wholearm_ros.estimation.hold import hold_to_feel, hold_trajectory
from wholearm_ros.mechanics.contacts import start_configuration
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.outcomes import AT_GOAL, ELSEWHERE, LOST, UNKNOWN, UNVERIFIED
from wholearm_ros.model.perturbation import NOMINAL, Perturbation
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario import GoalOnEdge, ManipulatedObject, StartOnEdge
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.model.weight import bearing_torques
from wholearm_ros.planner.legs import Leg
from wholearm_ros.simulation.factory import make_hand
from wholearm_ros.suite import session as session_module
from wholearm_ros.suite.attempts import true_rest
from wholearm_ros.suite.session import HandSession, Pursuit
from wholearm_ros.suite.suite_options import SuiteOptions

SCENARIO = load_scenario(Path(__file__).parents[2] / 'config' / 'asymmetric_hexagon.yaml')

HEPTAGON = [[0, 0], [-27, 41], [-91, 56], [-123, 29], [-115, -27], [-96, -64], [-37, -64]]
# The centroid is 3 mm inside of its face 4.
BARELY = replace(
    SCENARIO,
    object=ManipulatedObject(Polygon(1e-3 * np.array(HEPTAGON)), 0.39),
    start=StartOnEdge(4, -0.017),
    goal=GoalOnEdge(4),
)


def holding(scenario, held=0):
    q = start_configuration(scenario)
    return hold_trajectory(q[3:], build_world(scenario).finger_weights, q[:3], held)


def no_plan(scenario):
    return None


def run_attempts(scenario, trajectory, perturbation, plan_again=no_plan, start=None, **options):
    """Pursue a scenario's goal on the planar hand, first with the trajectory given."""
    options = SuiteOptions(backend='planar', maps=False, **options)
    pursuit = Pursuit(scenario, Leg(trajectory, scenario), options)
    planned = pursuit.plan
    pursuit.plan = lambda asked: planned(asked) if asked is scenario else plan_again(asked)
    with HandSession(scenario, perturbation, options, start=start) as session:
        return session.pursue(scenario, pursuit)


@pytest.mark.parametrize('held', [0, 1])
@pytest.mark.parametrize('friction', [0.0, 0.1])
def test_what_lies_in_the_hand_is_felt_where_it_is(held, friction):
    noise = Perturbation(friction=friction, encoder_noise=2e-4, velocity_noise=0.02)
    made = run_attempts(SCENARIO, holding(SCENARIO, held), noise)
    edge, x = true_rest(made.last)
    assert made.outcome == ELSEWHERE and made.claim.edge == edge == 0
    assert made.claim.x == pytest.approx(x, abs=1e-3)
    assert made.last.modes[-1] == 'done' and 'probing' in made.last.modes


@pytest.mark.parametrize('friction', [0.0, 0.05])
def test_an_object_that_is_felt_again_is_squeezed_until_then(friction):
    noise = Perturbation(friction=friction, encoder_noise=6e-4, velocity_noise=0.06)
    options = SuiteOptions(backend='planar', maps=False)
    with HandSession(SCENARIO, noise, options) as session:
        claims = [session.feel(SCENARIO) for _ in range(3)]
    for motion in session.motions[1:]:
        record = motion.record
        still = record.angles[: record.modes.index('probing')]
        assert np.ptp(still, axis=0).max() < 0.02
        assert motion.probing_time < 5.0  # [s]: nothing has to be closed again
    assert {claim.edge for claim in claims} == {0}
    sides = [motion.trajectory.probe.held for motion in session.motions]
    assert sides[1] != sides[0]


def test_fingers_that_have_moved_since_they_squeezed_do_not_squeeze_on():
    options = SuiteOptions(backend='planar', maps=False)
    with HandSession(SCENARIO, NOMINAL, options) as session:
        felt, angles = session.feel(SCENARIO).felt, session.hand.joints()[0]
        last, feeler = session.motions[-1].trajectory, session.feeler
    away = angles + [0.0, 0.2]
    there, moved = (hold_to_feel(feeler, a, last, felt) for a in (angles, away))
    for hold, squeezes in ((there, True), (moved, False)):
        weight = bearing_torques(feeler.model.world.finger_weights, hold.angles)
        assert np.abs(hold.efforts - weight).max() == pytest.approx(squeezes * last.probe.torque)
    assert moved.probe.held == last.probe.held and there.probe.held != last.probe.held


def test_an_object_that_lies_at_its_goal_is_claimed_there_and_stays_there():
    there = replace(SCENARIO, goal=GoalOnEdge(0, 'ccw', -0.02, 0.01))
    made = run_attempts(there, holding(there), NOMINAL)
    assert made.outcome == AT_GOAL
    assert made.last.poses[-1, 0] == pytest.approx(-0.02, abs=1e-3)


@pytest.mark.parametrize('friction', [0.0, 0.05, 0.1])
def test_squeezes_do_not_tip_an_object_off_a_face_that_it_barely_stands_on(friction):
    made = run_attempts(BARELY, holding(BARELY), Perturbation(friction=friction))
    assert made.outcome == AT_GOAL and made.claim.edge == 4


def test_without_a_probe_nothing_is_claimed():
    made = run_attempts(SCENARIO, holding(SCENARIO), NOMINAL, probe=False)
    assert made.outcome == UNVERIFIED and made.to_dict()['felt_edge'] is None


def test_an_object_that_is_not_there_is_lost():
    q = start_configuration(SCENARIO)
    gone = np.array([0.6, 0.4, 0.0, *q[3:]])
    made = run_attempts(SCENARIO, holding(SCENARIO), NOMINAL, start=gone)
    assert made.outcome == LOST


def test_a_second_attempt_goes_on_with_the_same_hand():
    again = []

    def plan_again(scenario):
        again.append(scenario)
        return Leg(holding(scenario), scenario)

    made = run_attempts(SCENARIO, holding(SCENARIO), NOMINAL, plan_again, attempts=2)
    assert made.attempts == 2 and made.outcome == ELSEWHERE
    assert again[0].start.edge == 0 and again[0].start.x == pytest.approx(-0.02, abs=1e-3)
    first, second = (motion.record for motion in made.motions)
    assert second.times[0] > first.times[-1]
    assert second.poses[0] == pytest.approx(first.poses[-1], abs=1e-3)
    assert UNKNOWN not in {motion.claim.outcome for motion in made.motions}
    alone = made.first(1)
    assert (alone.attempts, alone.outcome) == (1, ELSEWHERE) and alone.last.times[
        -1
    ] == first.times[-1]


class FaultyEncoder:
    """A hand one of whose encoders lies: angle [rad] and time [s] → reading [rad]."""

    def __init__(self, hand, side, reading):
        self._hand, self._side, self._reading = hand, side, reading

    def __getattr__(self, name):
        return getattr(self._hand, name)

    def joints(self):
        angles, velocities = self._hand.joints()
        angles = angles.copy()
        angles[self._side] = self._reading(angles[self._side], self._hand.time)
        return angles, velocities


def noisy(angle, time, rng=np.random.default_rng(5)):
    """Ten times the noise of level 1."""
    return angle + 2e-3 * rng.standard_normal()


def offset(angle, time):
    return angle + 0.02


def stuck(angle, time):
    """At an angle that the fingers pass while they probe."""
    return angle if time < 2.0 else 1.3


@pytest.mark.parametrize('side', [0, 1])
@pytest.mark.parametrize('reading', [noisy, offset, stuck])
def test_an_encoder_that_lies_leads_to_no_wrong_claim(monkeypatch, reading, side):
    def faulty_hand(*options, **more):
        return FaultyEncoder(make_hand(*options, **more), side, reading)

    monkeypatch.setattr(session_module, 'make_hand', faulty_hand)
    made = run_attempts(SCENARIO, holding(SCENARIO), NOMINAL)
    edge, _ = true_rest(made.last)
    assert made.outcome in (ELSEWHERE, UNKNOWN) and made.claim.edge in (-1, edge)
    if reading is noisy:
        assert made.claim.edge == edge == 0


@pytest.mark.parametrize('side', [0, 1])
def test_a_motor_at_70_percent_of_its_torque_still_feels(side):
    weak = Perturbation(torque_factors=np.where(np.arange(2) == side, 0.7, 1.0))
    made = run_attempts(SCENARIO, holding(SCENARIO), weak)
    edge, x = true_rest(made.last)
    assert made.outcome in (ELSEWHERE, UNKNOWN) and made.claim.edge in (-1, edge)
    assert made.outcome == UNKNOWN or made.claim.x == pytest.approx(x, abs=2e-3)
