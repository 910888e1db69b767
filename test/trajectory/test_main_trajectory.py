"""MAIN_TRAJECTORY: what every generated trajectory obeys, on the shipped hexagons and others, for several ways to execute."""

from dataclasses import replace

import numpy as np
import pytest
from problems import ASYMMETRIC, FLAT_PALMS, REGULAR, SQUARE

from wholearm_ros.errors import DocumentError
from wholearm_ros.mechanics.contacts import contact_rows, gap_table, pair_from_name
from wholearm_ros.mechanics.quasistatic import build_quasistatics
from wholearm_ros.mechanics.torque_range import build_torque_range, solve_torque_range
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.hand import CLOSING, LEFT, RIGHT
from wholearm_ros.model.modes import CAGING, DWELL, DYNAMIC, QUASI_STATIC
from wholearm_ros.model.orientation import goal_rotation
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.model.weight import bearing_torques
from wholearm_ros.planning.routes import SearchOptions, plan
from wholearm_ros.trajectory.control_mode import control_mode
from wholearm_ros.trajectory.execution_options import FRONT, REAR, ExecutionOptions
from wholearm_ros.trajectory.main_trajectory import generate

OPTIONS = {
    'auto': ExecutionOptions(),
    'front': ExecutionOptions(velocity_finger=FRONT, torque_margin=3.5),
    'rear': ExecutionOptions(velocity_finger=REAR),
    'dynamic': ExecutionOptions(velocity_finger=FRONT, transition=DYNAMIC, extra_torque=0.7),
}
PLANS = {
    name: plan(FLAT_PALMS[name])
    for name in ('asymmetric_hexagon', 'regular_hexagon', 'heptagon', 'tall')
}
MADE = {
    (name, how): generate(FLAT_PALMS[name], PLANS[name], options)
    for name in PLANS
    for how, options in OPTIONS.items()
}
EVERY = pytest.mark.parametrize('name, how', MADE)


def samples_of(t, segment):
    """Indices of a segment's samples: those after its start, up to its end."""
    return range(int(round(segment.start / t.period)) + 1, int(round(segment.end / t.period)) + 1)


def quasi_static(name, how, every=3):
    """(world, segment, pairs, i, q) of the quasi-static samples."""
    t, world = MADE[name, how], build_world(FLAT_PALMS[name])
    for segment in t.segments:
        if segment.mode == QUASI_STATIC:
            pairs = tuple(pair_from_name(c) for c in segment.contacts)
            for i in samples_of(t, segment)[::every]:
                yield world, segment, pairs, i, np.concatenate([t.poses[i], t.angles[i]])


@EVERY
def test_segments_follow_on_one_another_from_zero_to_the_end(name, how):
    t = MADE[name, how]
    assert t.segments[0].start == 0.0 and t.segments[-1].end == pytest.approx(t.duration, abs=1e-9)
    for before, after in zip(t.segments[:-1], t.segments[1:]):
        assert after.start == before.end < after.end
    assert sum(t.time_in_modes().values()) == pytest.approx(t.duration, abs=1e-9)


@EVERY
def test_it_starts_and_ends_at_rest_where_the_plan_does(name, how):
    t, legs = MADE[name, how], PLANS[name].legs
    np.testing.assert_allclose([*t.poses[0], *t.angles[0]], legs[0].configurations[0], atol=1e-8)
    np.testing.assert_allclose(
        [*t.poses[-1], *t.angles[-1]], legs[-1].configurations[-1], atol=1e-8
    )
    assert t.poses[-1, 2] == pytest.approx(goal_rotation(FLAT_PALMS[name]), abs=1e-4)
    assert (t.velocities[0] == 0.0).all() and (t.velocities[-1] == 0.0).all()
    np.testing.assert_array_equal(t.angles[-50:], np.repeat(t.angles[-1:], 50, axis=0))


@EVERY
def test_nothing_jumps(name, how):
    """Joint speeds stay within their limit (a tenth over, where an arc bends between its samples), the object's too."""
    t = MADE[name, how]
    speed = OPTIONS[how].speed
    assert np.abs(np.diff(t.angles, axis=0)).max() / t.period <= 1.1 * speed
    assert np.abs(np.diff(t.poses, axis=0) / [0.1, 0.1, 1.0]).max() / t.period <= 2.0 * speed


