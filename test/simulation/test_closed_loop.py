"""The closed loop without ROS: tracking, determinism, the judgement of its end."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from problems import LEANING

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.mechanics.contacts import start_configuration
from wholearm_ros.model.backends import installed_backends
from wholearm_ros.model.goal import ANGLE_TOLERANCE
from wholearm_ros.model.hand import SIDES
from wholearm_ros.model.modes import DONE, QUASI_STATIC, STOPPED
from wholearm_ros.model.orientation import goal_rotation
from wholearm_ros.model.perturbation import NOMINAL, Perturbation, draw_perturbation
from wholearm_ros.model.scenario import GoalAtPose, GoalOnEdge
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory, Segment
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.simulation.closed_loop import LoopOptions, finished, run
from wholearm_ros.simulation.outcome import outcome, palm_gap

SCENARIO = load_scenario(Path(__file__).parents[2] / 'config' / 'asymmetric_hexagon.yaml')
Q = start_configuration(SCENARIO)
EACH = pytest.mark.parametrize('backend', installed_backends())


def push(turn=-0.15, seconds=1.0) -> ManipulationTrajectory:
    """The left finger turns by `turn`, the right one presses with 1 N m."""
    t = np.linspace(0.0, seconds, int(seconds * 1000) + 1)
    u = t / seconds
    shape = u**3 * (10 - 15 * u + 6 * u * u)
    angles = np.stack([Q[3] + turn * shape, np.full_like(t, Q[4])], axis=1)
    efforts = np.tile([-1.2, 1.0], (len(t), 1))
    return ManipulationTrajectory(
        'push',
        0.001,
        angles,
        np.gradient(angles, t, axis=0),
        efforts,
        np.full((len(t), 2), np.nan),
        np.zeros((len(t), 3)),
        (Segment(0.0, seconds, QUASI_STATIC, 0),),
    )


@EACH
def test_the_velocity_finger_tracks_and_the_end_is_held(backend):
    record = run(SCENARIO, push(), backend=backend)
    assert finished(record) and record.modes[-1] == DONE and record.reason == ''
    assert np.abs(record.angles[300:1300, 0] - push().angles[:1000, 0]).max() < 0.03
    np.testing.assert_allclose(record.efforts[400:, 1], 1.0)
    assert record.time_in_modes()[QUASI_STATIC] == pytest.approx(1.3, abs=0.005)
    assert len(record.times) == len(record.poses) == len(record.modes) == 1800


@EACH
@pytest.mark.parametrize('level', [0.0, 1.0])
def test_the_same_run_twice_is_the_same(backend, level):
    records = []
    for _ in range(2):
        perturbation = draw_perturbation(np.random.default_rng(3), level, SCENARIO)
        records.append(run(SCENARIO, push(seconds=0.3), backend, perturbation.reseeded(5)))
    for name in ('angles', 'velocities', 'efforts', 'poses'):
        np.testing.assert_allclose(
            getattr(records[0], name), getattr(records[1], name), rtol=0.0, atol=1e-12
        )


def test_the_seed_changes_the_noise_only_when_there_is_noise():
    noisy = Perturbation(encoder_noise=2e-4, velocity_noise=0.02)
    for perturbation, same in ((NOMINAL, True), (noisy, False)):
        a, b = (
            run(SCENARIO, push(seconds=0.1), perturbation=perturbation.reseeded(s)).poses[-1]
            for s in (1, 2)
        )
        assert np.array_equal(a, b) == same


def test_both_stand_ins_agree_over_a_push():
    """Another engine, another contact model: within 1 mm on the way, 0.1 mm and 1 mrad at the end."""
    pytest.importorskip('pybullet')
    a, b = (run(SCENARIO, push(-0.05), backend=b) for b in ('pybullet', 'planar'))
    assert np.abs(a.poses[:, :2] - b.poses[:, :2]).max() < 1e-3
    np.testing.assert_allclose(a.poses[-1], b.poses[-1], atol=1e-4, rtol=0.0)
    np.testing.assert_allclose(a.efforts[-1], b.efforts[-1], atol=2e-2, rtol=0.0)


def test_a_finger_that_is_blocked_stops_the_run_with_the_reason():
    record = run(
        SCENARIO, push(), loop=LoopOptions(controls=ControlOptions(max_tracking_error=0.005))
    )
    assert (
        record.modes[-1] == STOPPED and 'tracking error' in record.reason and not finished(record)
    )
    assert outcome(SCENARIO, record).reason.startswith('stopped: tracking error')
    assert np.abs(record.efforts[-1]).max() < 1.0


def at_end(scenario, pose, speed=0.0):
    """A record whose end is as given."""
    record = run(SCENARIO, push(seconds=0.1), loop=LoopOptions(settle=0.1))
    poses = np.tile(np.asarray(pose, dtype=float), (len(record.times), 1))
    poses[:, 0] += speed * (record.times - record.times[-1])
    return replace(record, poses=poses, truth=scenario)


def resting(scenario, turn=0.0, x=0.0, lift=0.0):
    angle = goal_rotation(scenario) + turn
    pose = np.array([x, 0.0, angle])
    return pose + [0.0, lift - palm_gap(scenario, pose), 0.0]


@pytest.mark.parametrize(
    'end, words',
    [
        (dict(), ''),
        (dict(turn=0.029), ''),
        (dict(turn=ANGLE_TOLERANCE + 1e-3), 'rotation'),
        (dict(turn=2 * np.pi), 'rotation'),
        (dict(turn=-0.04), 'rotation'),
        (dict(lift=0.002), 'above the palm'),
        (dict(lift=0.001), ''),
        (dict(x=0.1), ''),
    ],
)
def test_only_rest_on_the_goal_edge_counts(end, words):
    judged = outcome(SCENARIO, at_end(SCENARIO, resting(SCENARIO, **end)))
    assert judged.executed == (words == '') and words in judged.reason


def test_an_object_that_still_moves_has_not_arrived():
    assert (
        'still moves' in outcome(SCENARIO, at_end(SCENARIO, resting(SCENARIO), speed=0.05)).reason
    )
    assert outcome(SCENARIO, at_end(SCENARIO, resting(SCENARIO), speed=0.002)).executed


def test_an_object_recorded_rarely_is_judged_by_its_last_two_records():
    """With one record in the last tenth of a second the speed was 0/0, and that counted as at rest."""
    record = at_end(SCENARIO, resting(SCENARIO), speed=0.05)
    rare = [0, len(record.times) - 1]
    moving = replace(record, times=record.times[rare], poses=record.poses[rare])
    assert 'still moves' in outcome(SCENARIO, moving).reason
    alone = replace(record, times=record.times[-1:], poses=record.poses[-1:])
    assert 'still moves' in outcome(SCENARIO, alone).reason


def test_a_goal_with_x_and_a_goal_at_a_pose_are_held_to_their_tolerances():
    there = replace(SCENARIO, goal=GoalOnEdge(5, 'ccw', x=0.0, x_tolerance=0.004))
    assert outcome(there, at_end(there, resting(there, x=0.003))).executed
    assert 'x is off' in outcome(there, at_end(there, resting(there, x=0.005))).reason
    pose = resting(SCENARIO, x=0.01)
    at_pose = replace(SCENARIO, goal=GoalAtPose(pose, [0.001, 0.001, 0.01]))
    assert outcome(at_pose, at_end(at_pose, pose)).executed
    assert 'x is off by +0.0020' in outcome(at_pose, at_end(at_pose, pose + [0.002, 0, 0])).reason


def test_contacts_in_pybullet_carry_the_normals_of_where_they_are(monkeypatch):
    """Of the palm, a finger or an edge of the object that leans on it, never the one of a while ago: as the finger turns under
    a vertex that stays, a contact kept from before would push 0.1 rad off."""
    pybullet_hand = pytest.importorskip(
        'wholearm_ros.simulation.pybullet_hand', exc_type=ImportError
    )
    edges, away = LEANING.object.polygon.edges, []
    inward = np.column_stack([-edges[:, 1], edges[:, 0]]) / np.linalg.norm(edges, axis=1)[:, None]

    class Watched(pybullet_hand.PyBulletHand):
        def step(self, efforts):
            super().step(efforts)
            (c, s), (left, right) = (
                [f(self.object_pose()[2]) for f in (np.cos, np.sin)],
                self.joints()[0],
            )
            features = {
                'palm': [0.0, 1.0],
                'left': [np.sin(left), -np.cos(left)],
                'right': [-np.sin(right), np.cos(right)],
            }
            turned = inward @ np.array([[c, s], [-s, c]])
            for point in self._bullet.getContactPoints(bodyA=self._object):
                other, normal, force = (
                    point[2],
                    np.array(point[7])[[0, 2]],
                    point[9] / pybullet_hand.SCALE,
                )
                if force > 1.0:
                    feature = features[SIDES[point[4]] if other == self._fingers else 'palm']
                    away.append(np.linalg.norm(np.vstack([turned, feature]) - normal, axis=1).min())

    offered = plan_and_verify(LEANING, PlanRequest(candidates=40, certificate_samples=0))
    monkeypatch.setattr(pybullet_hand, 'PyBulletHand', Watched)
    assert outcome(LEANING, run(LEANING, offered.trajectory, 'pybullet')).executed
    assert len(away) > 5000 and np.quantile(away, 0.99) < 0.004 and max(away) < 0.02
