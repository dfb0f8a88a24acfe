"""The messages of a log file in their order, chunk by chunk. What is damaged is left out, and said."""

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
from sternplane.logs.salvage import next_chunk, summary_records

DAMAGE = (McapError, ValueError, LookupError, struct.error, zstandard.ZstdError, RuntimeError, MemoryError)
"""What the mcap library and we raise on bytes that were not all written, or were changed since."""

_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<H4xQ8x")
_KINDS = frozenset(
    (Opcode.HEADER, Opcode.SCHEMA, Opcode.CHANNEL, Opcode.CHUNK, Opcode.MESSAGE_INDEX, Opcode.ATTACHMENT)
)
_KINDS |= {Opcode.METADATA, Opcode.DATA_END}
"""What there is before the summary."""
_CHECKED = frozenset((Opcode.CHUNK, Opcode.METADATA))
"""What is read to its end, so that what follows is known to begin there."""
_TOLD = 3
"""So many places are named where a log is damaged."""


class _OtherSum(ValueError):
    """The checksum over all that comes before the index is another, though that of each chunk is right."""


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
        lost: "" for a whole log, else one sentence: why it is not, and what cannot be read, or up to where it can.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.header: dict[str, Any] = {}
        self.end: dict[str, Any] = {}
        self.schemas: dict[str, tuple[str, str]] = {}
        self.memory = b""
        self.lost = ""
        self._begun = False
        self._last = -1
        self._whole = 0
        """Up to this byte all was read, and was sound."""
        self._damaged: list[str] = []
        self._looked_up = False
        self._schema_of: dict[int, Schema] = {}
        self._topics: dict[int, str] = {}

    def chunks(self) -> Iterator[list[LoggedMessage]]:
        """Yield the messages of every whole chunk, those behind damage too.

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
        begin: int | None = 0
        while begin is not None:
            at, resumed, begin = begin, begin > 0, None
            try:
                for kind, data in self._records(file, at):
                    messages = self._taken(kind, data)
                    if messages:
                        if resumed:
                            self._damaged.append(self._gap(at, messages[0].time))
                            resumed, self.lost = False, ""
                        self._last = messages[-1].time
                        yield messages
                    if kind in _CHECKED:
                        self._whole = file.tell()
            except InvalidMagic:
                if not self._begun:
                    raise LogError(f"{self.path}: not a log; give the log.mcap of a run") from None
                self.lost = "cut off within its last bytes"
            except DAMAGE as error:
                self.lost = self._broken(error)
                if self._begun:
                    self._name_topics(file)
                    begin = next_chunk(file, max(self._whole, at + 1 if resumed else 0))
        if not self._begun:
            raise LogError(f"{self.path}: {self.lost or 'empty'}, before its header is whole; nothing can be recovered")
        self._conclude()

    def _broken(self, error: Exception) -> str:
        if isinstance(error, EndOfFile):
            return "cut off"
        where = "outside of its messages" if isinstance(error, _OtherSum) else f"behind byte {self._whole}"
        return f"damaged {where} ({error})"

    def _conclude(self) -> None:
        """Say what of the log is lost."""
        told = self._damaged[:_TOLD]
        if more := len(self._damaged) - len(told):
            told.append(f"damaged at {more} more places")
        if self.lost:
            told += [self.lost, f"recovered up to {max(self._last, 0) * 1e-9:.2f} s"]
        self.lost = "; ".join(told)

    def _gap(self, resumed: int, until: int) -> str:
        """Return what damage before a chunk has taken.

        Raises:
            ValueError: the chunk is a copy of one that was read.
        """
        if until <= self._last:
            raise ValueError("times go back")
        since = f"from {self._last * 1e-9:.2f} s on " if self._last >= 0 else ""
        span = f"nothing can be read {since}up to {until * 1e-9:.2f} s"
        return f"damaged between bytes {self._whole} and {resumed}: {span}"

    def _name_topics(self, file: IO[bytes]) -> None:
        """Learn the topics from the summary, once: the chunk that named one may be lost."""
        if self._looked_up:
            return
        self._looked_up = True
        for kind, data in summary_records(file):
            self._named(kind, data)

    def _records(self, file: IO[bytes], at: int) -> Iterator[tuple[int, bytes]]:
        """Yield the records from a byte on, up to the summary: opcode and content.

        To come to the end is to know that the log is whole, if the first byte was the first of the file. The index is
        not looked into: the library takes longer for it than for all the rest.
        """
        # A length that was damaged must not be taken for gigabytes to allocate: no record is longer than its file.
        limit = self.path.stat().st_size
        file.seek(at)
        crc = 0 if at else zlib.crc32(_magic(file))
        kind, indexed = 0, False
        while kind != Opcode.FOOTER:
            head = _exactly(file, _RECORD.size)
            kind, length = _RECORD.unpack(head)
            if length > limit:
                raise RecordLengthLimitExceeded(kind, length, limit)
            if not indexed and kind not in _KINDS:
                raise ValueError(f"no record has opcode {kind}")
            data = _exactly(file, length)
            if kind == Opcode.DATA_END:
                expected = DataEnd.read(_stream(data)).data_section_crc
                if not at and expected not in (0, crc):
                    raise _OtherSum(f"crc validation failed, expected: {expected}, calculated: {crc}")
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
        elif kind in (Opcode.SCHEMA, Opcode.CHANNEL):
            self._named(kind, data)
        elif kind == Opcode.ATTACHMENT and (attachment := Attachment.read(_stream(data))).name == MEMORY:
            if zlib.crc32(data[:-4]) != int.from_bytes(data[-4:], "little"):
                raise ValueError("what was remembered is not as it was written")
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
                if channel not in topics:
                    raise ValueError("where its topics were named is lost")
                messages.append(LoggedMessage(topics[channel], time, data[at + _MESSAGE.size : end]))
            else:
                self._named(kind, data[at:end])
            at = end
        return messages

    def _named(self, kind: int, data: bytes) -> None:
        """Take in a record that names a topic, or its schema."""
        if kind == Opcode.SCHEMA:
            schema = Schema.read(_stream(data))
            self._schema_of[schema.id] = schema
        elif kind == Opcode.CHANNEL:
            channel = Channel.read(_stream(data))
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
