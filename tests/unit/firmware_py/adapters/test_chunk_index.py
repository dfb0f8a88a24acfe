"""The index of a log's chunks while the log is written: it must be small, and what the library would have kept."""

from __future__ import annotations

import tracemalloc
from pathlib import Path
from typing import NamedTuple

from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.records import Chunk, ChunkIndex
from mcap.stream_reader import StreamReader

from firmware_py.adapters.storage.chunk_index import ChunkIndexes
from firmware_py.adapters.storage.recorder import LogWriter

LENGTH, PLACE = st.integers(0, 2**32 - 1), st.integers(0, 2**60)
INDEX = st.builds(
    lambda start, length, channels, times, lengths: ChunkIndex(
        chunk_length=length,
        chunk_start_offset=start,
        compression="zstd",
        compressed_size=lengths[0],
        message_end_time=times[1],
        message_index_length=lengths[1],
        message_index_offsets={channel: start + length + offset for channel, offset in channels.items()},
        message_start_time=times[0],
        uncompressed_size=lengths[2],
    ),
    PLACE,
    LENGTH,
    st.dictionaries(st.integers(0, 65535), LENGTH, max_size=4),
    st.tuples(PLACE, PLACE),
    st.tuples(LENGTH, LENGTH, LENGTH),
)


class Number(NamedTuple):
    value: float


@given(st.lists(INDEX, max_size=5))
def test_what_is_appended_comes_back(written: list[ChunkIndex]) -> None:
    indexes = ChunkIndexes()
    for index in written:
        indexes.append(index)
    assert list(indexes) == written


def test_an_index_leads_to_every_chunk(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    write(path, 40)
    with path.open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
        assert summary is not None
        assert len(summary.chunk_indexes) == 40
        for k, index in enumerate(summary.chunk_indexes):
            file.seek(index.chunk_start_offset)
            chunk = next(StreamReader(file, skip_magic=True, emit_chunks=True).records)  # type: ignore[arg-type]
            assert isinstance(chunk, Chunk)
            assert chunk.message_start_time == chunk.message_end_time == index.message_start_time == k * 500_000_000
            assert (len(chunk.data), chunk.uncompressed_size) == (index.compressed_size, index.uncompressed_size)


def test_an_hour_of_chunks_takes_less_than_half_a_megabyte(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    log = LogWriter(path, {})
    log.channel("/a", Number(0.0))
    log.channel("/b", Number(0.0))
    tracemalloc.start()
    try:
        for k in range(7200):
            log.write("/a", k * 500_000_000, Number(0.5 * k))
            log.write("/b", k * 500_000_000, Number(1.0))
            if k == 100:
                begun, _ = tracemalloc.get_traced_memory()
        ended, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    log.close()
    assert ended - begun < 500_000


def write(path: Path, chunks: int) -> None:
    with LogWriter(path, {}) as log:
        log.channel("/a", Number(0.0))
        for k in range(chunks):
            log.write("/a", k * 500_000_000, Number(0.5 * k))
