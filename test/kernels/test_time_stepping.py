"""Time stepping: the complementarity problem, impacts, energy, momentum, and the loops that step."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from problems import ASYMMETRIC, HEPTAGON, REGULAR, worlds

from wholearm_ros.kernels import geometry, time_stepping
from wholearm_ros.kernels.lcp import lcp_residual, new_lcp, solve_lcp
from wholearm_ros.mechanics.contacts import gap_table, start_configuration
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.finger_shape import ConvexParts
from wholearm_ros.model.hand import Hand

H = 0.001  # [s]


def work_of(world, friction=0.0):
    return time_stepping.new_workspace(world, friction, H)


def one_step(world, q, v, efforts=(0.0, 0.0), friction=0.0, load=None, moment=None, work=None):
    """(q, v, closed, residual) after one step; q and v are copied."""
    q, v = q.copy(), v.copy()
    loaded = world._replace(
        load=world.load if load is None else load,
        finger_weights=world.finger_weights if moment is None else moment,
    )
    work = work or work_of(world, friction)
    closed, residual = time_stepping.step(loaded, work, np.asarray(efforts, float), q, v)
    return q, v, closed, residual


def free_configurations(seed, count, clearance=1e-6):
    """(world, q, v): nothing penetrates, something is near."""
    rng, made = np.random.default_rng(seed), 0
    for scenario, world, _ in worlds(rng, 100 * count):
        q = start_configuration(scenario, world) if len(scenario.palm.vertices) == 2 else None
        if q is None:
            continue
        q[1] += rng.uniform(0.0, 0.001)
        q[2] += rng.uniform(-0.01, 0.01)
        q[3] += rng.uniform(0.0, 0.01)
        q[4] -= rng.uniform(0.0, 0.01)
        if gap_table(world, q)[0].min() > clearance:
            yield world, q, rng.normal(size=5) * [0.3, 0.3, 3.0, 3.0, 3.0]
            made += 1
        if made == count:
            return


def enumerated(a, b):
    """w = a z + b of the LCP by trying every active set: unique for a positive semidefinite."""
    k = len(b)
    for size in range(k + 1):
        for active in map(list, combinations(range(k), size)):
            z = np.zeros(k)
            z[active] = np.linalg.lstsq(a[np.ix_(active, active)], -b[active], rcond=None)[0]
            w = a @ z + b
            if (
                z.min() >= -1e-10
                and w.min() >= -1e-10
                and np.abs(w[active]).max(initial=0.0) < 1e-9
            ):
                return w
    return None


# ---------------------------------------------------------------------- the complementarity problem
def lcp_of(r, b, guess=None):
    """The problem 0 ≤ z ⟂ r rᵀ z + b ≥ 0 with r (k, up to 5)."""
    lcp = new_lcp(len(b))
    lcp.rows[:, : r.shape[1]], lcp.b[:] = r, b
    if guess is not None:
        lcp.guess[:] = guess
    return lcp


@pytest.mark.parametrize('rank', [2, 3, 5])
def test_complementarity_problems_are_solved_to_1e_9(rank):
    """z ≥ 0 ⟂ a z + b ≥ 0 on positive semidefinite a = r rᵀ of any rank, b = r c + d with d ≥ 0 (so that there is a solution)."""
    rng = np.random.default_rng(20 + rank)
    for _ in range(300):
        k = int(rng.integers(1, 9))
        r = rng.normal(size=(k, rank))
        a, b = r @ r.T, r @ rng.normal(size=rank) + rng.uniform(0.0, 0.2, k) * (rng.random(k) < 0.5)
        lcp = lcp_of(r, b, rng.random(k) < 0.4)
        assert solve_lcp(lcp, k) <= 1e-9
        z, w = lcp.z, a @ lcp.z + b
        assert z.min() >= -1e-9 and w.min() >= -1e-9 and abs(z @ w) < 1e-8


def test_the_solution_is_the_one_that_trying_all_active_sets_finds():
    rng = np.random.default_rng(24)
    for _ in range(60):
        k = int(rng.integers(1, 6))
        r = rng.normal(size=(k, 5))
        a, lcp = r @ r.T, lcp_of(r, r @ rng.normal(size=5))
        solve_lcp(lcp, k)
        np.testing.assert_allclose(a @ lcp.z + lcp.b, enumerated(a, lcp.b), atol=1e-8)


def test_the_residual_sees_a_wrong_answer():
    lcp = lcp_of(np.eye(2), [-1.0, 1.0])
    for z, residual in (((1.0, 0.0), 0.0), ((0.5, 0.0), 0.5), ((1.0, -0.2), 0.2)):
        lcp.z[:] = z
        assert lcp_residual(lcp, 2) == pytest.approx(residual)


# ---------------------------------------------------------------------- one step
def test_a_step_is_gauss_principle():
    """v⁺ is nearest (in the mass metric) to the free velocity among those that do not penetrate: compared with the LCP of
    all pairs near, its active sets tried one by one."""
    for world, q, v in free_configurations(30, 40):
        free = v - H * np.concatenate([world.load[:3], world.bearing(q)]) / world.inertias
        gaps, codes = gap_table(world, q)
        near = gaps < time_stepping.NEAR
        rows = np.empty((near.sum(), 5))
        geometry.normal_rows(world, codes[near], q, rows, np.empty(near.sum()))
        w = enumerated(rows / world.inertias @ rows.T, rows @ free + gaps[near] / H)
        _, after, _, residual = one_step(world, q, v)
        assert residual <= 1e-9
        np.testing.assert_allclose(rows @ after + gaps[near] / H, w, atol=1e-6)


def test_impulses_push_and_only_where_contacts_close():
    """M (v⁺ − v_free) is a non-negative combination of the rows of pairs that end the step closed: complementarity."""
    hits = 0
    for world, q, v in free_configurations(31, 60):
        free = v - H * np.concatenate([world.load[:3], world.bearing(q)]) / world.inertias
        work = work_of(world)
        _, after, closed, _ = one_step(world, q, v, work=work)
        gaps, codes, active = work.gaps, work.codes, work.active[: -time_stepping.STOPS : 2]
        assert closed == active.sum()
        if not closed:
            np.testing.assert_allclose(after, free, atol=1e-12)
            continue
        hits += 1
        rows = np.empty((closed, 5))
        geometry.normal_rows(world, codes[active], q, rows, np.empty(closed))
        np.testing.assert_allclose(rows @ after + gaps[active] / H, 0.0, atol=1e-9)
        impulses = np.linalg.lstsq(rows.T, world.inertias * (after - free), rcond=None)[0]
        np.testing.assert_allclose(rows.T @ impulses, world.inertias * (after - free), atol=1e-12)
        if np.linalg.matrix_rank(rows) == closed:
            assert impulses.min() >= -1e-12
    assert hits > 20


def test_no_step_without_load_adds_kinetic_energy():
    """From any state that does not penetrate, without and with friction."""
    for world, q, v in free_configurations(32, 60):
        for friction in (0.0, 0.1):
            _, after, _, _ = one_step(
                world, q, v, friction=friction, load=np.zeros(5), moment=np.zeros((2, 2))
            )
            assert world.inertias @ after**2 <= world.inertias @ v**2 * (1.0 + 1e-12)


def test_a_motion_without_load_never_gains_energy():
    """0.5 s of an object rattling between heavy fingers: from step to step by no more than the penetration given back."""
    world = build_world(HEPTAGON)
    for seed in range(4):
        q, work = start_configuration(HEPTAGON), work_of(world)
        v = np.random.default_rng(seed).normal(size=5) * [0.2, 0.2, 3.0, 1.0, 1.0]
        levels = [world.inertias @ v**2 / 2]
        for _ in range(500):
            q, v, _, _ = one_step(world, q, v, load=np.zeros(5), moment=np.zeros((2, 2)), work=work)
            levels.append(world.inertias @ v**2 / 2)
        assert np.diff(levels).max() < 1e-6 * levels[0] and levels[-1] < levels[0]


def test_free_fall_loses_exactly_what_a_step_of_the_integrator_loses():
    """m g² h² / 2 a step: semi-implicit Euler, and no more."""
    world = build_world(ASYMMETRIC)
    q, v = np.array([0.0, 3.0, 0.3, 1.5, 1.5]), np.array([0.1, 0.2, 1.0, 0.0, 0.0])
    m, g = ASYMMETRIC.object.mass, ASYMMETRIC.gravity.in_plane
    after_q, after_v, closed, _ = one_step(world, q, v)
    before = m * (v[:2] @ v[:2]) / 2 + m * g * q[1]
    after = m * (after_v[:2] @ after_v[:2]) / 2 + m * g * after_q[1]
    assert closed == 0 and after - before == pytest.approx(-m * g * g * H * H / 2, rel=1e-6)


def test_the_palm_takes_no_horizontal_momentum():
    """An object that slides and tumbles on the level palm keeps m v_x; its angular momentum in flight, too."""
    world = build_world(ASYMMETRIC)
    q = start_configuration(ASYMMETRIC)
    q[1], q[3], q[4] = q[1] + 0.02, 3.0, 0.1
    v, work = np.array([0.05, 0.0, 2.0, 0.0, 0.0]), work_of(world)
    met = 0
    for _ in range(300):
        efforts = world.bearing(q)
        q, v, closed, _ = one_step(world, q, v, efforts=efforts, work=work)
        met += closed > 0
        assert v[0] == pytest.approx(0.05, abs=1e-12)
        if not met:
            assert v[2] == pytest.approx(2.0, abs=1e-12)
    assert met > 10


def test_contact_forces_between_object_and_finger_are_equal_and_opposite():
    """With nothing else near, the object's momentum times the lever is what the finger loses, about the finger's axis."""
    world = build_world(ASYMMETRIC)
    q = start_configuration(ASYMMETRIC)
    q[1] += 0.01
    q[4] = 0.1
    q[3] = geometry.closing_angle(world, 0, q[:3])
    v = np.array([-0.2, 0.0, 0.0, -1.0, 0.0])
    _, after, closed, _ = one_step(world, q, v, load=np.zeros(5), moment=np.zeros((2, 2)))
    assert closed >= 1

    def about_axis(rate):
        p = world.inertias[:2] * rate[:2]
        arm = q[:2] - world.fingers[0, :2]
        return (
            arm[0] * p[1]
            - arm[1] * p[0]
            + world.inertias[2] * rate[2]
            + world.inertias[3] * rate[3]
        )

    assert about_axis(after) == pytest.approx(about_axis(v), abs=1e-12)


# ---------------------------------------------------------------------- friction
TILT = 0.2  # [rad] of gravity against the level palm: a slope
ASIDE = np.array([3.0, 0.1])  # [rad] fingers out of the way


def on_a_slope(scenario, seconds, friction, speed=0.0, tilt=TILT):
    """(m, 5) velocities of an object that lies on the palm under gravity that is tilted by `tilt`, the fingers apart."""
    world, q, v = build_world(scenario), start_configuration(scenario), np.zeros(5)
    q[3:], v[0] = ASIDE, speed
    weight = world.load[1]
    load = np.array([-weight * np.sin(tilt), weight * np.cos(tilt), 0.0, 0.0, 0.0])
    work, speeds = work_of(world, friction), []
    for _ in range(int(seconds / H)):
        efforts = world.bearing(q)
        q, v, _, residual = one_step(world, q, v, efforts, load=load, work=work)
        assert residual <= 1e-9
        speeds.append(v)
    return np.array(speeds)


@pytest.mark.parametrize('scenario', [ASYMMETRIC, REGULAR, HEPTAGON], ids=lambda s: s.name)
def test_an_object_on_a_slope_below_the_angle_of_friction_stays(scenario):
    """Exactly: it does not creep, for a second."""
    assert np.abs(on_a_slope(scenario, 1.0, 1.01 * np.tan(TILT))).max() < 1e-10


@pytest.mark.parametrize('friction', [0.05, 0.1, 0.15])
def test_an_object_on_a_steeper_slope_slides_as_coulomb_says(friction):
    """a = g (sin α − μ cos α), to 0.1 %; it leaves the slope by no more than μ times what its speed changes in a step."""
    g = ASYMMETRIC.gravity.in_plane
    speeds = on_a_slope(ASYMMETRIC, 0.1, friction)
    expected = 0.1 * g * (np.sin(TILT) - friction * np.cos(TILT))
    assert speeds[-1, 0] == pytest.approx(expected, rel=1e-3)
    assert np.abs(speeds[:, 1]).max() < 1.01 * friction * expected / 0.1 * H
    assert np.abs(speeds[:, 2]).max() < 1e-9


@pytest.mark.parametrize('speed', [0.02, -0.1, 0.3])
def test_what_slides_on_the_level_comes_to_rest_after_v_over_mu_g(speed):
    friction, g = 0.05, ASYMMETRIC.gravity.in_plane
    time = abs(speed) / (friction * g)
    moving = np.abs(on_a_slope(ASYMMETRIC, time + 0.05, friction, speed, tilt=0.0)[:, 0]) > 1e-9
    assert abs(moving.sum() * H - time) <= 0.01 * time + 2 * H and not moving[-1]


# ---------------------------------------------------------------------- end stops
@pytest.mark.parametrize('side', [0, 1])
@pytest.mark.parametrize('end', [0, 1])
def test_a_finger_that_comes_to_its_end_stop_stays_there(side, end):
    """Thrown at it with 3 rad/s and pressed on it with 2 N m: it stops within a step, and bears on that stop only."""
    world, work = build_world(ASYMMETRIC), work_of(build_world(ASYMMETRIC))
    q, v, sign = np.array([0.0, 3.0, 0.0, 1.5, 1.5]), np.zeros(5), (-1.0, 1.0)[end]
    stop = world.limits[side, end]
    q[3 + side], v[3 + side] = stop - 0.02 * sign, 3.0 * sign
    for _ in range(100):
        efforts = world.bearing(q)
        efforts[side] += 2.0 * sign
        q, v, _, residual = one_step(world, q, v, efforts, work=work)
        assert residual <= 1e-9 and sign * (q[3 + side] - stop) < 1e-12
    assert q[3 + side] == pytest.approx(stop, abs=1e-12) and abs(v[3 + side]) < 1e-12
    assert work.stops_met[side, end] and work.stops_met.sum() == 1


# ---------------------------------------------------------------------- the loop that steps
def in_two_parts(scenario, joint):
    """The same with rectangular fingers cut across at `joint` [m]."""
    fingers = []
    for finger in (scenario.hand.left, scenario.hand.right):
        outline = finger.shape.outline
        ends = [np.clip(outline[:, 0], 0.0, joint), np.clip(outline[:, 0], joint, None)]
        parts = [np.column_stack([end, outline[:, 1]]) for end in ends]
        fingers.append(replace(finger, shape=ConvexParts(parts)))
    return replace(scenario, hand=Hand(*fingers))


@pytest.mark.parametrize('side', [0, 1])
@pytest.mark.parametrize('vertex', range(6))
@pytest.mark.parametrize('lean', [-0.1, 0.0, 0.1])
@pytest.mark.parametrize('joint', [None, 0.149], ids=['whole', 'of_two_parts'])
def test_a_vertex_that_slides_off_a_finger_s_tip_meets_nothing(side, vertex, lean, joint):
    """Without forces the object slides along the finger's inner face at 0.3 m/s and past its tip: nothing is in its way, though
    the tip's corner crosses the lines of both edges that meet in the vertex; nor where two parts meet along an edge."""
    world = build_world(ASYMMETRIC if joint is None else in_two_parts(ASYMMETRIC, joint))
    q, v, work = start_configuration(ASYMMETRIC).copy(), np.zeros(5), work_of(world)
    q[3:] = [(1.3, 0.2), (2.9, 1.8)][side]  # the other finger is out of the way
    u = np.array([np.cos(q[3 + side]), np.sin(q[3 + side])])
    inner = np.array([u[1], -u[0]]) if side == 0 else np.array([-u[1], u[0]])
    axis, shape = world.fingers[side, :2], ASYMMETRIC.hand[side].shape
    length, half = shape.length, shape.half_width
    normals = world.obj[[vertex - 1, vertex], 2:4]
    outwards = np.arctan2(*normals.sum(axis=0)[::-1])
    q[2] = np.arctan2(-inner[1], -inner[0]) - outwards + lean
    c, s = np.cos(q[2]), np.sin(q[2])
    q[:2] = (
        axis
        + (length - 0.003) * u
        + half * inner
        - np.array([[c, -s], [s, c]]) @ world.obj[vertex, :2]
    )
    v[:2] = 0.3 * u
    for _ in range(20):
        q, after, _, _ = one_step(world, q, v, load=np.zeros(5), moment=np.zeros((2, 2)), work=work)
        np.testing.assert_allclose(after, v, atol=1e-9)
