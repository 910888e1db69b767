"""What comes over the wire is taken, or refused with a reason, and never anything else."""

import pytest
from builtin_interfaces.msg import Time
from hypothesis import given
from hypothesis import strategies as st

from wholearm_ros.errors import WholeArmError
from wholearm_ros.ros.interface.messages import pose_message, to_planar

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