@EVERY
def test_velocities_are_differences_of_the_angles(name, how):
    t = MADE[name, how]
    np.testing.assert_allclose(
        t.velocities[1:-1], (t.angles[2:] - t.angles[:-2]) / (2 * t.period), atol=1e-12
    )


@EVERY
def test_the_torque_never_changes_faster_than_its_slew_limit(name, how):
    """The torque-controlled finger's effort within every segment and from each to the next."""
    t, step = MADE[name, how], OPTIONS[how].slew * OPTIONS[how].period
    for segment in t.segments:
        for i in samples_of(t, segment):
            finger = segment.torque_finger
            assert abs(t.efforts[i, finger] - t.efforts[i - 1, finger]) <= step + 1e-9


@EVERY
def test_planned_contacts_are_kept_and_nothing_penetrates(name, how):
    """In quasi-static motion the gaps of the segment's contacts are ≤ 1e-6 m, every other gap ≥ −1e-5 m."""
    for world, _, pairs, _, q in quasi_static(name, how):
        assert np.abs(contact_rows(world, pairs, q)[1]).max() <= 1e-6
        assert gap_table(world, q)[0].min() >= -1e-5


@EVERY
def test_planned_efforts_balance_object_and_fingers(name, how):
    """Eq. (2): the forces that carry the object and the torque finger also explain the velocity finger's effort, to 1e-6."""
    for world, segment, pairs, i, q in quasi_static(name, how):
        model, finger, efforts = (
            build_quasistatics(world, pairs, q),
            segment.torque_finger,
            MADE[name, how].efforts[i],
        )
        matrix = np.vstack([model.G_n, model.J_n[:, finger]])
        f = np.linalg.solve(matrix, [*(-model.g_O), efforts[finger] - model.g_h[finger]])
        assert model.residual(f, efforts) <= 1e-6 * (1.0 + np.abs(f).max())


@EVERY
def test_the_torque_lies_in_its_range_wherever_there_is_one(name, how):
    """The recorded range is that of problem (6); the torque leaves it by at most 0.05 N m, and in one sample of twenty
    (where the range moves faster than the torque may), never where it is wider than two steps of the slew limit."""
    t, outside, seen = MADE[name, how], 0, 0
    for world, segment, pairs, i, q in quasi_static(name, how):
        low, high = t.torque_ranges[i]
        found = solve_torque_range(
            build_torque_range(
                build_quasistatics(world, pairs, q), segment.torque_finger, world.torque_limits
            )
        )
        if found.empty or i in (samples_of(t, segment)[0], samples_of(t, segment)[-1]):
            continue
        np.testing.assert_allclose([low, high], [found.low, found.high], atol=1e-6)
        torque = t.efforts[i, segment.torque_finger]
        seen += 1
        outside += not low - 1e-6 <= torque <= high + 1e-6
    assert seen > 10 and outside <= 0.05 * seen


@EVERY
def test_efforts_stay_within_the_motors(name, how):
    limit = FLAT_PALMS[name].hand.left.torque_limit
    t = MADE[name, how]
    for segment in t.segments:
        assert (
            np.abs(t.efforts[samples_of(t, segment), segment.torque_finger]).max() <= limit + 1e-9
        )


@EVERY
def test_caging_presses_with_no_more_than_its_torque(name, how):
    """Towards closing, beyond what holds the finger against gravity; the object's rotation only grows."""
    t, scenario = MADE[name, how], FLAT_PALMS[name]
    world = build_world(scenario)
    for segment in t.segments:
        if segment.mode != CAGING:
            continue
        ids = list(samples_of(t, segment))
        finger = segment.torque_finger
        extra = (
            t.efforts[ids, finger] - bearing_torques(world.finger_weights, t.angles[ids])[:, finger]
        )
        np.testing.assert_allclose(CLOSING[finger] * extra, OPTIONS[how].caging_torque, atol=1e-9)
        assert (np.diff(t.poses[ids, 2]) >= -1e-12).all()


