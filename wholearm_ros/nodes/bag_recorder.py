"""Records the topics of a run into a rosbag2 bag, as the bytes they came in."""

import sys
import time
from datetime import datetime
from pathlib import Path
from typing import Any

from rclpy.qos import QoSProfile
from rosbags.typesys.store import Typestore

from wholearm_ros.bag.background_writer import BackgroundWriter
from wholearm_ros.bag.types import jazzy_typestore
from wholearm_ros.bag.writer import STORAGES
from wholearm_ros.errors import BagError
from wholearm_ros.model.choices import Storage
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.bag_types import offered, type_name
from wholearm_ros.ros.interface.parameters import Declared
from wholearm_ros.ros.node.node import ERROR, OK, WARN, Health, WholeArmNode
from wholearm_ros.ros.node.run import run_node

DECLARED = (
    Declared(
        'path',
        '',
        'directory of the bag, made by the recorder; empty: wholearm_<date and time> here',
    ),
    Declared('storage', Storage.mcap.value, 'format of the bag', choices=tuple(STORAGES)),
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
QUEUE = 5000  # messages of one topic that may wait for this process in the middleware
SWITCH_INTERVAL = 0.0002  # [s] for which the writing thread may keep the receiving one waiting


class BagRecorder(WholeArmNode):
    """Every topic of the graph → bag. Killed, it loses what came after its last checkpoint."""

    leave_within = 2.5

    def __init__(self) -> None:
        super().__init__('bag_recorder', DECLARED)
        sys.setswitchinterval(SWITCH_INTERVAL)
        p = self.parameters
        path = Path(p.path or datetime.now().strftime('wholearm_%Y_%m_%d-%H_%M_%S'))
        topics = _chosen([t for t in p.topics if t])
        self.told_problem = False
        self.bag = BackgroundWriter(path, p.storage)
        store = jazzy_typestore()
        for topic in topics:
            self.record(topic, store)
        self.every(p.checkpoint_period, self.checkpoint)
        self.get_logger().info(f'recording {len(topics)} topics into {path}')

    def record(self, topic: channels.Topic, store: Typestore) -> None:
        """From now on every message of `topic` goes into the bag."""
        connection = self.bag.add_connection(
            self.resolve_topic_name(topic.name),
            type_name(topic.type),
            typestore=store,
            offered_qos_profiles=[offered(topic.qos)],
        )
        qos = QoSProfile(
            depth=QUEUE, reliability=topic.qos.reliability, durability=topic.qos.durability
        )
        put, clock = self.bag.put, time.time_ns

        def keep(data: Any) -> None:  # bytes: the subscription is raw
            put(connection, clock(), data)

        self.create_subscription(topic.type, topic.name, keep, qos, raw=True)

    def checkpoint(self) -> None:
        """Begun here, done by the writing thread."""
        self.bag.checkpoint()
        if self.bag.problem and not self.told_problem:
            self.told_problem = True
            self.get_logger().error(self.bag.problem)

    def leave(self) -> None:
        """Closes the bag."""
        self.bag.close()
        self.get_logger().info(f'{self.bag.recorded} messages in {self.bag.path}')

    def health(self) -> Health:
        """Warns of lost messages, and of a bag that had to end."""
        bag = self.bag
        values = {
            'path': bag.path,
            'messages': bag.recorded,
            'lost messages': bag.lost,
            'most waiting messages': bag.most_waiting,
            'slowest checkpoint ms': 1e3 * bag.slowest,
        }
        if bag.problem:
            return ERROR, bag.problem, values
        return (WARN, 'messages were lost', values) if bag.lost else (OK, 'recording', values)


def _chosen(names: list[str]) -> list[channels.Topic]:
    """Topics by name, all when none is given; raises BagError."""
    known = {t.name: t for t in channels.RECORDED}
    wrong = [n for n in names if n not in known]
    if wrong:
        raise BagError(f'topics: got {wrong}; allowed: {", ".join(known)}')
    return [known[n] for n in names] or list(channels.RECORDED)


def main() -> None:
    """The executable."""
    run_node(BagRecorder)


if __name__ == '__main__':
    main()
