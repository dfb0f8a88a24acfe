"""Where a damaged log can be read on: at its next chunk, with the topics that are named again at its end."""

from __future__ import annotations

import mmap
import os
import struct
import zlib
from collections.abc import Iterator
from typing import IO

from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

_COMPRESSION = b"\4\0\0\0zstd"
"""In every chunk of ours at the same place: its compression, with the length of that name."""
_CHUNK = struct.Struct("<BQQQQI8sQ")
"""Opcode, length of what follows; first and last time, size and checksum; compression; length of the messages."""
_RECORD = struct.Struct("<BQ")
_FOOTER = struct.Struct("<BQQQI")
"""Opcode, length; where the summary begins, where its offsets do, its checksum."""


def next_chunk(file: IO[bytes], begin: int) -> int | None:
    """Return where the next chunk begins, at a byte or behind it; None if there is none. Its content is not checked."""
    before = _CHUNK.size - len(_COMPRESSION) - 8  # the length of the messages comes behind the compression
    with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        found = data.find(_COMPRESSION, begin + before)
        while found >= 0:
            at = found - before
            if at + _CHUNK.size <= len(data):
                kind, length, *_, messages = _CHUNK.unpack_from(data, at)
                whole = length == _CHUNK.size - _RECORD.size + messages
                if kind == Opcode.CHUNK and whole and at + _RECORD.size + length <= len(data):
                    return at
            found = data.find(_COMPRESSION, found + 1)
    return None


def summary_records(file: IO[bytes]) -> Iterator[tuple[int, bytes]]:
    """Yield the records of the summary behind the messages: opcode and content. Nothing if it is not whole."""
    size = os.fstat(file.fileno()).st_size
    foot = size - len(MCAP0_MAGIC) - _FOOTER.size
    if foot < 0:
        return
    file.seek(foot)
    kind, _, begin, _, crc = _FOOTER.unpack(file.read(_FOOTER.size))
    if kind != Opcode.FOOTER or not 0 < begin <= foot:
        return
    file.seek(begin)
    section = file.read(foot + _FOOTER.size - 4 - begin)
    if zlib.crc32(section) != crc:
        return
    at = 0
    while at < foot - begin:
        kind, length = _RECORD.unpack_from(section, at)
        at += _RECORD.size + length
        yield kind, section[at - length : at]
