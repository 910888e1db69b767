"""A reader of bags: messages by topic in any namespace, up to the cut of a bag that was cut off."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Optional

import numpy as np
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.interfaces import Connection

from wholearm_ros.bag.mcap_repair import cut_files, opened_whole
from wholearm_ros.bag.types import jazzy_typestore
from wholearm_ros.errors import BagError

NANOSECONDS = 1_000_000_000  # in a second
UNREADABLE = (AnyReaderError, OSError, ValueError, KeyError, AssertionError)  # of rosbags
Timed = list[tuple[int, Any]]  # (log time [ns], message)


class Bag:
    """A context around an open bag; raises BagError when it cannot be read.

    cut: names of files whose end is missing.
    """

    def __init__(self, path: Path) -> None:
        self.path, self.store = Path(path), jazzy_typestore()
        if not self.path.exists():
            raise BagError(f'{path}: no such bag; allowed: the directory of a rosbag2 bag')
        self.cut = [file.name for file in cut_files(self.path)]

    def __enter__(self) -> 'Bag':
        with self._readable(), opened_whole(self.path) as path:  # which may go: its files are open
            self._reader = AnyReader([path], default_typestore=self.store)
            self._reader.open()
        return self

    def __exit__(self, *_: object) -> None:
        self._reader.close()

    @contextmanager
    def _readable(self) -> Iterator[None]:
        try:
            yield
        except UNREADABLE as error:
            raise BagError(f'{self.path}: cannot be read as a bag: {error}') from error

    @property
    def connections(self) -> list[Connection]:
        """One of each topic."""
        return self._reader.connections

    @property
    def start(self) -> int:
        """Time of the first message [ns]."""
        return self._reader.start_time

    def raw(
        self, connections: Optional[Sequence[Connection]] = None
    ) -> Iterator[tuple[Connection, int, bytes]]:
        """(connection, time [ns], serialized message) in the order of time.

        Of all connections unless some are given.
        """
        chosen = self.connections if connections is None else connections
        if not chosen:  # rosbags takes none for all
            return
        with self._readable():
            yield from self._reader.messages(chosen)

    def timed_messages(self, topics: Sequence[str]) -> dict[str, Timed]:
        """By topic, given relative to the namespace ('joint_states') or absolute ('/clock')."""
        found: dict[str, Timed] = {topic: [] for topic in topics}
        wanted = {
            c.id: topic
            for c in self.connections
            for topic in topics
            if c.topic == topic or c.topic.endswith('/' + topic)
        }
        for connection, when, data in self.raw([c for c in self.connections if c.id in wanted]):
            with self._readable():
                message = self._reader.deserialize(data, connection.msgtype)
            found[wanted[connection.id]].append((when, message))
        return found

    def messages(self, topic: str) -> list[Any]:
        """Every message of `topic`, given as for `timed_messages`."""
        return [message for _, message in self.timed_messages([topic])[topic]]

    def documents(self, topic: str) -> list[str]:
        """The texts on a std_msgs/String topic."""
        return [m.data for m in self.messages(topic)]

    def joint_table(self, topic: str) -> tuple[np.ndarray, np.ndarray]:
        """(m,) stamps [s] and (m, 3, 2) position, velocity, effort; equal stamps once."""
        rows = {stamp_of(m): (m.position, m.velocity, m.effort) for m in self.messages(topic)}
        stamps = sorted(rows)
        return np.array(stamps) / NANOSECONDS, np.array([rows[s] for s in stamps]).reshape(-1, 3, 2)

    def pose_table(self, topic: str = 'object_pose') -> tuple[np.ndarray, np.ndarray]:
        """(m,) stamps [s] and (m, 3) x, y [m], rotation [rad], the rotation continuous."""
        rows = {stamp_of(m): planar_of(m.pose) for m in self.messages(topic)}
        stamps = sorted(rows)
        poses = np.array([rows[s] for s in stamps]).reshape(-1, 3)
        poses[:, 2] = np.unwrap(poses[:, 2])
        return np.array(stamps) / NANOSECONDS, poses


def stamp_of(message: Any) -> int:
    """[ns] of a message with a header."""
    return int(message.header.stamp.sec * NANOSECONDS + message.header.stamp.nanosec)


def planar_of(pose: Any) -> tuple[float, float, float]:
    """x, y [m], rotation [rad] of a geometry_msgs/Pose whose rotation is about z."""
    q = pose.orientation
    turn = float(np.arctan2(2 * q.w * q.z, q.w**2 - q.z**2))
    return pose.position.x, pose.position.y, turn


def values_of(message: Any) -> dict[str, str]:
    """The key/values of a diagnostic_msgs/DiagnosticStatus."""
    return {pair.key: pair.value for pair in message.values}
