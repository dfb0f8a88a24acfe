"""A log that is read piece by piece, as often as it is asked for: a day of it takes no more memory than a minute."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from firmware_py.adapters.storage.recorder import CHANGES_TOPIC, CYCLE_TOPIC, LOSSES_TOPIC, PAYLOAD_TOPIC, TRUTH_TOPIC
from firmware_py.records.cycle import Cycle
from firmware_py.records.sensing import PayloadReading
from sternplane.logs.log_file import LogFile, LoggedMessage
from sternplane.logs.reading import Columns, LoggedRun, Piece
from sternplane.logs.topic import Topic
from sternplane.logs.truth_beside import BEGIN_NS, truth_beside

ROWS = 8_000
"""Cycles of a piece: with all its columns some 50 MB."""


@dataclass(frozen=True)
class StreamedLog(LoggedRun):
    """A log on the disk. Its `topics` hold what was changed or lost, and the cycles in which something happened.

    Attributes:
        count: how many cycles there are.
        end_ns: vehicle time of the last one, ns.
        rows: vehicle time, ns -> number of the cycle, for those with a change.
    """

    count: int
    end_ns: int
    rows: dict[int, int]

    def row(self, t_ns: int) -> int:
        """Return the number of the first cycle that is not before a time of `changes`, ns."""
        return self.rows.get(t_ns, self.count)

    def pieces(self, multiple: int = 1) -> Iterator[Piece]:
        """Yield all cycles, in pieces whose length is a multiple of a number; the last one's is what is left."""
        cycles, truth = self._cycles, _Truth(self)
        length, begin = -(-ROWS // multiple) * multiple, 0
        part = Topic(cycles.name, cycles.schema, [], [])
        for messages in LogFile(self.path).chunks():
            for topic, time, data in messages:
                if topic == CYCLE_TOPIC:
                    if len(part.times) == length:
                        yield Piece(begin, part.columns_by(cycles.layout), truth.at(part.times))
                        begin, part = begin + length, Topic(cycles.name, cycles.schema, [], [])
                    part.times.append(time)
                    part.messages.append(data)
                elif topic == TRUTH_TOPIC:
                    truth.add(time, data)
        if part.times:
            yield Piece(begin, part.columns_by(cycles.layout), truth.at(part.times))

    def payload_messages(self) -> Iterator[tuple[int, tuple[PayloadReading, ...]]]:
        """Yield vehicle time, ns, and what sensors that the autopilot does not know had said by then."""
        chunks = LogFile(self.path).chunks() if PAYLOAD_TOPIC in self.topics else ()
        for messages in chunks:
            for topic, time, data in messages:
                if topic == PAYLOAD_TOPIC:
                    yield time, self.payload_of(data)

    def logged_cycles(self) -> Iterator[tuple[bytes, Cycle]]:
        """Yield every cycle, as bytes and decoded."""
        said: tuple[int, tuple[PayloadReading, ...]] = -1, ()
        for messages in LogFile(self.path).chunks():
            for topic, time, data in messages:
                if topic == PAYLOAD_TOPIC:
                    said = time, self.payload_of(data)
                elif topic == CYCLE_TOPIC:
                    yield data, self.decoded(time, data, said[1] if said[0] == time else ())


class _Truth:
    """The true state beside the cycles: the newest that is not after each; out of the log, or of the file beside it."""

    def __init__(self, log: StreamedLog) -> None:
        self._beside: Iterator[tuple[LoggedMessage, tuple[str, str]]] = iter(())
        self._own = TRUTH_TOPIC in log.topics
        self._topic = log.topics.get(TRUTH_TOPIC)
        self._times: list[int] = []
        self._messages: list[bytes] = []
        self._begun = False
        if not self._own:
            self._beside = truth_beside(log.path, log.end_ns)

    def add(self, time: int, data: bytes) -> None:
        """Take in what was true at a time, ns; times do not decrease."""
        self._times.append(time)
        self._messages.append(data)

    def at(self, times: list[int]) -> Columns:
        """Return the columns of the truth at times that do not decrease; none where it is not known from the begin."""
        while not self._times or self._times[-1] <= times[-1]:
            found = next(self._beside, None)
            if found is None:
                break
            message, schema = found
            self._topic = self._topic or Topic(*schema, [], [])
            self.add(message.time, message.data)
        late = 0 if self._own else BEGIN_NS
        if not self._begun and (not self._times or self._times[0] > times[0] + late):
            self._topic, self._beside = None, iter(())
        self._begun = True
        if self._topic is None or not self._times:
            return {}
        rows = np.maximum(np.searchsorted(self._times, times, side="right") - 1, 0)
        part = Topic(self._topic.name, self._topic.schema, times, [self._messages[row] for row in rows])
        columns = part.columns_by(self._topic.layout)
        del self._times[: rows[-1]], self._messages[: rows[-1]]
        return columns


def stream(path: str | Path) -> StreamedLog:
    """Look through a log, without what is damaged or cut off, for what `StreamedLog` holds.

    Raises:
        LogError: no such file, not a log of ours, another format, or nothing to recover.
    """
    file = LogFile(Path(path))
    topics: dict[str, Topic] = {}
    rows: dict[int, int] = {}
    count, end, eventless, change = 0, 0, 0, -1
    for messages in file.chunks():
        for name, time, data in messages:
            if name not in topics:
                topics[name] = Topic(*file.schemas[name], [], [])
                eventless = topics[CYCLE_TOPIC].layout.size if name == CYCLE_TOPIC else eventless
            if name == CYCLE_TOPIC:
                if time == change:
                    rows[time] = count
                count, end = count + 1, time
                if len(data) <= eventless:
                    continue
            elif name == CHANGES_TOPIC:
                change = time
            elif name != LOSSES_TOPIC:
                continue
            topics[name].times.append(time)
            topics[name].messages.append(data)
    return StreamedLog(file.path, file.header, file.end, topics, file.lost, count, end, rows, memory=file.memory)
