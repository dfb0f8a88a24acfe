"""The messages of a log file in their order, chunk by chunk, up to its end or to where it is cut off or damaged."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import IO, Any, NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile, InvalidMagic, McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, DataEnd, Header, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, get_chunk_data_stream

from firmware_py.adapters.storage.recorder import END, FORMAT, HEADER, LogError, from_json

DAMAGE = (McapError, ValueError, LookupError, struct.error, zstandard.ZstdError, RuntimeError, MemoryError)
"""What the mcap library and we raise on bytes that were not all written, or were changed since."""

_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<H4xQ8x")


class LoggedMessage(NamedTuple):
    """A message: its topic, vehicle time in ns, bytes."""

    topic: str
    time: int
    data: bytes


class LogFile:
    """A log file that is read once, from its begin to its end.

    Attributes:
        path: the file.
        header: the document its writer began with; empty before it was read.
        end: how the run ended; empty unless the writer closed the log, and before that was read.
        schemas: topic -> (name of the message, text of its schema), as they have come so far.
        lost: "" for a whole log, else one sentence: why it is not, and up to where it was recovered.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.header: dict[str, Any] = {}
        self.end: dict[str, Any] = {}
        self.schemas: dict[str, tuple[str, str]] = {}
        self.lost = ""
        self._begun = False
        self._last = 0
        self._schema_of: dict[int, Schema] = {}
        self._topics: dict[int, str] = {}

    def chunks(self) -> Iterator[list[LoggedMessage]]:
        """Yield the messages of every whole chunk.

        Raises:
            LogError: no such file, not a log of ours, another format, or nothing to recover.
        """
        if self.path.is_fifo():  # opening one would wait for a writer
            raise LogError(f"{self.path}: is a FIFO, not a log")
        try:
            with self.path.open("rb") as file:
                yield from self._read(file)
        except OSError as error:
            raise LogError(f"{self.path}: the log cannot be read ({error.strerror})") from None

    def _read(self, file: IO[bytes]) -> Iterator[list[LoggedMessage]]:
        # A length that was damaged must not be taken for gigabytes to allocate: no record is longer than its file.
        limit = self.path.stat().st_size
        reader = StreamReader(_Exact(file), emit_chunks=True, validate_crcs=True, record_size_limit=limit)  # type: ignore[arg-type]
        records = reader.records
        data_ended = False
        try:
            for record in records:
                if data_ended:
                    continue  # only the index follows; to come to its end is to know that the log is whole
                if isinstance(record, DataEnd):
                    data_ended = True
                elif messages := self._taken(record):
                    self._last = max(self._last, messages[-1].time)
                    yield messages
        except InvalidMagic:
            if not self._begun:
                raise LogError(f"{self.path}: not a log; give the log.mcap of a run") from None
            self.lost = "cut off within its last bytes"
        except EndOfFile:
            self.lost = "cut off"
        except DAMAGE as error:
            self.lost = f"damaged ({error})"
        if not self._begun:
            raise LogError(f"{self.path}: {self.lost or 'empty'}, before its header is whole; nothing can be recovered")
        if self.lost:
            self.lost = f"{self.lost}; recovered up to {self._last * 1e-9:.2f} s"

    def _taken(self, record: McapRecord) -> list[LoggedMessage]:
        """Take a record in, and return the messages in it."""
        if not self._begun:
            if not isinstance(record, Header):
                self.header, self._begun = _header(self.path, record), True
        elif isinstance(record, Chunk):
            return self._messages(record)
        elif isinstance(record, Message):
            return [LoggedMessage(self._topics[record.channel_id], record.log_time, record.data)]
        elif isinstance(record, Schema):
            self._schema_of[record.id] = record
        elif isinstance(record, Channel):
            self._open(record)
        elif isinstance(record, Metadata) and record.name == END:
            self.end = from_json(record.metadata["end"])
        return []

    def _messages(self, chunk: Chunk) -> list[LoggedMessage]:
        stream, size = get_chunk_data_stream(chunk, validate_crc=True)
        data, at, topics = stream.read(size), 0, self._topics
        messages: list[LoggedMessage] = []
        while at < size:
            kind, length = _RECORD.unpack_from(data, at)
            at += _RECORD.size
            end = at + length
            if end > size:
                raise EndOfFile
            if kind == Opcode.MESSAGE:
                channel, time = _MESSAGE.unpack_from(data, at)
                messages.append(LoggedMessage(topics[channel], time, data[at + _MESSAGE.size : end]))
            elif kind == Opcode.SCHEMA:
                schema = Schema.read(ReadDataStream(BytesIO(data[at:end])))
                self._schema_of[schema.id] = schema
            elif kind == Opcode.CHANNEL:
                self._open(Channel.read(ReadDataStream(BytesIO(data[at:end]))))
            at = end
        return messages

    def _open(self, channel: Channel) -> None:
        if channel.id not in self._topics:
            self._topics[channel.id] = channel.topic
            schema = self._schema_of[channel.schema_id]
            self.schemas[channel.topic] = schema.name.rpartition("/")[2], schema.data.decode()


class _Exact:
    """A file that gives what was asked or raises, where files give what there is."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file

    def read(self, size: int) -> bytes:
        data = self._file.read(size)
        if len(data) < size:
            raise EndOfFile
        return data


def _header(path: Path, record: McapRecord) -> dict[str, Any]:
    if not isinstance(record, Metadata) or record.name != HEADER:
        raise LogError(f"{path}: an MCAP file, but not a log of ours; give the log.mcap of a run")
    header: dict[str, Any] = from_json(record.metadata.get("header", "{}"))
    found = record.metadata.get("format")
    if found != str(FORMAT):
        revision = header.get("git", "unknown")
        raise LogError(
            f"{path}: log of another version: revision {revision} wrote it in format {found}, and this program reads"
            f" format {FORMAT}; read it with that revision"
        )
    return header
