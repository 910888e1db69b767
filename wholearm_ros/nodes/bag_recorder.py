"""Records the topics of a run into a rosbag2 bag, as the bytes they came in."""

import sqlite3
import sys
import time
from datetime import datetime
from pathlib import Path

from rclpy.qos import QoSProfile
from rosbags.rosbag2 import WriterError

from wholearm_ros.bag.types import jazzy_typestore
from wholearm_ros.bag.writer import STORAGES, BagWriter
from wholearm_ros.errors import BagError
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.bag_types import offered, type_name
from wholearm_ros.ros.interface.parameters import Declared
from wholearm_ros.ros.node.node import ERROR, OK, WholeArmNode
from wholearm_ros.ros.node.run import run_node

DECLARED = (
    Declared(
        'path',
        '',
        'directory of the bag, made by the recorder; empty: wholearm_<date and time> here',
    ),
    Declared('storage', 'mcap', 'format of the bag', choices=tuple(STORAGES)),
    Declared(
        'topics', [''], 'topics of the graph to record, by their names in docs/ros.md; empty: all'
    ),
    Declared(
        'checkpoint_period',
        0.5,
        'between two moments at which everything is on disk [s]',
        0.05,
        60.0,
    ),
)
QUEUE = 5000  # messages of one topic that may wait while a checkpoint is written


class BagRecorder(WholeArmNode):
    """Every topic of the graph → bag. A recorder that is killed loses what came after its last checkpoint."""

    leave_within = 10.0

    def __init__(self):
        super().__init__('bag_recorder', DECLARED)
        p = self.parameters
        self.path = Path(p.path or datetime.now().strftime('wholearm_%Y_%m_%d-%H_%M_%S'))
        self.recorded, self.problem, self.slowest = 0, '', 0.0
        topics = self.chosen([t for t in p.topics if t])

        self.bag = BagWriter(self.path, p.storage) if not self.path.exists() else None
        if self.bag is None:
            raise BagError(
                f'path: {self.path} exists; allowed: a directory that does not exist yet'
            )
        try:
            self.bag.open()
        except (OSError, WriterError, sqlite3.Error) as error:
            raise BagError(f'path: {self.path} cannot be written: {error}') from error

        store = jazzy_typestore()
        for topic in topics:
            self.record(topic, store)
        self.every(p.checkpoint_period, self.checkpoint)
        self.get_logger().info(f'recording {len(topics)} topics into {self.path}')

    def chosen(self, names):
        known = {t.name: t for t in channels.RECORDED}
        wrong = [n for n in names if n not in known]
        if wrong:
            raise BagError(f'topics: got {wrong}; allowed: {", ".join(known)}')
        return [known[n] for n in names] or list(channels.RECORDED)

    def record(self, topic: channels.Topic, store):
        connection = self.bag.add_connection(
            self.resolve_topic_name(topic.name),
            type_name(topic.type),
            typestore=store,
            offered_qos_profiles=[offered(topic.qos)],
        )
        qos = QoSProfile(
            depth=QUEUE, reliability=topic.qos.reliability, durability=topic.qos.durability
        )
        write, clock = self.bag.write, time.time_ns

        def keep(data: bytes):
            if not self.problem:
                write(connection, clock(), data)
                self.recorded += 1

        self.create_subscription(topic.type, topic.name, keep, qos, raw=True)

    def checkpoint(self):
        began = time.monotonic()
        self.to_disk(self.bag.checkpoint)
        self.slowest = max(self.slowest, time.monotonic() - began)

    def to_disk(self, write):
        if self.problem:
            return
        try:
            write()
        except (OSError, sqlite3.Error) as error:
            self.problem = f'{self.path}: cannot be written: {error}; the bag ends here'
            self.get_logger().error(self.problem)

    def leave(self):
        self.to_disk(self.bag.close)
        self.get_logger().info(f'{self.recorded} messages in {self.path}')

    def health(self):
        values = {
            'path': self.path,
            'messages': self.recorded,
            'slowest checkpoint ms': 1e3 * self.slowest,
        }
        return (ERROR, self.problem, values) if self.problem else (OK, 'recording', values)


def main():
    sys.exit(run_node(BagRecorder))


if __name__ == '__main__':
    main()