@EVERY
def test_the_same_plan_gives_the_same_trajectory_also_through_its_document(name, how):
    scenario, options = FLAT_PALMS[name], OPTIONS[how]
    read = ContactPlan.from_json(PLANS[name].to_json())
    assert generate(scenario, read, options).to_json() == MADE[name, how].to_json()


@EVERY
def test_a_trajectory_survives_its_document_exactly(name, how):
    t = MADE[name, how]
    read = ManipulationTrajectory.from_json(t.to_json())
    assert read.to_json() == t.to_json() and read.segments == t.segments
    for field in ('angles', 'velocities', 'efforts', 'torque_ranges', 'poses'):
        np.testing.assert_array_equal(getattr(read, field), getattr(t, field))


@pytest.mark.parametrize('name', ['asymmetric_hexagon', 'regular_hexagon'])
def test_the_mirrored_plan_gives_the_mirrored_trajectory(name):
    """θ_L → π − θ_R, efforts and torques their sign, velocity fingers exchanged: to 1e-6."""
    image = FLAT_PALMS[name].mirrored()
    one, two = MADE[name, 'auto'], generate(image, plan(image), OPTIONS['auto'])
    np.testing.assert_allclose(two.angles, np.pi - one.angles[:, ::-1], atol=1e-6)
    np.testing.assert_allclose(two.poses, one.poses * [-1, 1, -1], atol=1e-6)
    np.testing.assert_allclose(two.efforts, -one.efforts[:, ::-1], atol=1e-4)
    assert [(s.mode, 1 - s.velocity_finger) for s in two.segments] == [
        (s.mode, s.velocity_finger) for s in one.segments
    ]


# ---------------------------------------------------------------------- transitions and control modes
@pytest.mark.parametrize('name, torque', [('asymmetric_hexagon', 0.25), ('regular_hexagon', 0.23)])
@pytest.mark.parametrize('search', ['best', 'random'])
def test_from_sliding_to_pivoting_the_torque_ranges_only_touch(name, torque, search):
    """Condition 2 of III-B.1 fails there, condition 1 holds: 0.25 | 0.25 and 0.23 | 0.23 N m of the right finger."""
    t = generate(FLAT_PALMS[name], plan(FLAT_PALMS[name], SearchOptions(search)), OPTIONS['front'])
    pivot = next(
        r
        for r in t.transitions
        if len(palm_contacts(r['before'])) == 2 and len(palm_contacts(r['after'])) == 1
    )
    assert pivot['range_before'][1] == pytest.approx(torque, abs=0.005)
    assert pivot['range_after'][0] == pytest.approx(pivot['range_before'][1], abs=1e-6)
    assert abs(pivot['overlap']) < 1e-6 and pivot['condition_1'] and not pivot['condition_2']


def palm_contacts(names):
    return [n for n in names if 'palm' in n]


def test_a_transition_whose_ranges_part_is_made_at_rest_when_it_is_to_dwell():
    t = MADE['asymmetric_hexagon', 'front']
    modes = [s.mode for s in t.segments]
    assert modes == [DWELL, QUASI_STATIC, DWELL, QUASI_STATIC, QUASI_STATIC, DWELL, CAGING, DWELL]
    for segment in t.segments:
        if segment.mode == DWELL:
            ids = list(samples_of(t, segment))
            np.testing.assert_array_equal(
                t.angles[ids], np.repeat(t.angles[ids[:1]], len(ids), axis=0)
            )


def test_a_dynamic_transition_exceeds_the_largest_torque_by_the_extra_torque():
    """The paper's order of modes, and τ_dyn = τ_max + τ_extra at the transition (III-B.2), to a step of the slew limit."""
    t, options = MADE['asymmetric_hexagon', 'dynamic'], OPTIONS['dynamic']
    modes = [s.mode for s in t.segments if s.mode != DWELL]
    assert modes == [QUASI_STATIC, DYNAMIC, QUASI_STATIC, QUASI_STATIC, CAGING]
    dynamic = next(s for s in t.segments if s.mode == DYNAMIC)
    parted = next(r for r in t.transitions if not r['condition_2'])
    assert dynamic.velocity_finger == LEFT
    reached = t.efforts[list(samples_of(t, dynamic)), RIGHT].max()
    wanted = parted['range_before'][1] + options.extra_torque
    assert wanted - options.slew * options.period - 1e-9 <= reached <= wanted + 1e-9


