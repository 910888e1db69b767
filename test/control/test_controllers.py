"""The two controllers: their formulas, limits, and what they do with readings that are not numbers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wholearm_ros.control.open_loop_torque import torque_effort
from wholearm_ros.control.pd_velocity import velocity_effort
from wholearm_ros.control.setpoints import ControlOptions, PdGains, TorqueSetpoint, VelocitySetpoint
from wholearm_ros.model.finger_shape import Rectangle
from wholearm_ros.model.hand import LEFT, RIGHT, Finger

FINGER = Finger((0.0, 0.0), Rectangle(0.15, 0.006), 0.16, 0.005, (0.05, 3.09), 7.0)
GAINS = PdGains(30.0, 0.85)
number = st.floats(-100.0, 100.0)


@given(
    angle=st.floats(-0.1, 0.1),
    velocity=st.floats(-1.0, 1.0),
    wanted=st.floats(-0.1, 0.1),
    speed=st.floats(-1.0, 1.0),
    feedforward=st.floats(-1.0, 1.0),
)
def test_pd_is_linear_inside_the_limit_and_zero_error_gives_the_feedforward(
    angle, velocity, wanted, speed, feedforward
):
    got = velocity_effort(
        GAINS, FINGER, VelocitySetpoint(LEFT, wanted, speed, feedforward), angle, velocity
    )
    raw = feedforward + 30.0 * (wanted - angle) + 0.85 * (speed - velocity)
    assert got == pytest.approx(np.clip(raw, -7.0, 7.0))
    at_rest = velocity_effort(
        GAINS, FINGER, VelocitySetpoint(LEFT, angle, velocity, feedforward), angle, velocity
    )
    assert at_rest == feedforward


@given(number, number, number, number, number)
def test_no_effort_beyond_the_motor(a, b, c, d, e):
    assert abs(velocity_effort(GAINS, FINGER, VelocitySetpoint(RIGHT, a, b, c), d, e)) <= 7.0
    assert abs(torque_effort(FINGER, TorqueSetpoint(RIGHT, a), b, 60.0, 0.001)) <= 7.0


@pytest.mark.parametrize('bad', [float('nan'), float('inf')])
def test_a_reading_that_is_no_number_gives_no_effort(bad):
    assert velocity_effort(GAINS, FINGER, VelocitySetpoint(LEFT, 1.0, 0.0, 3.0), bad, 0.0) == 0.0
    assert velocity_effort(GAINS, FINGER, VelocitySetpoint(LEFT, 1.0, 0.0, 3.0), 1.0, bad) == 0.0
    assert torque_effort(FINGER, TorqueSetpoint(LEFT, bad), 1.5, 60.0, 0.001) == 1.5


@given(
    wanted=st.floats(-20.0, 20.0),
    previous=st.floats(-7.0, 7.0),
    slew=st.floats(20.0, 500.0),
    dt=st.floats(1e-3, 0.01),
)
@settings(deadline=None)
def test_torque_goes_to_its_setpoint_no_faster_than_allowed_and_gets_there(
    wanted, previous, slew, dt
):
    effort = torque_effort(FINGER, TorqueSetpoint(LEFT, wanted), previous, slew, dt)
    assert abs(effort - previous) <= slew * dt + 1e-12
    for _ in range(int(14.0 / (slew * dt)) + 2):
        effort = torque_effort(FINGER, TorqueSetpoint(LEFT, wanted), effort, slew, dt)
    assert effort == pytest.approx(np.clip(wanted, -7.0, 7.0))


def phase_margin(gains: PdGains, inertia: float, delay: float) -> float:
    """[deg] of (kp + kd s) exp(-delay s) / (inertia s²)."""
    w = np.linspace(1.0, 3000.0, 300000)
    loop = np.hypot(gains.kp, gains.kd * w) / (inertia * w * w)
    crossing = w[np.argmax(loop < 1.0)]
    return float(np.degrees(np.arctan2(gains.kd * crossing, gains.kp) - crossing * delay))


def test_default_gains_are_stable_with_every_delay_that_is_drawn():
    """Half a period of the hold at 1 kHz, and 0 to 6 ms of actuation delay."""
    gains = ControlOptions().gains
    margins = [phase_margin(gains, FINGER.inertia, 0.0005 + d) for d in (0.0, 0.003, 0.006)]
    assert margins[0] > 60.0 and margins[1] > 40.0 and margins[2] > 20.0
    assert (
        phase_margin(PdGains(300.0, 6.0), FINGER.inertia, 0.0035) < 0.0
    )  # why the gains are not higher


@pytest.mark.parametrize('delay', [0, 3, 6])
@pytest.mark.parametrize('noise', [0.0, 1.0])
def test_the_finger_comes_to_rest_at_its_setpoint_with_delay_and_noise(delay, noise):
    rng, dt, gains = np.random.default_rng(1), 0.001, ControlOptions().gains
    angle, velocity, pipe, errors = 0.05, 0.0, [0.0] * delay, []
    for k in range(2000):
        read = (
            angle + noise * 4e-4 * rng.standard_normal(),
            velocity + noise * 0.04 * rng.standard_normal(),
        )
        pipe.append(velocity_effort(gains, FINGER, VelocitySetpoint(LEFT, 0.0, 0.0, 0.0), *read))
        velocity += dt * pipe.pop(0) / FINGER.inertia
        angle += dt * velocity
        errors.append(abs(angle))
    assert max(errors[1000:]) < (3e-3 if noise else 1e-4)
