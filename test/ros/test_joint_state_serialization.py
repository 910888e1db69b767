"""JointState on the wire: read as rclpy reads it, written so that rclpy reads it; what is no JointState is refused."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

rclpy = pytest.importorskip('rclpy')

from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState

from wholearm_ros.ros.interface.joint_state_serialization import (
    MessageError,
    read_joints,
    reading_of,
    write_joints,
)

texts = st.text(max_size=9).filter(lambda t: '\0' not in t and t.isprintable())
columns = st.lists(st.floats(allow_nan=False), max_size=3)
stamps = st.integers(-(2**31) * 10**9, 2**31 * 10**9 - 1)


@given(texts, st.lists(texts, max_size=3), columns, columns, columns, stamps)
def test_both_ways_agree_with_rclpy(frame, names, position, velocity, effort, stamp):
    message = JointState(name=names, position=position, velocity=velocity, effort=effort)
    message.header.frame_id = frame
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
    assert read_joints(serialize_message(message)) == reading_of(message)
    written = write_joints(stamp, frame, tuple(names), position, velocity, effort)
    assert deserialize_message(written, JointState) == message
    assert read_joints(written) == reading_of(message)


def test_numbers_that_are_not_finite_come_through():
    assert math.isnan(read_joints(write_joints(1, 'palm', ('a',), [math.nan])).position[0])


@given(st.binary(max_size=60), st.integers(0, 40))
def test_damaged_bytes_are_refused_or_read_but_nothing_else(noise, cut):
    whole = write_joints(5, 'palm', ('left_finger_joint',), [1.0], [2.0], [3.0])
    for data in (whole[:4] + noise, whole[: max(4, len(whole) - 1 - cut)]):
        try:
            read_joints(data)
        except MessageError as error:
            assert 'JointState' in str(error) or 'stamp.nanosec' in str(error)


def test_a_stamp_beyond_a_second_is_refused():
    message = JointState()
    message.header.stamp.nanosec = 10**9
    with pytest.raises(MessageError, match='allowed: 0 to 999999999'):
        read_joints(serialize_message(message))
