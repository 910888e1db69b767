"""The simulated hands obey mechanics: free motion, statics, contacts at the true faces, energy, agreement with each other."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wholearm_ros.errors import HardwareError
from wholearm_ros.mechanics.contacts import gap_table, pose_on_palm, start_configuration
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.backends import BACKENDS, DEFAULT_BACKEND, installed_backends
from wholearm_ros.model.hand import Palm
from wholearm_ros.model.hand_errors import HandErrors
from wholearm_ros.model.perturbation import Perturbation
from wholearm_ros.model.scenario import ManipulatedObject, StartOnEdge
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.simulation.factory import make_hand

CONFIG = Path(__file__).parents[2] / 'config'
SCENARIO = load_scenario(CONFIG / 'asymmetric_hexagon.yaml')
Q = start_configuration(SCENARIO)
G = SCENARIO.gravity.in_plane
WEIGHTS = np.array(
    [f.mass * G * f.shape.length / 2 for f in (SCENARIO.hand.left, SCENARIO.hand.right)]
)
EACH = pytest.mark.parametrize('backend', BACKENDS)
WITH_FORCES = pytest.mark.parametrize('backend', ['pybullet', 'mujoco'])  # told by `contacts()`
FAR = np.array([0.0, 5.0, 0.4, 1.2, 1.9])  # the object out of reach


@pytest.fixture
def hand(request):
    made = []

    def make(backend=DEFAULT_BACKEND, scenario=SCENARIO, q=Q, **options):
        if backend not in installed_backends():
            pytest.skip(f'{backend} is not installed')
        made.append(make_hand(backend, scenario, **options))
        made[-1].reset(q)
        return made[-1]

    yield make
    for one in made:
        one.disconnect()


def energy(hand) -> float:
    """Kinetic and potential [J] of the object and both fingers, rotors included."""
    s, pose, v = hand.scenario, hand.object_pose(), hand.object_velocity()
    angles, rates = hand.joints()
    kinetic = (
        s.object.mass * (v[:2] @ v[:2])
        + s.object.inertia * v[2] ** 2
        + sum(f.inertia * r * r for f, r in zip((s.hand.left, s.hand.right), rates))
    ) / 2
    return kinetic + s.object.mass * G * pose[1] + WEIGHTS @ np.sin(angles)


def held_against(hand, right_torque: float, seconds: float = 2.0):
    """Left finger held by a stiff PD, right finger pushing with a torque, weights compensated; to rest."""
    for k in range(int(seconds / hand.period)):
        angles, rates = hand.joints()
        ramp = min(1.0, k * hand.period / 0.5)
        hand.step(
            WEIGHTS * np.cos(angles)
            + [60.0 * (Q[3] - angles[0]) - 1.5 * rates[0], ramp * right_torque]
        )


# ---------------------------------------------------------------------- free motion
@EACH
@pytest.mark.parametrize('efforts', [(0.0, 0.0), (0.3, -0.2)])
def test_a_free_finger_accelerates_by_its_inertia_rotor_included(hand, backend, efforts):
    h = hand(backend, q=FAR)
    h.step(np.array(efforts))
    inertia = np.array([SCENARIO.hand.left.inertia, SCENARIO.hand.right.inertia])
    expected = (np.array(efforts) - WEIGHTS * np.cos(FAR[3:])) / inertia
    np.testing.assert_allclose(h.joints()[1] / h.period, expected, rtol=1e-5)


@EACH
def test_a_free_object_falls_and_does_not_turn(hand, backend):
    h = hand(backend, q=FAR)
    for _ in range(300):
        h.step(None)
    pose, velocity = h.object_pose(), h.object_velocity()
    np.testing.assert_allclose(velocity, [0.0, -0.3 * G, 0.0], atol=1e-9)
    np.testing.assert_allclose(pose, [0.0, 5.0 - 0.045 * G, 0.4], atol=2e-3)


@WITH_FORCES
def test_fingers_stop_at_their_limits(hand, backend):
    h = hand(backend, q=np.array([0.0, 5.0, 0.0, 0.3, 2.8]))
    for _ in range(1500):
        h.step(np.array([-1.0, 1.0]))
    np.testing.assert_allclose(h.joints()[0], [0.05, 3.09], atol=1e-4)


@EACH
def test_torques_are_clipped_to_the_motors(hand, backend):
    a, b = hand(backend, q=FAR), hand(backend, q=FAR)
    a.step(np.array([50.0, -50.0]))
    b.step(np.array([7.0, -7.0]))
    np.testing.assert_array_equal(a.joints()[1], b.joints()[1])
    np.testing.assert_array_equal(a.efforts(), [7.0, -7.0])


# ---------------------------------------------------------------------- statics
@EACH
def test_an_object_at_rest_on_the_palm_stays(hand, backend):
    h = hand(backend, q=np.array([*Q[:3], 3.0, 0.1]))
    for _ in range(1000):
        h.step(None)
    np.testing.assert_allclose(h.object_pose(), Q[:3], atol=5e-6)
    np.testing.assert_allclose(h.object_velocity(), 0.0, atol=1e-6)


@WITH_FORCES
def test_the_palm_carries_the_weight(hand, backend):
    h = hand(backend, q=np.array([*Q[:3], 3.0, 0.1]))
    for _ in range(300):
        h.step(None)
    forces = [c.force * c.normal for c in h.contacts() if c.other == 'palm']
    np.testing.assert_allclose(np.sum(forces, axis=0), [0.0, SCENARIO.object.mass * G], atol=1e-6)


@WITH_FORCES
@pytest.mark.parametrize('torque', [0.3, 1.0, 3.0])
def test_contact_forces_balance_the_object_and_the_torque_finger(hand, backend, torque):
    h = hand(backend)
    held_against(h, torque)
    pose, contacts = h.object_pose(), h.contacts()
    force = sum(c.force * c.normal for c in contacts)
    moment = sum(_cross(c.point - pose[:2], c.force * c.normal) for c in contacts)
    on_finger = sum(
        -_cross(c.point - SCENARIO.hand.right.axis, c.force * c.normal)
        for c in contacts
        if c.other == 'right'
    )
    np.testing.assert_allclose(force, [0.0, SCENARIO.object.mass * G], atol=1e-5)
    assert moment == pytest.approx(0.0, abs=1e-6)
    assert on_finger == pytest.approx(-torque, abs=1e-5)
    assert all(c.force >= 0.0 for c in contacts) and {c.other for c in contacts} >= {
        'left',
        'right',
    }


@EACH
def test_contacts_happen_at_the_true_faces(hand, backend):
    """Gaps of the exact polygons when pressed together: within 0.03 mm."""
    h = hand(backend)
    held_against(h, 2.0)
    gaps, _ = gap_table(build_world(SCENARIO), np.concatenate([h.object_pose(), h.joints()[0]]))
    assert -3e-5 < np.sort(gaps)[0] and np.sort(gaps)[3] < 3e-5


def test_every_stand_in_comes_to_the_same_rest(hand):
    ends = []
    for backend in installed_backends():
        h = hand(backend)
        held_against(h, 2.0)
        ends.append(np.concatenate([h.object_pose(), h.joints()[0]]))
    np.testing.assert_allclose(ends, np.tile(ends[-1], (len(ends), 1)), atol=5e-4)


# ---------------------------------------------------------------------- energy
@EACH
@pytest.mark.parametrize('turn', [0.1, 0.7])
def test_a_dropped_object_never_gains_energy(hand, backend, turn):
    """From 3 cm up; an impact may not give back more than 0.3 mJ for the penetration it resolves, of 100 mJ."""
    h = hand(backend, q=np.array([-0.02, Q[1] + 0.03, turn, 3.0, 0.1]))
    levels = [energy(h)]
    for _ in range(1500):
        h.step(None)
        levels.append(energy(h))
    levels = np.array(levels)
    assert np.diff(levels).max() < 3e-4 and levels.max() < levels[0] + 1e-4
    assert levels[-1] < levels[0] - 0.05


@EACH
def test_fingers_do_work_and_nothing_else_does(hand, backend):
    """Energy minus the motors' work never grows while a finger pushes the object along."""
    h = hand(backend)
    balance, work, held = [], 0.0, Q[3:].copy()
    for k in range(1500):
        t = k * h.period
        angles, rates = h.joints()
        target = held[0] - 0.2 * np.clip(t - 0.3, 0.0, 1.0)
        ramp = min(1.0, t / 0.3)
        efforts = WEIGHTS * np.cos(angles) + [
            60.0 * (target - angles[0]) - 1.5 * rates[0] - ramp,
            ramp * 0.8,
        ]
        h.step(efforts)
        work += efforts @ (h.joints()[0] - angles)
        balance.append(energy(h) - work)
    balance = np.array(balance)
    assert np.diff(balance).max() < 5e-4
    assert balance[-1] < balance[0] + 1e-4


