"""Writes a bag in a thread of its own: whoever receives the messages only hands them over."""

import sqlite3
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, Optional

from rosbags.interfaces import Connection
from rosbags.rosbag2 import WriterError

from wholearm_ros.bag.writer import BagWriter
from wholearm_ros.errors import BagError

WAITING = 200_000  # messages that may wait to be written: half a minute of a whole graph at 1 kHz


class BackgroundWriter:
    """A bag that is whole on disk after each `checkpoint`, written by one thread of its own.

    recorded, lost: messages written, and dropped because `WAITING` others were waiting;
    most_waiting: at a checkpoint; slowest [s]: the longest checkpoint; problem: why the bag has
    ended, or nothing.
    """

    def __init__(self, path: Path, storage: str) -> None:
        """Raises BagError when the bag cannot be made."""
        self.path, self.recorded, self.lost = path, 0, 0
        self.most_waiting, self.slowest, self.problem = 0, 0.0, ''
        self._waiting: deque[tuple[Connection, int, bytes]] = deque()
        self._thread = ThreadPoolExecutor(1, 'bag')  # sqlite3 wants one and the same for everything
        self._under_way: Optional[Future[None]] = None
        if path.exists():
            raise BagError(f'path: {path} exists; allowed: a directory that does not exist yet')
        self._bag = BagWriter(path, storage)
        try:
            self._thread.submit(self._bag.open).result()
        except (OSError, WriterError, sqlite3.Error) as error:
            raise BagError(f'path: {path} cannot be written: {error}') from error

    def add_connection(self, topic: str, message_type: str, **more: Any) -> Connection:
        """As `rosbags.rosbag2.Writer.add_connection`."""
        return self._thread.submit(self._bag.add_connection, topic, message_type, **more).result()

    def put(self, connection: Connection, when: int, data: bytes) -> None:
        """A serialized message received at `when` [ns]; never waits."""
        if self.problem:
            return
        if len(self._waiting) < WAITING:
            self._waiting.append((connection, when, data))
        else:
            self.lost += 1

    def checkpoint(self) -> None:
        """What was put before this goes to disk soon; unless the checkpoint before is still under
        way.
        """
        if self._under_way is None or self._under_way.done():
            self._under_way = self._thread.submit(self._to_disk, self._bag.checkpoint)

    def close(self) -> None:
        """Everything is on disk after this."""
        self._thread.submit(self._to_disk, self._bag.close).result()
        self._thread.shutdown()

    def _to_disk(self, conclude: Callable[[], None]) -> None:
        """Of the thread: every waiting message, then `conclude`."""
        began, waiting = time.monotonic(), len(self._waiting)
        if self.problem:
            return
        try:
            for _ in range(waiting):
                self._bag.write(*self._waiting.popleft())
            conclude()
        except (OSError, sqlite3.Error) as error:
            self.problem = f'{self.path}: cannot be written: {error}; the bag ends here'
            return
        self.recorded += waiting
        self.most_waiting = max(self.most_waiting, waiting)
        self.slowest = max(self.slowest, time.monotonic() - began)
