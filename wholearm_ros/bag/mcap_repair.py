"""Repair of MCAP files that were cut off: the whole records, with an end put behind them.

A killed recorder leaves a complete file (writer.py); a full disk of somebody else's, or
half a copy, does not.
"""

import shutil
import struct
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

MAGIC = b'\x89MCAP0\r\n'
HEAD = struct.Struct('<BQ')  # of a record: its kind, and the length of what follows
FOOTER = HEAD.pack(0x02, 20) + bytes(20) + MAGIC  # without a summary: readers scan the file


def cut_files(bag: Path) -> list[Path]:
    """The MCAP files of a bag that have a beginning and no end."""
    return [path for path in sorted(bag.glob('*.mcap')) if _is_cut(path)]


@contextmanager
def opened_whole(bag: Path) -> Iterator[Path]:
    """The path of the bag, or of a copy for as long as the context lasts, in which cut files end
    with their last whole record.
    """
    cut = cut_files(bag)
    if not cut:
        yield bag
        return
    with tempfile.TemporaryDirectory(prefix='wholearm_bag_') as scratch:
        copied = Path(scratch) / bag.name
        shutil.copytree(bag, copied)
        for path in cut:
            with open(copied / path.name, 'r+b') as file:
                file.truncate(_end_of_whole_records(file))
                file.seek(0, 2)
                file.write(FOOTER)
        yield copied


def _is_cut(path: Path) -> bool:
    with open(path, 'rb') as file:
        begins = file.read(len(MAGIC)) == MAGIC
        file.seek(0, 2)
        file.seek(-min(len(MAGIC), file.tell()), 2)
        return begins and file.read() != MAGIC


def _end_of_whole_records(file: BinaryIO) -> int:
    """Position of the end of the last whole record [bytes]."""
    size = file.seek(0, 2)
    end = file.seek(len(MAGIC))
    while end + HEAD.size <= size:
        _, length = HEAD.unpack(file.read(HEAD.size))
        if end + HEAD.size + length > size:
            break
        end = file.seek(end + HEAD.size + length)
    return end
