"""Reading a bag of a run: messages by topic, whatever its namespace; one that was cut off is read up to the cut."""

from contextlib import ExitStack
from pathlib import Path
from typing import Iterator, List, Tuple

import numpy as np
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.interfaces import Connection

from wholearm_ros.bag.mcap_repair import cut_files, opened_whole
from wholearm_ros.bag.types import jazzy_typestore
from wholearm_ros.errors import BagError

NANOSECONDS = 1_000_000_000  # in a second


class Bag:
    """A context around an open bag; raises BagError when it cannot be read. cut: names of files whose end is missing."""

    def __init__(self, path: Path):
        self.path, self.store = Path(path), jazzy_typestore()
        if not self.path.exists():
            raise BagError(f'{path}: no such bag; allowed: the directory of a rosbag2 bag')
        self.cut, self._open = [file.name for file in cut_files(self.path)], ExitStack()

    def __enter__(self):
        try:
            path = self._open.enter_context(opened_whole(self.path))
            self._reader = self._open.enter_context(AnyReader([path], default_typestore=self.store))
        except (AnyReaderError, OSError, ValueError, KeyError, AssertionError) as error:
            self._open.close()
            raise BagError(f'{self.path}: cannot be read as a bag: {error}') from error
        return self

    def __exit__(self, *_):
        self._open.close()

    @property
    def connections(self) -> List[Connection]:
        return self._reader.connections

    @property
    def start(self) -> int:
        """Time of the first message [ns]."""
        return self._reader.start_time

    def raw(self, connections=None) -> Iterator[Tuple[Connection, int, bytes]]:
        """(connection, time [ns], serialized message) in the order of time."""
        yield from self._reader.messages(self.connections if connections is None else connections)

    def messages(self, topic: str) -> list:
        """Every message of `topic`, given relative to the namespace ('joint_states') or absolute ('/clock')."""
        chosen = [c for c in self.connections if c.topic == topic or c.topic.endswith('/' + topic)]
        return (
            [self._reader.deserialize(data, c.msgtype) for c, _, data in self.raw(chosen)]
            if chosen
            else []
        )

    def documents(self, topic: str) -> List[str]:
        """The texts on a std_msgs/String topic."""
        return [m.data for m in self.messages(topic)]

    def joint_table(self, topic: str) -> Tuple[np.ndarray, np.ndarray]:
        """(m,) stamps [s] and (m, 3, 2) position, velocity, effort of joint_states, equal stamps once."""
        rows = {stamp_of(m): (m.position, m.velocity, m.effort) for m in self.messages(topic)}
        stamps = sorted(rows)
        return np.array(stamps) / NANOSECONDS, np.array([rows[s] for s in stamps]).reshape(-1, 3, 2)

    def pose_table(self, topic: str = 'object_pose') -> Tuple[np.ndarray, np.ndarray]:
        """(m,) stamps [s] and (m, 3) x, y [m], rotation [rad], the rotation continuous."""
        rows = {stamp_of(m): _planar(m.pose) for m in self.messages(topic)}
        stamps = sorted(rows)
        poses = np.array([rows[s] for s in stamps]).reshape(-1, 3)
        poses[:, 2] = np.unwrap(poses[:, 2])
        return np.array(stamps) / NANOSECONDS, poses


def stamp_of(message) -> int:
    """[ns]"""
    return message.header.stamp.sec * NANOSECONDS + message.header.stamp.nanosec


def _planar(pose):
    q = pose.orientation
    return pose.position.x, pose.position.y, float(np.arctan2(2 * q.w * q.z, q.w**2 - q.z**2))
