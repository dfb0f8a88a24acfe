"""The log: an MCAP file with everything that a replay needs, readable whenever its writer dies.

The first record of the file is the header, one JSON document in an MCAP metadata record named "sternplane"; then come
chunks of messages in CDR, each no longer than half a second, handed to the kernel when they are full. A writer that is
killed loses that half second and nothing else. (A power cut may lose more: nothing here waits for the disk.) The last
metadata record, "sternplane.end", says how the run ended. All times are vehicle times.
"""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, TypeAlias, TypeVar, cast

from mcap.data_stream import RecordBuilder
from mcap.writer import CompressionType, Writer

from firmware_py.adapters.loss_watch import LossWatch
from firmware_py.adapters.storage.chunk_index import ChunkIndexes, EncodedIndexes
from firmware_py.adapters.storage.message_chunk import MessageChunk
from firmware_py.records.cycle import Cycle
from firmware_py.wire.log import changes
from firmware_py.wire.log.cdr_codec import CdrCodec
from firmware_py.wire.log.losses import LoggedLoss, LoggedLosses
from firmware_py.wire.log.payload import LoggedPayload

R = TypeVar("R")
Codecs: TypeAlias = dict[str, CdrCodec[Any]]

FORMAT = 4
"""Version of what is written here; a reader refuses others."""
HEADER = "sternplane"
END = "sternplane.end"
CYCLE_TOPIC = "/cycle"
CHANGES_TOPIC = "/changes"
"""`changes.LoggedChanges`: what of the orders a cycle's message leaves out, always before that cycle."""
LOSSES_TOPIC = "/losses"
"""`losses.LoggedLosses`: once a second the counts of what was lost that have changed."""
PAYLOAD_TOPIC = "/payload"
"""`payload.LoggedPayload`: what sensors that the autopilot does not know have said, always before that cycle."""
TRUTH_TOPIC = "/truth"

MEMORY = "memory"
"""The attachment of a part: what the autopilot remembered when it began, as `memory_pickle` has it."""

_INDEXES_A_STEP = 32
_CHUNK_NS = 500_000_000
_CHUNK_BYTES = 1 << 24
"""More than a chunk of half a second ever has, so that time alone closes it."""


class LogError(Exception):
    """A log that cannot be written or read; the text names the file and what would be right."""


def to_json(document: Any) -> str:
    """Return JSON in which every double is exact; a non-finite one is {"$float": "nan" | "inf" | "-inf"}."""
    return json.dumps(_finite(document), allow_nan=False, ensure_ascii=False)


def from_json(text: str) -> Any:
    """Return what `to_json` was given; tuples come back as lists."""
    return json.loads(text, object_hook=lambda found: float(found["$float"]) if found.keys() == {"$float"} else found)


