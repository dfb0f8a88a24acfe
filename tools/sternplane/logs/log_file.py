"""The messages of a log file in their order, chunk by chunk, up to its end or to where it is cut off or damaged."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import IO, Any, NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile, InvalidMagic, McapError, RecordLengthLimitExceeded
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, DataEnd, Metadata, Schema
from mcap.stream_reader import get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC

from firmware_py.adapters.storage.recorder import END, FORMAT, HEADER, MEMORY, LogError, from_json

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
        memory: what the autopilot remembered when the log began, pickled; empty where it began with the flight.
        lost: "" for a whole log, else one sentence: why it is not, and up to where it was recovered.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.header: dict[str, Any] = {}
        self.end: dict[str, Any] = {}
        self.schemas: dict[str, tuple[str, str]] = {}
        self.memory = b""
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
        try:
            for kind, data in self._records(file):
                if messages := self._taken(kind, data):
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

    def _records(self, file: IO[bytes]) -> Iterator[tuple[int, bytes]]:
        """Yield the records before the index: opcode and content. To come to the end is to know that the log is whole.

        The index is not looked into: the library takes longer for it than for all the rest.
        """
        # A length that was damaged must not be taken for gigabytes to allocate: no record is longer than its file.
        limit = self.path.stat().st_size
        crc = zlib.crc32(_magic(file))
        kind, indexed = 0, False
        while kind != Opcode.FOOTER:
            head = _exactly(file, _RECORD.size)
            kind, length = _RECORD.unpack(head)
            if length > limit:
                raise RecordLengthLimitExceeded(kind, length, limit)
            data = _exactly(file, length)
            if kind == Opcode.DATA_END:
                expected = DataEnd.read(_stream(data)).data_section_crc
                if expected not in (0, crc):
                    raise ValueError(f"crc validation failed, expected: {expected}, calculated: {crc}")
                indexed = True
            elif not indexed:
                crc = zlib.crc32(data, zlib.crc32(head, crc))
                yield kind, data
        _magic(file)

    def _taken(self, kind: int, data: bytes) -> list[LoggedMessage]:
        """Take a record in, and return the messages in it."""
        if not self._begun:
            if kind != Opcode.HEADER:
                self.header, self._begun = _header(self.path, kind, data), True
        elif kind == Opcode.CHUNK:
            return self._messages(Chunk.read(_stream(data)))
        elif kind == Opcode.SCHEMA:
            schema = Schema.read(_stream(data))
            self._schema_of[schema.id] = schema
        elif kind == Opcode.CHANNEL:
            self._open(Channel.read(_stream(data)))
        elif kind == Opcode.ATTACHMENT and (attachment := Attachment.read(_stream(data))).name == MEMORY:
            self.memory = attachment.data
        elif kind == Opcode.METADATA and (metadata := Metadata.read(_stream(data))).name == END:
            self.end = from_json(metadata.metadata["end"])
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
                schema = Schema.read(_stream(data[at:end]))
                self._schema_of[schema.id] = schema
            elif kind == Opcode.CHANNEL:
                self._open(Channel.read(_stream(data[at:end])))
            at = end
        return messages

    def _open(self, channel: Channel) -> None:
        if channel.id not in self._topics:
            self._topics[channel.id] = channel.topic
            schema = self._schema_of[channel.schema_id]
            self.schemas[channel.topic] = schema.name.rpartition("/")[2], schema.data.decode()


def _exactly(file: IO[bytes], size: int) -> bytes:
    data = file.read(size)
    if len(data) < size:
        raise EndOfFile
    return data


def _magic(file: IO[bytes]) -> bytes:
    data = _exactly(file, len(MCAP0_MAGIC))
    if data != MCAP0_MAGIC:
        raise InvalidMagic(data)
    return data


def _stream(data: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(data))


def _header(path: Path, kind: int, data: bytes) -> dict[str, Any]:
    record = Metadata.read(_stream(data)) if kind == Opcode.METADATA else None
    if record is None or record.name != HEADER:
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
