"""What comes over the wire is taken, or refused with a reason, and never anything else."""

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from hypothesis import given
from hypothesis import strategies as st

from wholearm_ros.errors import WholeArmError
from wholearm_ros.model.hand import JOINT_NAMES
from wholearm_ros.ros.interface.joint_state_serialization import JointReading
from wholearm_ros.ros.interface.messages import pose_message, to_commands, to_joints, to_planar

NUMBERS = st.floats(width=64)


@given(st.lists(NUMBERS, min_size=7, max_size=7))
def test_any_seven_numbers_are_a_planar_pose_or_refused(numbers):
    message = pose_message(Time(), (0.0, 0.0, 0.0))
    p, q = message.pose.position, message.pose.orientation
    p.x, p.y, p.z, q.x, q.y, q.z, q.w = numbers
    try:
        x, y, rotation = to_planar(message, 'pose')
    except WholeArmError as error:
        assert 'allowed: ' in str(error)
    else:
        assert (x, y) == (p.x, p.y) and abs(rotation) <= 3.1416


def test_a_pose_with_numbers_whose_squares_are_none_is_refused():
    message = pose_message(Time(), (0.0, 0.0, 0.0))
    message.pose.orientation.x = 1e200
    with pytest.raises(WholeArmError, match='allowed: a unit quaternion about z'):
        to_planar(message, 'pose')


def test_a_planar_pose_comes_back_as_it_went():
    assert to_planar(pose_message(Time(), (0.1, -0.2, 3.0)), 'pose') == pytest.approx(
        (0.1, -0.2, 3.0)
    )


LEFT, RIGHT = JOINT_NAMES
THREE = (RIGHT, 'wrist', LEFT)  # as a broadcaster of a whole robot sends them


def test_our_joints_are_found_among_others_in_any_order():
    stamp, joints = to_joints(JointReading(7, THREE, (1.0, 9.0, 2.0), (3.0, 9.0, 4.0), (5, 9, 6)))
    assert stamp == 7
    told = (joints.angles, joints.velocities, joints.efforts)
    assert np.array_equal(told, [[2.0, 1.0], [4.0, 3.0], [6.0, 5.0]])
    assert to_commands(JointReading(7, THREE, (), (), (5.0, np.nan, 6.0))) == [(1, 5.0), (0, 6.0)]
    assert to_commands(JointReading(7, (RIGHT,), (), (), (5.0,))) == [(1, 5.0)]


@pytest.mark.parametrize('effort', [(), (np.nan,) * 3])
def test_efforts_that_are_not_measured_are_said_to_be_unknown(effort):
    _, joints = to_joints(JointReading(7, THREE, (1.0,) * 3, (0.0,) * 3, effort))
    assert np.isnan(joints.efforts).all() and joints.finite
    assert joints.known_efforts.tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    'reading',
    [
        JointReading(7, (LEFT, 'wrist'), (1.0,) * 2, (0.0,) * 2, ()),
        JointReading(7, (LEFT, RIGHT, LEFT), (1.0,) * 3, (0.0,) * 3, ()),
        JointReading(7, THREE, (1.0,) * 2, (0.0,) * 3, ()),
        JointReading(7, THREE, (1.0,) * 3, (), ()),
        JointReading(7, THREE, (1.0,) * 3, (0.0,) * 3, (np.inf,) * 3),
    ],
)
def test_joint_states_that_do_not_tell_of_both_joints_are_refused(reading):
    with pytest.raises(WholeArmError, match='joint_states.* allowed: '):
        to_joints(reading)


@pytest.mark.parametrize(
    ('names', 'effort'),
    [
        (('wrist',), (1.0,)),
        ((), ()),
        ((LEFT, LEFT), (1.0, 1.0)),
        (THREE, (1.0, 2.0)),  # the third joint has no effort interface: whose efforts are these?
        ((LEFT, RIGHT), (1.0, np.nan)),
    ],
)
def test_commands_that_cannot_be_told_apart_are_refused_whole(names, effort):
    with pytest.raises(WholeArmError, match='joint_commands.* allowed: '):
        to_commands(JointReading(7, names, (), (), effort))