def _finite(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return {"$float": repr(float(value))}
    if isinstance(value, Mapping):
        return {str(key): _finite(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(inner) for inner in value]
    return value


class Log(Protocol):
    """Interface of what records are logged to, by topic."""

    def channel(self, topic: str, sample: Any, /) -> None:
        """Open a topic for records like `sample`."""

    def write(self, topic: str, t_ns: int, record: Any, /) -> None:
        """Write one record at its vehicle time, ns."""


class LogWriter:
    """Writes one log.

    Args:
        path: the file, replaced if it is there, unless `exclusive`.
        header: the document that comes first: configuration, initial state, mission, revision, versions, ...
        compression: of the chunks.
        exclusive: whether the file must be new.
        codecs: by topic, shared with the logs of the same records that follow: to make one takes some cycles.

    Raises:
        LogError: here and in every method, when the file cannot be written.
    """

    def __init__(
        self,
        path: str | Path,
        header: Mapping[str, Any],
        compression: CompressionType = CompressionType.ZSTD,
        *,
        exclusive: bool = False,
        codecs: Codecs | None = None,
    ) -> None:
        self.path = Path(path)
        self._codecs: Codecs = {} if codecs is None else codecs
        self._channels: dict[str, tuple[int, CdrCodec[Any]]] = {}
        self._closed = False
        self._chunk_end_ns: int | None = None
        try:
            if self.path.is_fifo():  # opening one would wait for a reader
                raise LogError(f"{self.path}: is a FIFO, not a file; remove it, or choose another folder")
            self._file = self.path.open("xb" if exclusive else "wb")
        except FileExistsError:
            raise LogError(f"{self.path}: another flight has begun to write it; choose another folder") from None
        except OSError as error:
            raise self._error(error) from None
        writer = Writer(self._file, chunk_size=_CHUNK_BYTES, compression=compression, enable_data_crcs=True)
        self._writer = cast(Any, writer)  # mcap's Writer is not typed throughout
        self._writer._Writer__chunk_indices = ChunkIndexes()  # the library's list takes 5 MB an hour
        self._writer._Writer__chunk_builder = MessageChunk()  # and its chunk three times as long for a message
        try:
            self._writer.start(profile="ros2", library="sternplane")
            self._writer.add_metadata(HEADER, {"format": str(FORMAT), "header": to_json(header)})
            self._writer.flush()
        except OSError as error:
            raise self._failed(error) from None

    def channel(self, topic: str, sample: R) -> None:
        """Open a topic for records like `sample`: the same type, with tuples of the same lengths."""
        codec = self._codecs[topic] = self._codecs.get(topic) or CdrCodec.like(sample)
        schema = self._writer.register_schema(codec.name, "ros2msg", codec.schema.encode())
        self._channels[topic] = self._writer.register_channel(topic, "cdr", schema), codec

    def write(self, topic: str, t_ns: int, record: Any) -> None:
        """Write one record at its vehicle time, ns; times do not decrease."""
        channel, codec = self._channels[topic]
        try:
            if self._chunk_end_ns is None:
                self._chunk_end_ns = t_ns + _CHUNK_NS
            elif t_ns >= self._chunk_end_ns:
                self._writer.flush()
                self._chunk_end_ns = t_ns + _CHUNK_NS
            self._writer.add_message(channel, t_ns, codec.encode(record), t_ns)
        except OSError as error:
            raise self._failed(error) from None

    def attach(self, name: str, t_ns: int, content: bytes) -> None:
        """Write a file of its own into the log, between two chunks."""
        try:
            self._writer.flush()
            self._writer.add_attachment(0, t_ns, name, "application/octet-stream", content)
        except OSError as error:
            raise self._failed(error) from None

    @property
    def size(self) -> int:
        """Return the bytes that were handed to the kernel."""
        return 0 if self._closed else self._file.tell()

    def close(self, end: Mapping[str, Any] | None = None) -> None:
        """Write how the run ended, the index and the summary. A second call does nothing."""
        for _ in self.closing(end):
            pass

    def closing(self, end: Mapping[str, Any] | None = None) -> Iterator[None]:
        """Close it as `close` does, in steps of less than a millisecond: the index of an hour takes many cycles."""
        if self._closed:
            return
        indexes: Any = RecordBuilder()
        try:
            self._writer.flush()
            self._writer.add_metadata(END, {"end": to_json(end or {})})
            for count, index in enumerate(self._writer._Writer__chunk_indices, 1):
                index.write(indexes)
                if count % _INDEXES_A_STEP == 0:
                    yield
            self._writer._Writer__chunk_indices = [EncodedIndexes(indexes.end())]
            self._writer.finish()
            self._file.close()
        except OSError as error:
            raise self._failed(error) from None
        self._closed = True

    def __enter__(self) -> LogWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _failed(self, error: OSError) -> LogError:
        """Close the file after an error; what was written so far stays a readable, truncated log."""
        self._closed = True
        with contextlib.suppress(OSError):  # the same failure again: the buffer that cannot be written
            self._file.close()
        return self._error(error)

    def _error(self, error: OSError) -> LogError:
        return LogError(f"{self.path}: the log cannot be written ({error.strerror}); choose another folder")


class LogRecorder:
    """A `ports.Recorder` over a log: every cycle on "/cycle", whose tuples are as long as the first one's.

    What stations have changed for good is on "/changes", and what was lost, by `losses`, on "/losses".
    """

    def __init__(self, log: Log, losses: LossWatch | None = None) -> None:
        self._log = log
        self._losses = losses
        self._open: set[str] = set()

    def write(self, cycle: Cycle) -> None:
        """Keeps one cycle.

        Raises:
            LogError: when the file cannot be written.
        """
        if cycle.order.changes:
            logged = tuple(map(changes.encode, cycle.order.changes))
            self._keep(CHANGES_TOPIC, cycle.tick.t_ns, changes.LoggedChanges(cycle.tick.k, logged))
        if cycle.frame.payload:
            self._keep(PAYLOAD_TOPIC, cycle.tick.t_ns, LoggedPayload(cycle.tick.k, cycle.frame.payload))
        self._keep(CYCLE_TOPIC, cycle.tick.t_ns, cycle)
        changed = self._losses.update(cycle) if self._losses is not None else {}
        if changed:
            counts = tuple(LoggedLoss(name, count) for name, count in changed.items())
            self._keep(LOSSES_TOPIC, cycle.tick.t_ns, LoggedLosses(cycle.tick.k, counts))

    def _keep(self, topic: str, t_ns: int, record: Any) -> None:
        if topic not in self._open:
            self._log.channel(topic, record)
            self._open.add(topic)
        self._log.write(topic, t_ns, record)
