"""The mode switch: idle, the trajectory's modes, done; and stopped, with the reason, on every fault."""

from dataclasses import replace

import numpy as np
import pytest

from wholearm_ros.control.mode_switch import ModeSwitch
from wholearm_ros.control.setpoints import ControlOptions, Joints
from wholearm_ros.model.hand import LEFT, RIGHT
from wholearm_ros.model.modes import CAGING, DONE, IDLE, QUASI_STATIC, STOPPED
from wholearm_ros.model.trajectory import ManipulationTrajectory, Segment

OPTIONS = ControlOptions(ramp=0.2, handover=0.1)
DT = 0.001


def trajectory() -> ManipulationTrajectory:
    """Left velocity-controlled for half a second, then right, for half a second each."""
    t = np.linspace(0.0, 1.0, 1001)
    u = t**3 * (10 - 15 * t + 6 * t * t)
    angles = np.stack([2.0 - 0.3 * u, 1.0 + 0.2 * u], axis=1)
    velocities = np.gradient(angles, t, axis=0)
    efforts = np.stack([-1.0 - t, 2.0 + t], axis=1)
    segments = (Segment(0.0, 0.5, QUASI_STATIC, LEFT), Segment(0.5, 1.0, CAGING, RIGHT))
    return ManipulationTrajectory(
        'plan',
        DT,
        angles,
        velocities,
        efforts,
        np.full((1001, 2), np.nan),
        np.zeros((1001, 3)),
        segments,
    )


def follow(switch, seconds, offset=0.0, state=None, start=0.0, efforts=(0.3, -0.2)):
    """Steps with joints that are where the plan wants them (plus offset); all (time, state, motion, torque)."""
    state, steps = state or switch.initial(), []
    for k in range(int(round(seconds / DT))):
        now = start + k * DT
        elapsed = now - (state.began if state.began is not None else now) - OPTIONS.ramp
        joints = Joints(
            now, switch.trajectory.sample(elapsed).angles + offset, np.zeros(2), np.array(efforts)
        )
        state, motion, torque = switch.step(state, now, joints)
        steps.append((now, state, motion, torque))
    return steps


def test_modes_follow_the_trajectory_and_the_end_is_held():
    switch = ModeSwitch(trajectory(), OPTIONS)
    assert switch.initial().mode == IDLE
    steps = follow(switch, 2.0, start=5.0)
    modes = [s.mode for _, s, _, _ in steps]
    assert list(dict.fromkeys(modes)) == [QUASI_STATIC, CAGING, DONE]
    assert modes.count(QUASI_STATIC) * DT == pytest.approx(OPTIONS.ramp + 0.5, abs=2 * DT)
    assert modes.count(CAGING) * DT == pytest.approx(0.5, abs=2 * DT)
    _, state, motion, torque = steps[-1]
    assert (motion.joint, motion.angle, motion.velocity) == (RIGHT, pytest.approx(1.2), 0.0)
    assert (torque.joint, torque.effort) == (LEFT, pytest.approx(-2.0)) and state.progress == 1.0


def test_setpoints_are_the_plans_once_ramped_in():
    switch = ModeSwitch(trajectory(), OPTIONS)
    for now, state, motion, torque in follow(switch, 1.1)[210:]:
        sample = switch.trajectory.sample(now - OPTIONS.ramp)
        assert motion.angle == pytest.approx(sample.angles[motion.joint], abs=1e-12)
        assert motion.velocity == pytest.approx(sample.velocities[motion.joint], abs=1e-12)
        assert motion.feedforward == pytest.approx(sample.efforts[motion.joint])
        assert (
            torque.effort == pytest.approx(sample.efforts[torque.joint])
            and torque.joint == 1 - motion.joint
        )


def test_efforts_begin_where_they_were_found_and_never_jump():
    steps = follow(ModeSwitch(trajectory(), OPTIONS), 1.5)
    efforts = np.array(
        [
            [t.effort, m.feedforward] if m.joint == RIGHT else [m.feedforward, t.effort]
            for _, _, m, t in steps
        ]
    )
    np.testing.assert_allclose(efforts[0], [0.3, -0.2])
    assert np.abs(np.diff(efforts, axis=0)).max() < OPTIONS.slew_limit * DT


@pytest.mark.parametrize('offset', [0.02, -0.03])
def test_a_finger_found_beside_the_plan_is_led_to_it_without_a_jump(offset):
    steps = follow(ModeSwitch(trajectory(), OPTIONS), 1.5, offset=offset)
    _, _, motion, _ = steps[0]
    assert motion.angle == pytest.approx(2.0 + offset) and motion.velocity == pytest.approx(0.0)
    for joint in (LEFT, RIGHT):
        angles = np.array([m.angle for _, _, m, _ in steps if m.joint == joint])
        velocities = np.array([m.velocity for _, _, m, _ in steps if m.joint == joint])
        np.testing.assert_allclose(
            np.diff(angles) / DT, 0.5 * (velocities[1:] + velocities[:-1]), atol=2e-2
        )
    assert steps[-1][2].angle == pytest.approx(1.2)


def fault(joints: Joints, at=0.3):
    switch = ModeSwitch(trajectory(), OPTIONS)
    _, state, _, _ = follow(switch, at)[-1]
    return switch, switch.step(state, at, joints)


def good(at=0.3) -> Joints:
    return Joints(at, trajectory().sample(at - OPTIONS.ramp).angles, np.zeros(2))


@pytest.mark.parametrize(
    'joints, words',
    [
        (replace(good(), stamp=0.15), 'old'),
        (replace(good(), angles=np.array([np.nan, 1.0])), 'not finite'),
        (replace(good(), velocities=np.array([0.0, np.inf])), 'not finite'),
        (replace(good(), angles=good().angles + [0.3, 0.0]), 'tracking error'),
        (replace(good(), angles=good().angles - [0.3, 0.0]), 'tracking error'),
    ],
)
def test_a_fault_stops_with_its_reason_and_stays_stopped(joints, words):
    switch, (state, motion, torque) = fault(joints)
    assert state.mode == STOPPED and words in state.reason
    assert (motion.velocity, motion.feedforward, torque.effort) == (0.0, 0.0, 0.0) and np.isfinite(
        motion.angle
    )
    again, later, _ = switch.step(state, 0.4, good(0.4))
    assert (again.mode, again.reason, later.angle) == (STOPPED, state.reason, motion.angle)


def test_the_torque_finger_may_be_anywhere():
    _, (state, _, _) = fault(replace(good(), angles=good().angles + [0.0, 0.5]))
    assert state.mode == QUASI_STATIC


def test_stop_on_request_holds_the_velocity_finger_where_it_is():
    switch = ModeSwitch(trajectory(), OPTIONS)
    _, state, _, _ = follow(switch, 0.4)[-1]
    stopped = switch.stop(state, good(0.4), 'asked to stop')
    _, motion, torque = switch.step(stopped, 0.41, good(0.41))
    assert (stopped.mode, stopped.reason) == (STOPPED, 'asked to stop')
    assert motion.angle == good(0.4).angles[LEFT] and torque.effort == 0.0


def test_a_step_is_pure():
    switch = ModeSwitch(trajectory(), OPTIONS)
    _, state, _, _ = follow(switch, 0.3)[-1]
    first, second = switch.step(state, 0.3, good()), switch.step(state, 0.3, good())
    assert first[1:] == second[1:] and first[0].elapsed == second[0].elapsed
