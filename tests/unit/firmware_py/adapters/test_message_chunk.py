"""The chunk that is filled faster has the bytes and the index of the library's own."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st
from mcap._chunk_builder import ChunkBuilder
from mcap.data_stream import RecordBuilder
from mcap.records import Channel, Message, Schema

from firmware_py.adapters.storage.message_chunk import MessageChunk

MESSAGE = st.tuples(
    st.integers(0, 3), st.integers(0, 2**40), st.binary(max_size=40), st.integers(0, 2**63), st.integers(0, 2**32 - 1)
)


def filled(chunk: ChunkBuilder, messages: list[tuple[int, int, bytes, int, int]]) -> tuple[object, ...]:
    """Return all that a writer takes of a chunk."""
    chunk.add_schema(Schema(1, b"float64 value", "ros2msg", "a/Number"))
    chunk.add_channel(Channel(1, "/a", "cdr", {}, 1))
    time = 0
    for channel, later, data, published, sequence in messages:
        time += later
        chunk.add_message(Message(channel, time, data, published, sequence))
    index = RecordBuilder()
    for entry in chunk.message_indices.values():
        entry.write(index)
    size, times = chunk.count, (chunk.message_start_time, chunk.message_end_time)
    return chunk.end(), index.end(), list(chunk.message_indices), size, times, chunk.num_messages


@given(st.lists(st.lists(MESSAGE, max_size=5), max_size=3))
def test_it_is_the_librarys_chunk(chunks: list[list[tuple[int, int, bytes, int, int]]]) -> None:
    ours, theirs = MessageChunk(), ChunkBuilder()
    for messages in chunks:
        assert filled(ours, messages) == filled(theirs, messages)
        ours.reset()
        theirs.reset()