def test_an_extra_torque_that_also_breaks_a_contact_to_be_kept_is_not_used():
    """Check_Dyn: with 2 N m the forward dynamics lose the left finger's vertex, too; the transition is made at rest instead."""
    strong = replace(OPTIONS['dynamic'], extra_torque=2.0)
    modes = generate(ASYMMETRIC, PLANS['asymmetric_hexagon'], strong).time_in_modes()
    assert (
        modes[DYNAMIC] == 0.0 < modes[DWELL]
        and MADE['asymmetric_hexagon', 'dynamic'].time_in_modes()[DYNAMIC] > 0.0
    )


def test_the_degree_of_constraint_counts_contacts_with_palm_and_velocity_finger():
    for name in PLANS:
        for world, segment, pairs, _, q in quasi_static(name, 'auto', every=20):
            both = [control_mode(world, pairs, q, side) for side in (LEFT, RIGHT)]
            on = [
                sum(c.split(':')[1].startswith(body) for c in segment.contacts)
                for body in ('palm', 'left', 'right')
            ]
            assert [m.degree_of_constraint for m in both] == [on[0] + on[1], on[0] + on[2]]
            assert segment.degree_of_constraint == (
                both[segment.velocity_finger].degree_of_constraint,
                both[1 - segment.velocity_finger].degree_of_constraint,
            )
            assert all(0.0 <= m.conditioning <= 1.0 for m in both)


def test_the_finger_with_the_smaller_degree_of_constraint_is_velocity_controlled():
    """III-B.4, wherever that finger can drive the leg: true for most of the time of the asymmetric hexagon."""
    t = MADE['asymmetric_hexagon', 'auto']
    preferred = [
        s
        for s in t.segments
        if s.mode == QUASI_STATIC and s.degree_of_constraint[0] <= s.degree_of_constraint[1]
    ]
    assert len(preferred) == sum(s.mode == QUASI_STATIC for s in t.segments)


# ---------------------------------------------------------------------- refusals
def test_a_plan_without_a_route_cannot_be_executed():
    with pytest.raises(DocumentError, match='no route'):
        generate(SQUARE, plan(SQUARE))


def test_a_plan_of_another_scenario_is_refused():
    with pytest.raises(DocumentError, match='does not fit'):
        generate(REGULAR, PLANS['asymmetric_hexagon'])


@pytest.mark.parametrize(
    'contacts',
    [
        ('v9:palm.e0', 'v1:palm.e0', 'v5:left.inner', 'v2:right.inner'),
        ('v0:palm.e7',) * 4,
        ('v0',) * 4,
        ('v0:palm.e0', 'v1:palm.e0', 'v5:left.inner'),
        ('e0:palm.v99999999999',) * 4,
    ],
)
def test_contacts_that_the_scenario_does_not_have_are_refused(contacts):
    found = PLANS['asymmetric_hexagon']
    with pytest.raises(DocumentError, match='does not fit'):
        generate(
            ASYMMETRIC,
            replace(found, legs=(replace(found.legs[0], contacts=contacts), *found.legs[1:])),
        )


@pytest.mark.parametrize(
    'values',
    [{'speeed': 1.0}, {'speed': 'fast'}, {'transition': 'jump'}, {'velocity_finger': 'left'}],
)
def test_unknown_execution_options_are_refused(values):
    with pytest.raises(DocumentError):
        generate(ASYMMETRIC, PLANS['asymmetric_hexagon'].with_execution(values))


def test_options_of_the_plan_document_are_used_when_none_are_given():
    how = OPTIONS['front']
    made = generate(ASYMMETRIC, PLANS['asymmetric_hexagon'].with_execution(how.to_dict()))
    assert (
        replace(made, plan_id='').to_json()
        == replace(MADE['asymmetric_hexagon', 'front'], plan_id='').to_json()
    )
    assert ExecutionOptions.from_dict(how.to_dict()) == how
