"""A publisher that knows how long its longest publish took: the loop stands still for as long."""

import time
from typing import Any

from rclpy.publisher import Publisher

from wholearm_ros.ros.interface import channels


class LongestPublish:
    """Of all publishers of a node: duration [ns] and topic."""

    def __init__(self) -> None:
        self.duration, self.topic = 0, ''

    def figures(self) -> dict[str, Any]:
        """For /diagnostics."""
        return {'longest publish ms': self.duration / 1e6, 'longest publish topic': self.topic}


class MeasuredPublisher:
    """Publishes on `topic` and notes in `longest` how long that took."""

    def __init__(
        self, publisher: Publisher, topic: channels.Topic, longest: LongestPublish
    ) -> None:
        self._publisher, self._topic, self._longest = publisher, topic.name, longest

    def publish(self, message: Any) -> None:
        """A message object, or the bytes of a serialized one."""
        began = time.monotonic_ns()
        self._publisher.publish(message)
        duration = time.monotonic_ns() - began
        if duration > self._longest.duration:
            self._longest.duration, self._longest.topic = duration, self._topic

    def get_subscription_count(self) -> int:
        """How many subscriptions there are in the graph that match."""
        return int(self._publisher.get_subscription_count())
