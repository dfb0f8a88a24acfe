"""Runs today's code on a log's inputs, through the same loop, and compares every byte of every cycle."""

from __future__ import annotations

import argparse
import dataclasses
import struct
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from firmware_py import loop
from firmware_py.adapters.storage import memory_pickle
from firmware_py.adapters.storage.recorder import LogError
from firmware_py.autopilot import Autopilot
from firmware_py.chosen_parts import described
from firmware_py.params import ParamError
from firmware_py.records.command import Applied
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import Order
from firmware_py.records.sensing import SensorFrame
from firmware_py.run import provenance, version
from firmware_py.tick import Tick
from sternplane.logs.reading import find
from sternplane.logs.run import Run
from sternplane.logs.streaming import stream

Build = Callable[[Mapping[str, Any]], Autopilot]
"""Makes the autopilot of a configuration, the one in a log's header."""


class Difference(NamedTuple):
    """A field that came out otherwise: the tick, the field's path, what the log has, what the replay gave."""

    tick: int
    field: str
    logged: Any
    replayed: Any

    def __str__(self) -> str:
        return f"tick {self.tick}: {self.field} was {self.logged!r} and is now {self.replayed!r}"


@dataclass(frozen=True, slots=True)
class ReplayResult:
    """How a replay compared.

    Attributes:
        cycles: how many were replayed.
        differing: how many of them have other bytes.
        first: the first field of the first of those, None if all are equal.
        cautions: what the reader of the result should know: a log cut off, another revision, another machine.
    """

    cycles: int
    differing: int
    first: Difference | None
    cautions: tuple[str, ...]

    @property
    def equal(self) -> bool:
        """True if every byte of every cycle is."""
        return self.first is None

    def __str__(self) -> str:
        if self.first is None:
            return f"{self.cycles} cycles replayed: every byte equal"
        return f"{self.differing} of {self.cycles} cycles differ, first at {self.first}"


def replay(log: Run, build: Build, *, anyway: bool = False) -> ReplayResult:
    """Replays a log.

    Args:
        log: what `sternplane.logs.reading.read` gave.
        build: makes a fresh autopilot of the log's configuration.
        anyway: also if another processor or other libraries made the log.

    Raises:
        LogError: the log is of another version, or of another machine, or damaged where it begins.
    """
    codec = log.codec
    differs = provenance.difference(log.header.get("machine", {}), provenance.fingerprint())
    if differs and not anyway:
        raise LogError(f"{log.path}: log of another machine ({differs}); replay it there, or add --anyway")
    comparison, cautions = ReplayedLog(log), [*_cautions(log, differs)]
    if log.count:
        hardware, ground = _LoggedHardware(comparison), _LoggedGround(comparison)
        autopilot = _at_its_begin(log, build)
        cautions += _other_parts(log, autopilot)
        loop.run(autopilot, hardware, ground, _ComparingRecorder(comparison), comparison)
    if comparison.broken is not None:
        if not comparison.count:
            raise LogError(f"{log.path}: it is {log.lost}, and what comes behind cannot be replayed without it")
        cautions.append(
            f"replayed up to {comparison.broken:.2f} s: what comes behind missing cycles cannot be replayed"
        )
    first = None
    if comparison.first is not None:
        logged, replayed = (codec.decode(data) for data in comparison.first)
        first = difference(logged, replayed)
    return ReplayResult(comparison.count, comparison.differing, first, tuple(cautions))


def _at_its_begin(log: Run, build: Build) -> Autopilot:
    """Return the autopilot as it was when the log began."""
    try:
        autopilot = build(log.header["configuration"])
    except ParamError as error:
        flew = [f"{part['class']} of {part['package']}" for part in log.header.get("own_parts", {}).values()]
        raise LogError(f"{log.path}: {error}{'; it flew with ' if flew else ''}{', '.join(flew)}") from None
    if log.memory:
        try:
            autopilot.thaw(memory_pickle.decode(log.memory))
        except ValueError as error:
            raise LogError(f"{log.path}: {error}; use revision {log.header.get('git', 'unknown')}") from None
    elif "after_tick" in log.header:
        raise LogError(f"{log.path}: begins in flight, without what was remembered then; it cannot be replayed")
    return autopilot


