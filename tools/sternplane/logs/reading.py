"""Reads a log: whole, cut off or damaged."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from firmware_py.adapters.storage.log_names import LOG_FILE, parts_in
from firmware_py.adapters.storage.recorder import (
    CHANGES_TOPIC,
    CYCLE_TOPIC,
    LOSSES_TOPIC,
    PAYLOAD_TOPIC,
    TRUTH_TOPIC,
    LogError,
)
from firmware_py.records.cycle import Cycle
from firmware_py.records.event import Event
from firmware_py.records.event_text import texts
from firmware_py.records.order import Change
from firmware_py.records.sensing import PayloadReading
from firmware_py.wire.log.cdr_codec import CdrCodec, closing_records
from firmware_py.wire.log.changes import LoggedChange
from firmware_py.wire.log.losses import LoggedLoss
from firmware_py.wire.log.ros2_schema import SchemaError
from sternplane.logs.log_file import DAMAGE, LogFile
from sternplane.logs.logged_changes import decode_change
from sternplane.logs.topic import Topic
from sternplane.logs.truth_beside import BEGIN_NS, truth_beside

R = TypeVar("R")
Columns = dict[str, npt.NDArray[Any]]

LARGE = 10_000_000
"""A log of so many bytes takes ten seconds to report."""

_MALFORMED = (*DAMAGE, ArithmeticError, AttributeError, StopIteration, TypeError)
"""What decoding a change raises besides, on numbers and text that no vehicle logs."""


class Piece(NamedTuple):
    """Cycles of a log one after the other: which is the first, their columns, and the true state at each if known."""

    begin: int
    columns: Columns
    truth: Columns


@dataclass(frozen=True)
class LoggedRun:
    """What a log tells of its run besides the cycles.

    Attributes:
        path: the file.
        header: the document its writer began with.
        end: how the run ended; empty unless the writer closed the log.
        topics: by name.
        lost: "" for a whole log, else one sentence: why it is not, and what cannot be read, or up to where it can.
        memory: what the autopilot remembered when the log began, pickled; empty where it began with the flight.
    """

    path: Path
    header: dict[str, Any]
    end: dict[str, Any]
    topics: dict[str, Topic]
    lost: str
    memory: bytes = field(default=b"", kw_only=True)

    @property
    def complete(self) -> bool:
        """True if the writer closed the log and all of it is here."""
        return not self.lost

    @cached_property
    def codec(self) -> CdrCodec[Cycle]:
        """The codec of this log's cycles.

        Raises:
            LogError: if the log was written by a version with other records.
        """
        try:
            return CdrCodec.of(Cycle, self._cycles.schema)
        except SchemaError as error:
            raise self._other_version(error) from None

    def decoded(self, time: int, message: bytes, payload: tuple[PayloadReading, ...] = ()) -> Cycle:
        """Decode the cycle of a vehicle time in ns, with what its order changed, and what its payload said."""
        cycle = self.codec.decode(message)
        if payload:
            state = dataclasses.replace(cycle.state, payload=payload)
            cycle = dataclasses.replace(cycle, frame=dataclasses.replace(cycle.frame, payload=payload), state=state)
        if changed := self.changes.get(time):
            cycle = dataclasses.replace(cycle, order=dataclasses.replace(cycle.order, changes=changed))
        return cycle

    @cached_property
    def changes(self) -> dict[int, tuple[Change, ...]]:
        """Vehicle time in ns -> what was changed then.

        Raises:
            LogError: if the log was written by a version with other records, or they are malformed.
        """
        if (topic := self.topics.get(CHANGES_TOPIC)) is None:
            return {}
        logged = self._closing(LoggedChange, topic)
        found: dict[int, tuple[Change, ...]] = {}
        for t, message in zip(topic.times, topic.messages, strict=True):
            try:
                found[t] = tuple([decode_change(one) for one in logged(message)])
            except _MALFORMED:
                where = f"{self.path}: {CHANGES_TOPIC} at {t * 1e-9:.2f} s"
                raise LogError(f"{where}: is malformed; no vehicle logs such a change") from None
        return found

    @cached_property
    def value_names(self) -> dict[str, dict[int, str]]:
        """What the numbers of modes, states and causes are called: path of a cycle's field -> number -> name."""
        return self._cycles.layout.names()

    @cached_property
    def payload_of(self) -> Callable[[bytes], tuple[PayloadReading, ...]]:
        """What decodes a message of the payload's topic; raises as `events`."""
        return self._closing(PayloadReading, self.topics[PAYLOAD_TOPIC])

    @cached_property
    def events(self) -> list[tuple[float, tuple[Event, ...]]]:
        """(vehicle time, s; what happened in that cycle), in order, without the cycles in which nothing did.

        Raises:
            LogError: if the log was written by a version with other records.
        """
        cycles = self._cycles
        size, closing = cycles.layout.size, self._closing(Event, cycles)
        return [(t * 1e-9, closing(m)) for t, m in zip(cycles.times, cycles.messages, strict=True) if len(m) > size]

    @cached_property
    def losses(self) -> list[tuple[float, dict[str, int]]]:
        """(vehicle time, s; count since the start of each that changed in the second before), by source and cause.

        Raises:
            LogError: if the log was written by a version with other records.
        """
        if (topic := self.topics.get(LOSSES_TOPIC)) is None:
            return []
        counts = self._closing(LoggedLoss, topic)
        logged = zip(topic.times, topic.messages, strict=True)
        return [(t * 1e-9, {loss.name: loss.count for loss in counts(message)}) for t, message in logged]

    @property
    def sentences(self) -> list[tuple[float, str]]:
        """The same for people: (vehicle time, s; sentence)."""
        return [(t, text) for t, events in self.events for text in texts(events)]

    def _closing(self, record: type[R], topic: Topic) -> Callable[[bytes], tuple[R, ...]]:
        try:
            return closing_records(record, topic.layout)
        except SchemaError as error:
            raise self._other_version(error) from None

    def _other_version(self, error: SchemaError) -> LogError:
        revision = self.header.get("git", "unknown")
        return LogError(f"{self.path}: log of another version ({error}); use revision {revision}")

    @property
    def _cycles(self) -> Topic:
        if CYCLE_TOPIC not in self.topics:
            why = f"it is {self.lost}" if self.lost else "the run ended within its first second"
            if TRUTH_TOPIC in self.topics:
                why = "it is a plant's, of the truth; it is read with a vehicle's log.mcap in its folder"
            raise LogError(f"{self.path}: the log holds no cycle; {why}")
        return self.topics[CYCLE_TOPIC]


