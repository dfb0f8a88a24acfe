"""The chunk of a log that is being filled, with the library's bytes for a third of its processor time."""

from __future__ import annotations

import itertools
import struct

from mcap._chunk_builder import ChunkBuilder
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Message, MessageIndex

_HEAD = struct.Struct("<BQHIQQ")
"""Of a message's record: opcode, length of what follows, channel, sequence, log time, publish time."""
_INDEX_HEAD = struct.Struct("<BQHI")
"""Of an index: opcode, length of what follows, channel, bytes of its entries."""
_FRONT = struct.calcsize("<BQ")
"""Bytes of opcode and length, which the length does not count."""


class MessageChunk(ChunkBuilder):
    """A chunk for `mcap.writer.Writer`: the library writes a message in nine pieces, this class in one."""

    def add_message(self, message: Message) -> None:
        """Add a message; times do not decrease."""
        channel, time, data = message.channel_id, message.log_time, message.data
        if not self.num_messages:
            self.message_start_time = time
        self.message_end_time = time
        self.num_messages += 1
        if channel not in self.message_indices:
            self.message_indices[channel] = _PackedIndex(channel, [])
        self.message_indices[channel].records.append((time, self.count))
        length = _HEAD.size - _FRONT + len(data)
        head = _HEAD.pack(Opcode.MESSAGE, length, channel, message.sequence, time, message.publish_time)
        self.record_writer.write(head + data)


class _PackedIndex(MessageIndex):
    """Where the messages of a channel are in a chunk, written in one piece."""

    def write(self, stream: RecordBuilder) -> None:
        entries = struct.pack(f"<{2 * len(self.records)}Q", *itertools.chain.from_iterable(self.records))
        length = _INDEX_HEAD.size - _FRONT + len(entries)
        stream.write(_INDEX_HEAD.pack(Opcode.MESSAGE_INDEX, length, self.channel_id, len(entries)) + entries)