def command(options: argparse.Namespace) -> int:
    """`sternplane replay LOG`: 0 if every byte is equal, 1 if not."""
    from firmware_py.app import build

    result = replay(stream(find(options.log)), build, anyway=options.anyway)
    for line in result.cautions:
        print(f"note: {line}")
    print(result)
    return 0 if result.equal else 1


def difference(logged: Cycle, replayed: Cycle) -> Difference:
    """The first field, in the order of the records, in which two cycles differ to the last bit."""
    for (path, a), (_, b) in zip(_flat("", logged), _flat("", replayed), strict=True):
        if _bits(a) != _bits(b):
            return Difference(logged.tick.k, path, a, b)
    return Difference(logged.tick.k, "the bytes", "other", "other")


class ReplayedLog:
    """The schedule of a replay, and what its other parts read from: the log's cycles, one at a time.

    It ends where a damaged log lacks cycles, for then nobody knows any more what the autopilot remembered.

    Attributes:
        broken: time of the last cycle before those that are missing, s; None if none are.
    """

    def __init__(self, log: Run) -> None:
        self._log = log
        self.broken: float | None = None
        self.encode = log.codec.encode
        self.count = 0
        self.differing = 0
        self.first: tuple[bytes, bytes] | None = None

    def __iter__(self) -> Iterator[Tick]:
        before: int = self._log.header.get("after_tick", -1)
        for logged, cycle in self._log.logged_cycles():
            if self._log.lost and cycle.tick.k != before + 1:
                self.broken = max(before, 0) * cycle.tick.dt
                return
            before = cycle.tick.k
            self.logged, self.cycle = logged, cycle
            yield cycle.tick


class _LoggedHardware:
    def __init__(self, log: ReplayedLog) -> None:
        self._log = log

    def read(self, tick: Tick) -> SensorFrame:  # noqa: ARG002
        return self._log.cycle.frame

    def write(self, tick: Tick, applied: Applied) -> None:
        """Nobody listens."""


class _LoggedGround:
    def __init__(self, log: ReplayedLog) -> None:
        self._log = log

    def read(self, tick: Tick) -> Order:  # noqa: ARG002
        return self._log.cycle.order

    def write(self, cycle: Cycle) -> None:
        """Nobody listens."""


class _ComparingRecorder:
    """The recorder of a replay: it keeps nothing but the first cycle that came out otherwise."""

    def __init__(self, log: ReplayedLog) -> None:
        self._log = log

    def write(self, cycle: Cycle) -> None:
        log = self._log
        log.count += 1
        replayed = log.encode(cycle)
        if replayed != log.logged:
            log.differing += 1
            log.first = log.first or (log.logged, replayed)


def _cautions(log: Run, differs: str) -> Iterator[str]:
    if log.lost:
        yield f"the log is {log.lost}"
    if differs:
        yield f"the log is of another machine: {differs}"
    there, here = log.header.get("git", "unknown"), version.git_revision()
    if there != here:
        yield f"the log was written at revision {there}, this is {here}"


def _other_parts(log: Run, autopilot: Autopilot) -> Iterator[str]:
    """Yield a sentence for each part of one's own whose source is another than that which flew."""
    flown = log.header.get("own_parts", {})
    here = described(autopilot.reconfigurator.own) if flown else {}
    for key, there in flown.items():
        now = here.get(key, there)
        if now["source"] != there["source"]:
            flew, is_now = (f"source {one['source']} of {one['package']}" for one in (there, now))
            yield f"{key} = {there['name']} flew with {flew}; this is {is_now}"


def _flat(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Every number of a record with its path; the sentences of a cycle are one value."""
    if dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from _flat(f"{path}.{field.name}" if path else field.name, getattr(value, field.name))
    elif hasattr(value, "_fields"):
        for name in value._fields:
            yield from _flat(f"{path}.{name}", getattr(value, name))
    elif isinstance(value, tuple) and not all(isinstance(item, str) for item in value):
        for i, item in enumerate(value):
            yield from _flat(f"{path}[{i}]", item)
    else:
        yield path, value


def _bits(value: Any) -> Any:
    return struct.pack("<d", value) if isinstance(value, float) else value
