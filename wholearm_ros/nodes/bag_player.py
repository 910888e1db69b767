"""Plays a bag back: its messages on their topics, with their timing, byte by byte."""

import importlib
import threading
import time
from pathlib import Path
from typing import Any, Optional

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbags.interfaces import Connection, QosDurability, QosReliability
from rosgraph_msgs.msg import Clock

from wholearm_ros.bag.reader import Bag
from wholearm_ros.errors import BagError
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.joint_state_serialization import NANOSECONDS
from wholearm_ros.ros.interface.messages import set_stamp
from wholearm_ros.ros.interface.parameters import Declared
from wholearm_ros.ros.node.node import OK, Health, WholeArmNode
from wholearm_ros.ros.node.run import run_node

DECLARED = (
    Declared('path', '', 'directory of the bag'),
    Declared('rate', 1.0, 'factor on the speed', 0.001, 1000.0),
    Declared(
        'start',
        0.0,
        'where to begin in the bag [s]; the newest latched message of before is sent first',
        0.0,
        1e6,
    ),
    Declared('topics', [''], 'ends of the names of the topics to play; empty: all'),
    Declared(
        'clock',
        0.0,
        'rate of /clock in the time of the bag [Hz]; 0: none (a recorded one is played as it is)',
        0.0,
        10000.0,
    ),
    Declared(
        'wait_for_subscribers',
        0.0,
        'for as long as there is a topic without, at most [s]',
        0.0,
        600.0,
    ),
    Declared('stay', False, 'keep latched topics after the end'),
)
PIECE = 0.1  # [s] longest sleep, so that a signal is heard


class BagPlayer(WholeArmNode):
    """bag → topics."""

    def __init__(self) -> None:
        super().__init__('bag_player', DECLARED)
        p, self.played, self.done, self.leaving = self.parameters, 0, False, False
        self.bag = Bag(Path(p.path)).__enter__()
        if self.bag.cut:
            self.get_logger().warning(
                f'{", ".join(self.bag.cut)} was cut off; played up to its last whole record'
            )
        ends = [t for t in p.topics if t]
        self.connections = [
            c
            for c in self.bag.connections
            if not ends or any(c.topic == e or c.topic.endswith('/' + e) for e in ends)
        ]
        if not self.connections:
            raise BagError(
                f'topics: none of {ends} is in the bag; '
                f'allowed: {[c.topic for c in self.bag.connections]}'
            )
        self.outlets = {
            c.id: self.create_publisher(message_class(c.msgtype), c.topic, qos_of(c))
            for c in self.connections
        }
        self.latched = {c.id for c in self.connections if is_latched(c)}
        self.clock = self.publisher(channels.CLOCK) if p.clock else None
        self.thread = threading.Thread(target=self.play, daemon=True)
        self.thread.start()

    def play(self) -> None:
        """Of the thread: every message at its time."""
        self.wait_for_subscribers()
        begin = self.bag.start + round(self.parameters.start * NANOSECONDS)
        held: dict[int, bytes] = {}
        origin: Optional[int] = None
        for connection, at, data in self.bag.raw(self.connections):
            if at < begin:
                if connection.id in self.latched:
                    held[connection.id] = bytes(data)
                continue
            if origin is None:
                origin = time.monotonic_ns()
                for key, old in held.items():
                    self.outlets[key].publish(old)
            if not self.sleep_until(begin, at, origin):
                return
            self.outlets[connection.id].publish(bytes(data))
            self.played += 1
        self.get_logger().info(f'played {self.played} messages')
        self.done = True

    def sleep_until(self, begin: int, at: int, origin: int) -> bool:
        """Until the time of the bag is `at` [ns]; False when the node leaves meanwhile."""
        rate, now = self.parameters.rate, begin
        while not self.leaving:
            now = begin + round((time.monotonic_ns() - origin) * rate)
            step = (at - now) / NANOSECONDS / rate
            if step <= 0:
                return True
            if self.clock:
                self.publish_clock(now)
                step = min(step, 1.0 / self.parameters.clock / rate)
            time.sleep(min(step, PIECE))
        return False

    def publish_clock(self, now: int) -> None:
        """now: time of the bag [ns]."""
        assert self.clock is not None
        message = Clock()
        set_stamp(message.clock, now)
        self.clock.publish(message)

    def wait_for_subscribers(self) -> None:
        """Until every topic has one, at most `wait_for_subscribers`."""
        deadline = time.monotonic() + self.parameters.wait_for_subscribers
        while time.monotonic() < deadline and not self.leaving:
            if all(outlet.get_subscription_count() for outlet in self.outlets.values()):
                return
            time.sleep(0.01)

    def finished(self) -> bool:
        """At the end of the bag, unless latched topics shall stay."""
        return self.done and not self.parameters.stay

    def health(self) -> Health:
        """How many messages were played."""
        return (
            OK,
            'done' if self.done else 'playing',
            {'path': self.parameters.path, 'messages': self.played},
        )

    def leave(self) -> None:
        """Stops playing."""
        self.leaving = True
        self.thread.join(0.5)


def message_class(name: str) -> type:
    """The class of 'std_msgs/msg/String'. Raises BagError."""
    package, kind, message = name.split('/')
    try:
        found: type = getattr(importlib.import_module(f'{package}.{kind}'), message)
    except (ImportError, AttributeError) as error:
        raise BagError(f'message type {name}: not installed here') from error
    return found


def _offered(connection: Connection) -> list[Any]:
    """The offered qualities of service."""
    extension: Any = connection.ext
    return list(extension.offered_qos_profiles)


def is_latched(connection: Connection) -> bool:
    """Whether late subscribers got its last message, too."""
    return any(q.durability == QosDurability.TRANSIENT_LOCAL for q in _offered(connection))


def qos_of(connection: Connection) -> QoSProfile:
    """As the bag says it was offered, but deep: nothing shall be lost on the way."""
    best_effort = any(q.reliability == QosReliability.BEST_EFFORT for q in _offered(connection))
    return QoSProfile(
        depth=1 if is_latched(connection) else 1000,
        reliability=ReliabilityPolicy.BEST_EFFORT if best_effort else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL
        if is_latched(connection)
        else DurabilityPolicy.VOLATILE,
    )


def main() -> None:
    """The executable."""
    run_node(BagPlayer)


if __name__ == '__main__':
    main()
