"""Every decoder of a stream: bytes split anywhere, damaged, lost, mixed with noise, hostile; see `streams`."""

from __future__ import annotations

import dataclasses
import random
import tracemalloc

import pytest
from sternplane.fuzz.mutation import mutated

from .streams import STREAMS, Stream

SEED = 1000
streams = pytest.mark.parametrize("stream", STREAMS.values(), ids=STREAMS)


def whole(stream: Stream) -> bytes:
    """Return all pieces one after the other."""
    return b"".join(stream.pieces)


@streams
def test_bytes_split_at_every_position(stream: Stream) -> None:
    content, expected = whole(stream), [*stream.messages]
    for at in range(len(content) + 1):
        decoder = stream.decoder()
        assert [*decoder.feed(content[:at]), *decoder.feed(content[at:])] == expected
        assert (decoder.counts.good, decoder.counts.other) == (
            len(stream.messages),
            len(stream.pieces) - len(stream.messages),
        )
    decoder = stream.decoder()
    assert [message for k in range(len(content)) for message in decoder.feed(content[k : k + 1])] == expected


@streams
def test_a_damaged_bit_loses_no_message_but_its_own(stream: Stream) -> None:
    """The piece before it and the second one behind it are read; the next one may have lost its beginning."""
    first, around = stream.pieces[0], stream.pieces[0] * 3
    [message] = stream.decoder().feed(first)
    for at in range(len(first)):
        for bit in (0, 3, 7):
            damaged = bytearray(first)
            damaged[at] ^= 1 << bit
            decoder = stream.decoder()
            found = [*decoder.feed(first + bytes(damaged) + around + bytes(LONG))]
            assert found[0] == found[-1] == message
            assert found.count(message) >= 3
            assert len(found) <= 5


LONG = 70_000
"""So many zeros end what waits for a longest message."""


@streams
def test_bytes_lost_within_a_message_lose_no_message_but_the_next(stream: Stream) -> None:
    first = stream.pieces[0]
    [message] = stream.decoder().feed(first)
    for lost in (1, 2, 5, len(first) // 2):
        for at in range(len(first) - lost):
            decoder = stream.decoder()
            found = decoder.feed(first[:at] + first[at + lost :] + first * 3 + bytes(LONG))
            assert found[-1] == message
            assert len(found) >= 2


@streams
def test_a_line_that_was_opened_anew_does_not_end_the_message_of_before(stream: Stream) -> None:
    first = stream.pieces[0]
    decoder = stream.decoder()
    decoder.feed(first[: len(first) // 2])
    decoder.restart()
    assert decoder.feed(first) == stream.decoder().feed(first)
    assert decoder.counts.good == 1


@streams
def test_random_bytes_raise_nothing_and_take_bounded_memory(stream: Stream) -> None:
    source, decoder = random.Random(SEED), stream.decoder()
    tracemalloc.start()
    for _ in range(400):
        decoder.feed(source.randbytes(100))
    kept, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert kept < 100_000


@streams
def test_mutated_messages_raise_nothing(stream: Stream) -> None:
    """Bytes of good messages are changed, doubled, removed, swapped; a good one is read behind them."""
    source, decoder, content = random.Random(SEED), stream.decoder(), whole(stream)
    [message] = stream.decoder().feed(stream.pieces[0])
    for _ in range(1000):
        decoder.feed(mutated(source, content))
    assert decoder.feed(bytes(LONG) + b"\n" + stream.pieces[0])[-1] == message
    assert sum(dataclasses.astuple(decoder.counts)) > 500