# ---------------------------------------------------------------------- perturbations, rates, errors
@EACH
def test_delay_holds_the_command_back_by_its_time(hand, backend):
    h = hand(backend, q=FAR, perturbation=Perturbation(actuation_delay=0.003))
    speeds = []
    for _ in range(5):
        h.step(np.array([1.0, 1.0]))
        speeds.append(np.abs(h.joints()[1]).max())
    assert max(speeds[:3]) < 1e-6 < 1e-2 < speeds[3]


def test_a_delayed_command_stays_what_it_was_while_its_array_is_used_again(hand):
    h = hand('planar', q=FAR, perturbation=Perturbation(actuation_delay=0.003))
    told, rates = np.zeros(2), []
    for torque in (1.0, -1.0, -1.0, -1.0):
        told[:] = torque
        h.step(told)
        rates.append(h.joints()[1][0])
    assert rates[3] > 1e-2


@EACH
def test_fingers_that_are_held_go_on_bearing_what_they_bore(hand, backend):
    """The last command squeezed the object by 3 N m: neither finger gives way when commands cease."""
    h = hand(backend)
    held_against(h, 3.0)
    angles, pose = h.joints()[0].copy(), h.object_pose()
    for _ in range(300):
        h.step(None)
    np.testing.assert_allclose(h.joints()[0], angles, atol=1e-3)
    np.testing.assert_allclose(h.object_pose(), pose, atol=1e-3)


