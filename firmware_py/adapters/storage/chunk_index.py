"""Where the chunks of a log are, in few bytes for each: the index stays in memory until the log is closed."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import NamedTuple

from mcap.data_stream import RecordBuilder
from mcap.records import ChunkIndex

_CHUNK = struct.Struct("<QQQIIIIB")
_CHANNEL = struct.Struct("<HI")


class ChunkIndexes:
    """The list of chunk indexes that `mcap.writer.Writer` appends to and writes at the end, packed.

    A chunk takes 41 bytes and 6 for each topic, where the library's objects take 700; two chunks a second are 0.4 MB
    an hour. Lengths are below 4 GB; all chunks are compressed alike.
    """

    def __init__(self) -> None:
        self._packed = bytearray()
        self._compression = ""

    def append(self, index: ChunkIndex) -> None:
        """Add one."""
        self._compression, channels = index.compression, index.message_index_offsets
        behind = index.chunk_start_offset + index.chunk_length
        self._packed += _CHUNK.pack(
            index.message_start_time,
            index.message_end_time,
            index.chunk_start_offset,
            index.chunk_length,
            index.message_index_length,
            index.compressed_size,
            index.uncompressed_size,
            len(channels),
        )
        for channel, offset in channels.items():
            self._packed += _CHANNEL.pack(channel, offset - behind)

    def __iter__(self) -> Iterator[ChunkIndex]:
        at = 0
        while at < len(self._packed):
            begin, end, start, length, index_length, compressed, whole, count = _CHUNK.unpack_from(self._packed, at)
            at += _CHUNK.size
            channels = {}
            for _ in range(count):
                channel, offset = _CHANNEL.unpack_from(self._packed, at)
                channels[channel] = start + length + offset
                at += _CHANNEL.size
            yield ChunkIndex(
                chunk_length=length,
                chunk_start_offset=start,
                compression=self._compression,
                compressed_size=compressed,
                message_end_time=end,
                message_index_length=index_length,
                message_index_offsets=channels,
                message_start_time=begin,
                uncompressed_size=whole,
            )


class EncodedIndexes(NamedTuple):
    """Many indexes as the bytes of their records, for the library to write at once."""

    content: bytes

    def write(self, stream: RecordBuilder) -> None:
        """Write them all."""
        stream.write(self.content)
