"""What summary, report and export ask of a log, be it in memory (`reading.Log`) or on the disk (`streaming`)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Protocol

from firmware_py.records.cycle import Cycle
from firmware_py.records.event import Event
from firmware_py.records.order import Change
from firmware_py.records.sensing import PayloadReading
from firmware_py.wire.log.cdr_codec import CdrCodec
from sternplane.logs.reading import Piece


class Run(Protocol):
    """A logged run. All but `pieces`, `payload_messages` and `logged_cycles` is small."""

    @property
    def path(self) -> Path:
        """The log's file."""

    @property
    def header(self) -> dict[str, Any]:
        """The document that the log begins with."""

    @property
    def end(self) -> dict[str, Any]:
        """How the run ended; empty unless the writer closed the log."""

    @property
    def memory(self) -> bytes:
        """What the autopilot remembered when the log began, pickled; empty where it began with the flight."""

    @property
    def lost(self) -> str:
        """Return "" for a whole log, else one sentence: why it is not, and what cannot be read, or what can."""

    @property
    def complete(self) -> bool:
        """True if the writer closed the log and all of it is here."""

    @property
    def codec(self) -> CdrCodec[Cycle]:
        """The codec of the cycles."""

    @property
    def value_names(self) -> dict[str, dict[int, str]]:
        """What the numbers of modes, states and causes are called: path of a cycle's field -> number -> name."""

    @property
    def changes(self) -> dict[int, tuple[Change, ...]]:
        """Vehicle time in ns -> what was changed then."""

    @property
    def events(self) -> list[tuple[float, tuple[Event, ...]]]:
        """(vehicle time, s; what happened in that cycle), in order, without the cycles in which nothing did."""

    @property
    def losses(self) -> list[tuple[float, dict[str, int]]]:
        """(vehicle time, s; count since the start of each that changed in the second before), by source and cause."""

    @property
    def sentences(self) -> list[tuple[float, str]]:
        """The same for people: (vehicle time, s; sentence)."""

    @property
    def count(self) -> int:
        """How many cycles there are."""

    def row(self, t_ns: int) -> int:
        """Return the number of the first cycle that is not before the time of a change, ns."""

    def pieces(self, multiple: int = 1) -> Iterator[Piece]:
        """Yield all cycles, in pieces whose length is a multiple of a number; the last one's is what is left."""

    def payload_messages(self) -> Iterator[tuple[int, tuple[PayloadReading, ...]]]:
        """Yield vehicle time, ns, and what sensors that the autopilot does not know had said by then, in order."""

    def logged_cycles(self) -> Iterator[tuple[bytes, Cycle]]:
        """Yield every cycle, as bytes and decoded."""
