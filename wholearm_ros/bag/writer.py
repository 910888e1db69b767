"""A bag that is whole on disk at all times: rosbags' writer with checkpoints."""

import copy
import os
from io import BytesIO
from pathlib import Path

from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.rosbag2.storage_mcap import McapWriter
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Writer

STORAGES = {'mcap': StoragePlugin.MCAP, 'sqlite3': StoragePlugin.SQLITE3}


class _Pending(BytesIO):
    """What was written since the last checkpoint; tells positions in the file, of which `before` bytes are on disk."""

    def __init__(self, before: int):
        super().__init__()
        self.before = before

    def tell(self) -> int:
        return self.before + super().tell()


class _McapStorage(McapWriter):
    """Keeps what is new in memory; a checkpoint writes it and an index behind it with one system call.

    The next checkpoint overwrites that index. A process killed between two checkpoints leaves a complete file.
    """

    def __init__(self, path, compression):
        super().__init__(path, compression)
        self.bio.flush()
        self._file, self.bio = self.bio, _Pending(self.bio.tell())
        self._index = b''  # behind the data on disk

    def close(self, version: int, metadata: str):
        """Of the copy that Writer.close closes: the tail goes behind the data and the file stays open."""
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

    def _put(self, data: bytes, start: int):
        """The file ends with `data` after this."""
        descriptor = self._file.fileno()
        _write_at(descriptor, data, start)
        os.ftruncate(descriptor, start + len(data))

    def end(self):
        self._file.close()


class _Kept(_Pending):
    """Keeps its bytes when it is closed."""

    def close(self):
        self.kept = self.getvalue()
        super().close()


class _SqliteStorage(Sqlite3Writer):
    """A checkpoint commits; the metadata row is the newest one only."""

    def close(self, version: int, metadata: str):
        self.cursor.execute('DELETE FROM metadata')
        self.cursor.execute(
            'INSERT INTO metadata(metadata_version, metadata) VALUES(?, ?)', (version, metadata)
        )
        self.conn.commit()

    def end(self):
        self.conn.close()


class BagWriter(Writer):
    """A rosbag2 writer (version 9) whose bag can be read at every moment up to its last checkpoint."""

    STORAGE_PLUGINS = {StoragePlugin.MCAP: _McapStorage, StoragePlugin.SQLITE3: _SqliteStorage}

    def __init__(self, path: Path, storage: str = 'mcap'):
        super().__init__(path, version=9, storage_plugin=STORAGES[storage])

    def checkpoint(self):
        """Everything written so far, its index and metadata.yaml are on disk after this."""
        snapshot = copy.copy(self)
        Writer.close(snapshot)

    def close(self):
        storage = self.storage
        Writer.close(self)
        storage.end()


def _write_at(descriptor: int, data: bytes, position: int):
    view = memoryview(data)
    while view:
        written = os.pwrite(descriptor, view, position)
        view, position = view[written:], position + written