@dataclass(frozen=True)
class Log(LoggedRun):
    """A log with all its cycles in memory; `stream` is for long ones."""

    @property
    def cycle_bytes(self) -> list[bytes]:
        """Every cycle as it was written."""
        return self._cycles.messages

    @property
    def cycles(self) -> Iterator[Cycle]:
        """Every cycle, decoded as it is asked for, with what its order changed."""
        for time, message in zip(self._cycles.times, self.cycle_bytes, strict=True):
            yield self.decoded(time, message, self.payload.get(time, ()))

    @cached_property
    def payload(self) -> dict[int, tuple[PayloadReading, ...]]:
        """Vehicle time in ns -> what sensors that the autopilot does not know had said by then."""
        topic = self.topics.get(PAYLOAD_TOPIC)
        found = zip(topic.times, topic.messages, strict=True) if topic is not None else ()
        return {time: self.payload_of(message) for time, message in found}

    def payload_messages(self) -> Iterator[tuple[int, tuple[PayloadReading, ...]]]:
        """Yield the same, one after the other."""
        return iter(self.payload.items())

    @property
    def columns(self) -> Columns:
        """The cycles' columns; arrays of fins are (cycles, fins)."""
        return self._cycles.columns

    @property
    def truth(self) -> Columns:
        """The columns of the plant's true state, empty when nobody knew it."""
        return self.topics[TRUTH_TOPIC].columns if TRUTH_TOPIC in self.topics else {}

    @property
    def count(self) -> int:
        """How many cycles there are."""
        return len(self.columns["t"])

    def row(self, t_ns: int) -> int:
        """Return the number of the first cycle that is not before a vehicle time, ns."""
        return int(np.searchsorted(self.columns["t"], t_ns * 1e-9))

    def pieces(self, multiple: int = 1) -> Iterator[Piece]:  # noqa: ARG002
        """Yield all cycles, in one piece."""
        truth, t = self.truth, self.columns["t"]
        if truth and truth["t"][0] <= t[0]:
            at = np.searchsorted(truth["t"], t, side="right") - 1
            yield Piece(0, self.columns, {name: column[at] for name, column in truth.items()})
        else:
            yield Piece(0, self.columns, {})

    def logged_cycles(self) -> Iterator[tuple[bytes, Cycle]]:
        """Yield every cycle, as bytes and decoded."""
        return zip(self.cycle_bytes, self.cycles, strict=True)


def find(path: str | Path) -> Path:
    """The log that is meant: a file, or the log.mcap in the folder of a run, or the oldest part that is left of it.

    Raises:
        LogError: the folder has none, but is one of runs.
    """
    path = Path(path)
    if not path.is_dir():
        return path
    if parts := parts_in(path):
        return parts[0][1]
    runs = [path / "latest", *sorted((log.parent for log in path.glob("*/log*.mcap")), reverse=True)]
    if run := next((run for run in runs if run.is_dir() and parts_in(run)), None):
        raise LogError(f"{path}: a folder of runs, not a run; give one of them, such as {run}")
    return path / LOG_FILE


def read(path: str | Path) -> Log:
    """Reads a log up to its end, without the chunks that are damaged or cut off.

    What a plant in another process wrote beside it, truth.mcap, is read with it, if it is known from the begin on.

    Raises:
        LogError: no such file, not a log of ours, another format, or nothing to recover.
    """
    path = Path(path)
    log = _open(path)
    if TRUTH_TOPIC not in log.topics and CYCLE_TOPIC in log.topics:
        times = log.topics[CYCLE_TOPIC].times
        beside = [*truth_beside(path, times[-1])]
        if beside and beside[0][0].time <= times[0] + BEGIN_NS:  # the newest that is not after each cycle
            rows = np.searchsorted([message.time for message, _ in beside], times, side="right") - 1
            messages = [beside[max(row, 0)][0].data for row in rows]
            log.topics[TRUTH_TOPIC] = Topic(*beside[0][1], times, messages)
    return log


def _open(path: Path) -> Log:
    file = LogFile(path)
    topics: dict[str, Topic] = {}
    for messages in file.chunks():
        for name, time, data in messages:
            topic = topics.get(name) or topics.setdefault(name, Topic(*file.schemas[name], [], []))
            topic.times.append(time)
            topic.messages.append(data)
    return Log(path, file.header, file.end, topics, file.lost, memory=file.memory)