@EACH
@pytest.mark.parametrize('friction', [0.0, 0.05])
def test_an_object_slides_down_a_sloping_palm_as_friction_lets_it(hand, backend, friction):
    slope = np.radians(10.0)
    palm = Palm([[-0.15, 0.15 * np.tan(slope)], [0.15, -0.15 * np.tan(slope)]])
    scenario = replace(SCENARIO, palm=palm, start=StartOnEdge(0, 0.0))
    pose = pose_on_palm(build_world(scenario), 0.0, -slope)
    h = hand(
        backend,
        scenario=scenario,
        q=np.array([*pose, 3.0, 0.1]),
        perturbation=Perturbation(friction=friction),
    )
    for _ in range(200):
        h.step(None)
    down = 0.2 * G * (np.sin(slope) - friction * np.cos(slope))
    np.testing.assert_allclose(
        h.object_velocity()[:2], [down * np.cos(slope), -down * np.sin(slope)], atol=2e-3
    )
    assert abs(h.object_pose()[2] + slope) < 1e-4


@EACH
def test_mass_and_shape_are_the_true_ones_and_the_noise_is_as_asked(hand, backend):
    offsets = np.full((6, 2), 2e-4) * [[1, 0], [1, 0], [0, 1], [0, 1], [-1, 0], [-1, 0]]
    p = Perturbation(
        mass_factor=1.04,
        vertex_offsets=offsets,
        encoder_noise=2e-4,
        velocity_noise=0.02,
        noise_seed=5,
    )
    h = hand(backend, q=FAR, perturbation=p)
    assert h.scenario.object.mass == pytest.approx(1.04 * SCENARIO.object.mass)
    np.testing.assert_allclose(
        h.scenario.object.polygon.vertices, SCENARIO.object.polygon.vertices + offsets
    )
    readings = []
    for _ in range(1000):
        h.step(None)
        readings.append(np.concatenate(h.joints()))
    spread = np.std(readings, axis=0)
    np.testing.assert_allclose(spread, [2e-4, 2e-4, 0.02, 0.02], rtol=0.15)


def with_hand(**errors):
    """A perturbation of the hand alone."""
    return Perturbation(hand=HandErrors(**errors))


@EACH
def test_friction_of_a_joint_slows_it_down_and_holds_it(hand, backend):
    """Coulomb's law, without a contact: ω falls by friction over inertia, and what is less does not move it."""
    friction, coasting = np.array([0.02, 0.01]), 100
    h = hand(backend, q=FAR, perturbation=with_hand(joint_friction=friction))
    inertias = np.array([f.inertia for f in (SCENARIO.hand.left, SCENARIO.hand.right)])
    for _ in range(50):
        h.step(WEIGHTS * np.cos(h.joints()[0]) + [-0.1, 0.1])
    before = h.joints()[1]
    for _ in range(coasting):
        h.step(WEIGHTS * np.cos(h.joints()[0]))
    lost = np.abs(before) - np.abs(h.joints()[1])
    np.testing.assert_allclose(lost, coasting * h.period * friction / inertias, rtol=0.03)
    h.reset(FAR)
    for _ in range(500):
        h.step(WEIGHTS * np.cos(h.joints()[0]) + 0.9 * friction)
    np.testing.assert_allclose(h.joints()[0], FAR[3:], atol=1e-4)


@EACH
def test_an_object_does_not_push_a_finger_that_friction_holds(hand, backend):
    """The left one's torque presses the object on the right one, whose joint resists more than that asks for."""
    h = hand(backend, perturbation=with_hand(joint_friction=[0.0, 0.3]))
    for k in range(1000):
        pressing = min(1.0, k / 500) * np.array([-0.1, 0.0])
        h.step(WEIGHTS * np.cos(h.joints()[0]) + pressing)
    np.testing.assert_allclose(h.joints()[0], Q[3:], atol=2e-3)
    np.testing.assert_allclose(h.object_pose(), Q[:3], atol=2e-3)


