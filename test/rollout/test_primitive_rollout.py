"""Motion primitives by forward dynamics: from rest to rest, the same every time, mirrored for the mirrored hand; perturbed samples."""

import numpy as np
import pytest
from problems import ASYMMETRIC, HEPTAGON, REGULAR

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.errors import DocumentError
from wholearm_ros.kernels.rollout import Start
from wholearm_ros.mechanics.contacts import gap_table, start_configuration
from wholearm_ros.mechanics.mirror import mirror_configurations
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.hand import CLOSING, LEFT, RIGHT
from wholearm_ros.model.motion_primitive import MotionPrimitive
from wholearm_ros.rollout.initial_state import perturbed_start
from wholearm_ros.rollout.perturbed_samples import build_perturbed_samples, follow_course
from wholearm_ros.rollout.primitive_rollout import Rest, simulate_primitive

PRIMITIVES = pytest.mark.parametrize(
    'primitive',
    [
        MotionPrimitive(LEFT, -0.2, 0.2),
        MotionPrimitive(RIGHT, -0.3, 0.05),
        MotionPrimitive(LEFT, 0.0, 1.0),
    ],
    ids=['left_closes', 'right_opens', 'press'],
)


def at_start(scenario):
    world = build_world(scenario)
    q = start_configuration(scenario, world)
    return world, Rest(q, world.bearing(q))


@PRIMITIVES
def test_a_primitive_ends_at_rest_where_it_should(primitive):
    """The velocity finger has turned by `turn` to 10 mrad; the other one carries the torque; the LCP is solved to 1e-9."""
    world, start = at_start(ASYMMETRIC)
    record = simulate_primitive(world, start, primitive)
    side, end = primitive.velocity_finger, record.rest()
    assert record.at_rest and record.residual <= 1e-9
    assert np.abs(record.velocities[-1] / world.scale).max() < 0.01
    assert end.q[3 + side] == pytest.approx(start.q[3 + side] + primitive.turn, abs=0.01)
    held = world.bearing(start.q)[1 - side] + CLOSING[1 - side] * primitive.torque
    assert end.efforts[1 - side] == pytest.approx(held, abs=1e-12)
    assert (np.abs(record.efforts) <= world.torque_limits).all()


@PRIMITIVES
def test_the_efforts_at_the_end_balance_everything_that_is_at_rest(primitive):
    """Held by these efforts and nothing else, the object stays where it is for 20 ms: to 0.1 mm and mrad."""
    world, start = at_start(ASYMMETRIC)
    record = simulate_primitive(world, start, primitive)
    end = record.rest()
    held = simulate_primitive(
        world, end, MotionPrimitive(primitive.velocity_finger, 0.0, primitive.torque, settle=0.02)
    )
    np.testing.assert_allclose(held.configurations[-1], end.q, atol=1e-3)


@PRIMITIVES
def test_a_primitive_is_the_same_every_time(primitive):
    world, start = at_start(ASYMMETRIC)
    one, two = (simulate_primitive(world, start, primitive) for _ in range(2))
    for name in ('configurations', 'velocities', 'efforts', 'wanted'):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))


@PRIMITIVES
def test_nothing_penetrates_in_a_primitive_by_more_than_time_stepping_lets_it(primitive):
    """0.1 mm, at every record."""
    world, start = at_start(ASYMMETRIC)
    record = simulate_primitive(world, start, primitive)
    assert min(gap_table(world, q)[0].min() for q in record.configurations) > -1e-4


@PRIMITIVES
def test_the_mirrored_hand_makes_the_mirrored_primitive(primitive):
    world, start = at_start(ASYMMETRIC)
    other = build_world(ASYMMETRIC.mirrored())
    image = Rest(mirror_configurations(start.q), -start.efforts[::-1])
    one, two = (
        simulate_primitive(world, start, primitive),
        simulate_primitive(other, image, primitive.mirrored()),
    )
    np.testing.assert_allclose(
        two.configurations, mirror_configurations(one.configurations), atol=1e-6
    )


def test_setpoints_of_a_primitive_begin_where_it_begins_and_lead_the_plan_to_its_end():
    """Led along its own setpoints by the controllers, the object of the plan comes within 2 mm and 0.02 rad of the end."""
    world, start = at_start(ASYMMETRIC)
    record = simulate_primitive(world, start, MotionPrimitive(LEFT, -0.2, 0.2))
    angles, velocities, efforts = record.setpoints(start)
    np.testing.assert_array_equal(angles[0], start.q[3:])
    assert (velocities[0] == 0.0).all() and (velocities[-1] == 0.0).all()
    (nominal,) = build_perturbed_samples(ASYMMETRIC, 0, 1.0, 0)
    begin = Start(start.q, np.zeros(5), start.efforts, False, -1)
    run = follow_course(nominal, record.course(start), begin, ControlOptions(), settle=0.2)
    assert run.residual <= 1e-9
    assert (np.abs(run.q[:3] - record.configurations[-1, :3]) < [2e-3, 2e-3, 2e-2]).all()


def test_a_primitive_survives_its_document_and_a_mirror():
    primitive = MotionPrimitive(RIGHT, -0.25, 0.6, 1.1, 0.2)
    assert MotionPrimitive.from_dict(primitive.to_dict()) == primitive
    assert (
        primitive.mirrored() == MotionPrimitive(LEFT, 0.25, 0.6, 1.1, 0.2)
        and primitive.mirrored().mirrored() == primitive
    )


@pytest.mark.parametrize(
    'damage', [{}, {'velocity_finger': 'middle'}, {'turn': 'far'}, {'torque': None}]
)
def test_a_damaged_primitive_is_refused(damage):
    document = {**MotionPrimitive(RIGHT, 0.1, 0.2).to_dict(), **damage} if damage else {}
    with pytest.raises(DocumentError):
        MotionPrimitive.from_dict(document)


# ---------------------------------------------------------------------- perturbed samples
@pytest.mark.parametrize(
    'scenario', [ASYMMETRIC, REGULAR, HEPTAGON], ids=['asymmetric', 'regular', 'heptagon']
)
def test_samples_are_drawn_alike_and_set_down_without_penetration(scenario):
    """The first is nominal; each is at rest: it touches palm and fingers to 1e-8 m and penetrates nothing."""
    samples, again = (
        build_perturbed_samples(scenario, 6, 1.0, 3),
        build_perturbed_samples(scenario, 6, 1.0, 3),
    )
    np.testing.assert_array_equal(samples[0].start, start_configuration(scenario))
    for one, two in zip(samples, again):
        np.testing.assert_array_equal(one.start, two.start)
        np.testing.assert_array_equal(one.world.obj, two.world.obj)
        gaps, _ = gap_table(one.world, one.start)
        assert gaps.min() > -1e-8 and np.sort(np.abs(gaps))[2] < 1e-8
    assert len({c.world.obj.tobytes() for c in samples}) == 7


def test_a_nominal_object_settles_where_it_should():
    np.testing.assert_array_equal(
        perturbed_start(ASYMMETRIC, ASYMMETRIC), start_configuration(ASYMMETRIC)
    )
