"""A bag that is whole on disk at all times: rosbags' writer with checkpoints."""

import copy
import os
from io import BytesIO
from pathlib import Path
from typing import Any

from rosbags.interfaces import Connection
from rosbags.rosbag2 import CompressionMode, StoragePlugin, Writer
from rosbags.rosbag2.storage_mcap import McapWriter, write_channel, write_string
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Writer

from wholearm_ros.model.choices import Storage

STORAGES = {Storage.mcap.value: StoragePlugin.MCAP, Storage.sqlite3.value: StoragePlugin.SQLITE3}

TYPE_HASH = 'topic_type_hash'  # in a channel's metadata: RIHS01_ and 64 hexadecimal digits


class _Pending(BytesIO):
    """What was written since the last checkpoint; `tell` counts the `before` bytes on disk, too."""

    def __init__(self, before: int) -> None:
        super().__init__()
        self.before = before

    def tell(self) -> int:
        return self.before + super().tell()


class _McapStorage(McapWriter):
    """Keeps new data in memory; a checkpoint writes it and its index with one system call.

    The next checkpoint overwrites that index. A process killed between two checkpoints leaves a
    complete file.
    """

    bio: Any  # rosbags writes through it

    def __init__(self, path: Path, compression: CompressionMode) -> None:
        super().__init__(path, compression)
        self.bio.flush()
        self._file, self.bio = self.bio, _Pending(self.bio.tell())
        self._index = b''  # behind the data on disk

    def add_connection(self, connection: Connection, offered_qos_profiles: str) -> None:
        """With the hash of its type beside its quality of service, as rosbag2 writes a channel;
        rosbags leaves it out.
        """
        begin = self.chunk.bio.tell()
        super().add_connection(connection, offered_qos_profiles)
        channel, type_hash = self.channels.pop(), BytesIO()
        write_string(type_hash, TYPE_HASH)
        write_string(type_hash, connection.digest)
        self.channels.append(channel._replace(metadata=channel.metadata + type_hash.getvalue()))
        self.chunk.bio.seek(begin)
        write_channel(self.chunk.bio, self.channels[-1], self.schemas)

    def close(self, version: int, metadata: str) -> None:
        """Of the copy that Writer.close closes: a tail behind the data; the file stays open."""
        if self.chunk.bio.tell():
            self.close_chunk()
        data, start = self.bio.getvalue(), self.bio.before
        tail = copy.copy(self)
        tail.bio = _Kept(start + len(data))
        McapWriter.close(tail, version, metadata)
        try:
            self._put(data + tail.bio.kept, start)
        except OSError:  # the disk is full: the old index back to where it was, over what was begun
            self._put(self._index, start)
            raise
        self.bio, self._index = _Pending(start + len(data)), tail.bio.kept

    def _put(self, data: bytes, start: int) -> None:
        """The file ends with `data` after this."""
        descriptor = self._file.fileno()
        _write_at(descriptor, data, start)
        os.ftruncate(descriptor, start + len(data))

    def end(self) -> None:
        self._file.close()


class _Kept(_Pending):
    """Keeps its bytes when it is closed."""

    def close(self) -> None:
        self.kept = self.getvalue()
        super().close()


class _SqliteStorage(Sqlite3Writer):
    """A checkpoint commits; the metadata row is the newest one only."""

    def close(self, version: int, metadata: str) -> None:
        self.cursor.execute('DELETE FROM metadata')
        self.cursor.execute(
            'INSERT INTO metadata(metadata_version, metadata) VALUES(?, ?)', (version, metadata)
        )
        self.conn.commit()

    def end(self) -> None:
        self.conn.close()


class BagWriter(Writer):
    """A rosbag2 writer (version 9) whose bag can be read at all times up to the last checkpoint.

    Raises OSError, sqlite3.Error or rosbags' WriterError when the disk does not take it.
    """

    STORAGE_PLUGINS = {StoragePlugin.MCAP: _McapStorage, StoragePlugin.SQLITE3: _SqliteStorage}

    def __init__(self, path: Path, storage: str = Storage.mcap.value) -> None:
        super().__init__(path, version=9, storage_plugin=STORAGES[storage])

    def checkpoint(self) -> None:
        """Everything written so far, its index and metadata.yaml are on disk after this."""
        snapshot = copy.copy(self)
        Writer.close(snapshot)

    def close(self) -> None:
        """The bag is whole on disk, and its files are closed."""
        storage: Any = self.storage
        Writer.close(self)
        storage.end()


def _write_at(descriptor: int, data: bytes, position: int) -> None:
    view = memoryview(data)
    while view:
        written = os.pwrite(descriptor, view, position)
        view, position = view[written:], position + written