@EACH
def test_gravity_pulls_where_it_is_turned_to(hand, backend):
    turn = 0.02
    h = hand(backend, q=FAR, perturbation=with_hand(gravity_turn=turn))
    held = WEIGHTS * np.cos(FAR[3:] - turn)
    for _ in range(100):
        h.step(held)
    fallen = h.time * G
    np.testing.assert_allclose(
        h.object_velocity()[:2],
        [fallen * np.sin(turn), -fallen * np.cos(turn)],
        rtol=0.02,
    )
    np.testing.assert_allclose(h.joints()[0], FAR[3:], atol=1e-4)


@EACH
def test_axes_zeros_and_start_are_the_true_ones(hand, backend):
    zeros, axes = np.array([2e-3, -1e-3]), np.array([[3e-4, 0.0], [0.0, -2e-4]])
    p = with_hand(encoder_zeros=zeros, axis_offsets=axes, start_x=1e-3)
    h = hand(backend, q=FAR, perturbation=p)
    np.testing.assert_allclose(h.joints()[0], FAR[3:] + zeros, atol=1e-7)
    for side in range(2):
        told, true = SCENARIO.hand[side], h.scenario.hand[side]
        np.testing.assert_allclose(true.axis - told.axis, axes[side], atol=1e-12)
    assert h.scenario.start.x == pytest.approx(SCENARIO.start.x + 1e-3)


@EACH
@pytest.mark.parametrize('rate', [250.0, 500.0])
def test_a_slower_rate_keeps_time_and_place(hand, backend, rate):
    slow, fast = hand(backend, q=FAR, rate=rate), hand(backend, q=FAR)
    for _ in range(int(0.2 * rate)):
        slow.step(np.array([0.3, -0.2]))
    for _ in range(200):
        fast.step(np.array([0.3, -0.2]))
    assert slow.time == pytest.approx(fast.time) == pytest.approx(0.2)
    np.testing.assert_allclose(slow.joints()[0], fast.joints()[0], atol=1e-6)


@EACH
def test_a_reset_hand_repeats_itself_exactly(hand, backend):
    h, ends = hand(backend, perturbation=Perturbation(encoder_noise=2e-4, velocity_noise=0.02)), []
    for _ in range(2):
        h.reset(Q)
        held_against(h, 1.0, 0.5)
        ends.append(np.concatenate([h.object_pose(), *h.joints()]))
    np.testing.assert_allclose(ends[0], ends[1], rtol=0.0, atol=1e-12)


@EACH
def test_a_mirrored_scenario_moves_mirrored(hand, backend):
    polygon = SCENARIO.object.polygon.mirrored()
    mirrored = replace(
        SCENARIO,
        object=ManipulatedObject(polygon, SCENARIO.object.mass),
        hand=SCENARIO.hand.mirrored(),
        palm=SCENARIO.palm.mirrored(),
        start=StartOnEdge(5, 0.02),
    )
    a = hand(backend)
    b = hand(backend, scenario=mirrored, q=np.array([-Q[0], Q[1], 0.0, np.pi - Q[4], np.pi - Q[3]]))
    for k in range(400):
        efforts = np.array([-0.2, 0.1]) * min(1.0, k / 200)
        a.step(WEIGHTS * np.cos(a.joints()[0]) + efforts)
        b.step(WEIGHTS * np.cos(b.joints()[0]) - efforts[::-1])
    np.testing.assert_allclose(a.object_pose() * [-1, 1, -1], b.object_pose(), atol=1e-4)
    np.testing.assert_allclose(np.pi - a.joints()[0][::-1], b.joints()[0], atol=1e-3)


def test_bad_efforts_and_unknown_backends_are_refused(hand):
    h = hand()
    for bad in (np.array([np.nan, 0.0]), np.zeros(3)):
        with pytest.raises(HardwareError, match='two finite numbers'):
            h.step(bad)
    with pytest.raises(HardwareError, match='allowed: pybullet, mujoco, planar'):
        make_hand('gazebo', SCENARIO)


def test_a_window_without_a_screen_is_refused(monkeypatch):
    pytest.importorskip('pybullet')
    monkeypatch.delenv('DISPLAY', raising=False)
    with pytest.raises(HardwareError, match='no screen'):
        make_hand('pybullet', SCENARIO, view=True)


def test_hands_do_not_share_a_world(hand):
    a, b = hand(), hand()
    for _ in range(50):
        a.step(np.array([1.0, 0.0]))
    np.testing.assert_array_equal(b.joints()[0], Q[3:])
    a.disconnect()
    a.disconnect()
    b.step(None)


def _cross(a, b) -> float:
    return a[0] * b[1] - a[1] * b[0]
