"""sensor_msgs/JointState on the wire, read and written four times as fast as by its class.

The loop does this thousands of times a second; a test holds both ways against rclpy's own
serialization.
"""

from collections.abc import Sequence
from functools import lru_cache
from struct import Struct, error, unpack_from
from typing import Any, NamedTuple

from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from wholearm_ros.errors import WholeArmError

NANOSECONDS = 1_000_000_000
LITTLE_ENDIAN = b'\x00\x01\x00\x00'  # what every writer on this kind of machine begins with
START = len(LITTLE_ENDIAN)  # alignment counts from here


class MessageError(WholeArmError):
    """A message that cannot be used: says the field, what was got and what is allowed."""


class JointReading(NamedTuple):
    """What a JointState says. stamp [ns]; the columns are as long as their sender made them."""

    stamp: int
    name: tuple[str, ...]
    position: tuple[float, ...]
    velocity: tuple[float, ...]
    effort: tuple[float, ...]


def read_joints(data: bytes) -> JointReading:
    """Of a serialized JointState. Raises MessageError."""
    try:
        if data[:START] != LITTLE_ENDIAN:
            return reading_of(deserialize_message(data, JointState))
        sec, nanosec, length = unpack_from('<iII', data, START)
        at = _aligned(START + 12 + length, 4)
        names, at = _names(data, at)
        columns = []
        for _ in range(3):
            values, at = _doubles(data, at)
            columns.append(values)
    except (error, UnicodeDecodeError, RuntimeError) as problem:
        raise MessageError(
            f'JointState: got {len(data)} bytes that are none: {problem}'
        ) from problem
    return JointReading(nanoseconds(sec, nanosec), names, *columns)


def reading_of(message: JointState) -> JointReading:
    """Of a message object."""
    stamp = message.header.stamp
    return JointReading(
        nanoseconds(stamp.sec, stamp.nanosec),
        tuple(message.name),
        tuple(message.position),
        tuple(message.velocity),
        tuple(message.effort),
    )


def write_joints(
    stamp: int,
    frame: str,
    names: tuple[str, ...],
    position: Sequence[float] = (),
    velocity: Sequence[float] = (),
    effort: Sequence[float] = (),
) -> bytes:
    """The serialized JointState of `stamp` [ns]."""
    pack, head, *counts = _layout(frame, names, len(position), len(velocity), len(effort))
    seconds = divmod(stamp, NANOSECONDS)
    return bytes(pack(*seconds, head, *position, counts[0], *velocity, counts[1], *effort))


def nanoseconds(sec: int, nanosec: int) -> int:
    """[ns]; raises MessageError."""
    if not 0 <= nanosec < NANOSECONDS:
        raise MessageError(f'stamp.nanosec: got {nanosec}; allowed: 0 to {NANOSECONDS - 1}')
    return sec * NANOSECONDS + nanosec


def _aligned(at: int, size: int) -> int:
    return at + (START - at) % size


def _names(data: bytes, at: int) -> tuple[tuple[str, ...], int]:
    (count,) = unpack_from('<I', data, at)
    at, names = at + 4, []
    for _ in range(count):
        at = _aligned(at, 4)
        (length,) = unpack_from('<I', data, at)
        names.append(data[at + 4 : at + 3 + length].decode())  # without the zero at its end
        at += 4 + length
    return tuple(names), _aligned(at, 4)


def _doubles(data: bytes, at: int) -> tuple[tuple[float, ...], int]:
    (count,) = unpack_from('<I', data, at)
    if not count:
        return (), at + 4
    at = _aligned(at + 4, 8)
    return unpack_from(f'<{count}d', data, at), at + 8 * count


@lru_cache(maxsize=64)
def _layout(frame: str, names: tuple[str, ...], *counts: int) -> tuple[Any, ...]:
    """How to pack messages of this shape, and their constant pieces: the head, and what goes
    between the columns.
    """
    head = b''
    for text in (frame, None, *names):
        if text is None:
            head += len(names).to_bytes(4, 'little')
        else:
            coded = text.encode() + b'\0'
            head += len(coded).to_bytes(4, 'little') + coded
            head += bytes(-len(head) % 4)  # the next piece is a count
    pieces, at, form = [], 8 + len(head), ''
    for k, count in enumerate(counts):
        piece = count.to_bytes(4, 'little')
        piece += bytes(-(at + 4) % 8) if count else b''
        at += len(piece) + 8 * count
        pieces.append(head + piece if k == 0 else piece)
        form += f'{len(pieces[-1])}s{count}d'
    fixed = Struct('<4siI' + form)
    return lambda *values: fixed.pack(LITTLE_ENDIAN, *values), *pieces
