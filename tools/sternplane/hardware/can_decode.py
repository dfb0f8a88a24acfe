"""`sternplane can decode`: a log of CAN frames as messages with their fields."""

from __future__ import annotations

import argparse
import io
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from rich.console import Console

from firmware_py.foreign_text import visible
from firmware_py.run.usage_error import UsageError
from sternplane.hardware.can_frames import Frame, FrameLog
from sternplane.hardware.canopen_text import canopen_text
from sternplane.hardware.messages import MessageReader, fields_text, port_of
from sternplane.hardware.output import console, show_json, written

_MOST_BUSES, _MOST_UNKNOWN = 32, 1000
"""So many buses and types that are not known are told apart; a log that is none may name any number."""
_MOST_SAID = 20
"""So many of the latter are said, the most frequent first."""
_FURTHER = ("further types", 0)


class Line(NamedTuple):
    """A line of the result.

    Attributes:
        t: s, from the first frame.
        bus: the interface that the log names.
        node: who sends; for CANopen whom it is about, 0 for all.
        what: the type's name, or "CANopen".
        text: the fields.
        fields: the same as they are; the text alone for CANopen.
    """

    t: float
    bus: str
    node: int
    what: str
    text: str
    fields: Any


class Decoder:
    """Turns frames into lines; transfers are put together by bus.

    Attributes:
        frames: how many have come.
        malformed: transfers that do not fit their type.
        unknown: frames of types that are not known, by name and node; "further types" of node 0 are all others.
        other_buses: frames of further buses than are told apart, which are left out.
    """

    def __init__(self, node: int | None = None) -> None:
        self.frames = self.other_buses = 0
        self.unknown: Counter[tuple[str, int]] = Counter()
        self._node = node
        self._readers: dict[str, MessageReader] = {}
        self._first: float | None = None

    def lines(self, frame: Frame) -> Iterator[Line]:
        """Yield the line that a frame completes, if any."""
        self.frames += 1
        if self._first is None:
            self._first = frame.t
        t = frame.t - self._first
        if not frame.extended:
            node = frame.can_id & 0x7F
            if self._node in (None, node):
                text = canopen_text(frame.can_id, frame.data)
                yield Line(t, frame.bus, node, "CANopen", f"0x{frame.can_id:03X} {text}", text)
            return
        if frame.bus not in self._readers and len(self._readers) >= _MOST_BUSES:
            self.other_buses += 1
            return
        reader = self._readers.setdefault(frame.bus, MessageReader())
        port = port_of(frame.can_id)
        if self._node not in (None, port.source, port.destination):
            return
        if not reader.known(port):
            key = (port.name, port.source)
            self.unknown[key if key in self.unknown or len(self.unknown) < _MOST_UNKNOWN else _FURTHER] += 1
            return
        message = reader.accept(frame.can_id, frame.data, frame.t)
        if message is None:
            return
        record = message.record
        text = "malformed: its length does not fit" if record is None else fields_text(record)
        yield Line(message.t - self._first, frame.bus, port.source, port.title, text, record)

    def losses(self) -> dict[str, int]:
        """Return what could not be used, by cause."""
        total: Counter[str] = Counter()
        for reader in self._readers.values():
            total.update(reader.dropped())
            total["malformed"] += reader.malformed
        return {cause: count for cause, count in total.items() if count and cause != "foreign"}


def command(options: argparse.Namespace) -> int:
    """Decode a log; return 1 if nothing in it could be read."""
    log, decoder, out = FrameLog(), Decoder(options.node), console()
    shown = 0
    for frame in _frames(options.file, log):
        for line in decoder.lines(frame):
            shown += 1
            _print(out, line, options.json)
    err = Console(stderr=True, highlight=False, soft_wrap=True)
    for sentence in _remarks(log, decoder, shown):
        err.print(sentence, markup=False)
    return 0 if shown else 1


def _frames(file: str, log: FrameLog) -> Iterator[Frame]:
    if file != "-":
        yield from log.of_file(Path(file))
        return
    if sys.stdin is None:
        raise UsageError("-: there is no standard input; give a file")
    raw = getattr(sys.stdin, "buffer", None)
    yield from log.of_stream(sys.stdin if raw is None else io.TextIOWrapper(raw, "utf-8", "replace"))


def _print(out: Console, line: Line, as_json: bool) -> None:
    if as_json:
        found = {"t_s": line.t, "bus": line.bus, "node": line.node, "type": line.what, "fields": line.fields}
        show_json(out, found, indent=None)
    else:
        bus = f"{line.bus}  " if line.bus else ""
        with written():
            out.out(visible(f"{line.t:12.6f}  {bus}{line.node:3d}  {line.what}  {line.text}"), highlight=False)


def _remarks(log: FrameLog, decoder: Decoder, shown: int) -> Iterator[str]:
    yield f"{shown} messages of {decoder.frames} frames"
    if losses := decoder.losses():
        yield f"not put together: {_counted(losses)}"
    if decoder.unknown:
        said = decoder.unknown.most_common(_MOST_SAID)
        unknown = {f"{name} of node {node or 'without id'}": n for (name, node), n in said}
        more = decoder.unknown.total() - sum(unknown.values())
        yield f"frames of types whose fields are not known: {_counted(unknown)}{f', {more} of others' if more else ''}"
    if decoder.other_buses:
        yield f"left out: {decoder.other_buses} frames of further buses than {_MOST_BUSES}"
    if log.others:
        yield f"left out: {log.others} error frames, remote requests or frames of CAN FD"
    if log.broken:
        yield f"{log.broken} lines are no frames of candump, the first is line {log.first_broken}"
    if not decoder.frames:
        yield "no frame: record a log by `candump -l can0`, or pipe `candump can0` into `sternplane can decode -`"


def _counted(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{count} {cause.replace('_', ' ')}" for cause, count in counts.items())
