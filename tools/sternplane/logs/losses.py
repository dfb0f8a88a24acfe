"""What was lost on wires and links in a run, and when; for people, as messages and shares."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import NamedTuple

from firmware_py.adapters.loss_watch import OUTLIERS
from firmware_py.records.event import Event, EventKind
from firmware_py.records.health import SensorHealth, SourceFault
from firmware_py.records.health_text import sensor_text
from firmware_py.records.sensing import MEASURES
from sternplane.logs.reading import Piece
from sternplane.logs.run import Run

_FIELDS: Mapping[str, tuple[str, ...]] = {**MEASURES, "dvl": ("dvl",)}
"""What each source measures, by the fields of a frame; nodes, and the DVL."""
_NAMES = {
    "ahrs": "AHRS",
    "pressure": "pressure sensor",
    "fix": "fix receiver",
    "battery": "battery and leak sensor",
    "esc": "propeller controller",
    "servo_hub": "servo hub",
    "hardpoint": "drop weight's hardpoint",
    "dvl": "DVL",
    "bus": "CAN bus",
    "transfers": "other nodes of the bus",
    "hil": "simulator's link",
}
_FURTHER = re.compile("([a-z]+)_([2-4])_(.+)")
"""Of a device that is not the first of its kind."""
_OF_NODE = re.compile(r"node(\d+)_")
"""Of a node with several roles: what is not told apart by them."""
_OF_LINES = ("dvl_bad_checksum", "dvl_malformed", "dvl_too_long", "lines_of_the_dvl_lost")
_OF_MESSAGES = (
    *("missed", "malformed", "strays", "duplicate", "lost_start", "unfinished", "wrong_toggle", "bad_crc"),
    *("timed_out", "too_long", "crowded_out"),
)
"""Counts of a node that are told by its messages missed."""
_WORDS = {
    "bus_not_sent": "frames that could not be sent",
    "bus_babbled": "frames of no use, from a babbling node",
    "bus_overrun": "frames overrun in the kernel",
    "bus_failed_drains": "times that it could not be read",
    "dvl_broken": "serial line broken at the end",
    "dvl_breaks": "breaks of the serial line",
    "dvl_line_errors": "bytes with errors on the serial line",
    "lines_of_the_dvl_late": "lines late",
    "not_taken": "messages not taken for want of room",
    "queue_full": "messages not sent, the queue was full",
    "flooding": "messages over the limit of a tick",
    "unsigned": "messages without a valid signature",
    "malformed": "malformed messages",
    "overrun": "datagrams left for later",
}


class Loss(NamedTuple):
    """What a source lost: how many of what, `of` so many that were sent, None where nobody knows; `why`, if known."""

    source: str
    what: str
    lost: int
    of: int | None = None
    why: str = ""

    @property
    def share(self) -> float:
        """Lost of those that were sent, in [0, 1]; NaN where nobody knows."""
        return self.lost / self.of if self.of else math.nan

    @property
    def text(self) -> str:
        """Return it as a phrase."""
        why = f": {self.why}" if self.why else ""
        if self.of is None:
            return f"{self.lost} {'time' if self.what == 'times' and self.lost == 1 else self.what}{why}"
        return f"{self.lost} of {self.of} {self.what} ({100.0 * self.share:.3g} %){why}"


class Received:
    """How many messages of each source came; it is shown the pieces of a log one after the other."""

    def __init__(self) -> None:
        self.counts = dict.fromkeys(_FIELDS, 0)

    def add(self, piece: Piece) -> None:
        """Take a piece in."""
        for source, fields in _FIELDS.items():
            for field in fields:
                fresh = piece.columns.get(f"frame.{field}.fresh")
                self.counts[source] += 0 if fresh is None else int(fresh.sum())


def losses(log: Run) -> dict[str, int]:
    """Return all counts: of the end record, or those logged last if the log was cut off."""
    last: dict[str, int] = {}
    for _, counts in log.losses:
        last |= counts
    return {**last, **log.end.get("losses", {})}


def times(log: Run) -> dict[str, list[float]]:
    """Return by name the times at which a count was first and last seen to have risen, s."""
    seen: dict[str, list[float]] = {}
    for t, counts in log.losses:
        for name in counts:
            seen.setdefault(name, [round(t, 3)] * 2)[1] = round(t, 3)
    return seen


def two_senders(events: Iterable[tuple[float, tuple[Event, ...]]]) -> list[str]:
    """Return the roles of the nodes under whose id a second sender was noticed in a flight, by their names."""
    told = (event for _, happened in events for event in happened if event.kind is EventKind.NODE_FAULT)
    return sorted({name for event in told if event.numbers[0] == SourceFault.TWO_SENDERS for name in event.names})


def outliers(counts: Mapping[str, int]) -> list[Loss]:
    """Return by sensor how many single values came, and were not believed: the most first."""
    found = [
        Loss(f"{_named(sensor_text(name))}, outliers", "left out one by one", counts.get(f"{OUTLIERS}{name}", 0))
        for name in SensorHealth._fields
    ]
    return sorted((loss for loss in found if loss.lost), key=lambda loss: -loss.lost)


def told(counts: Mapping[str, int], received: Mapping[str, int], doubled: Collection[str] = ()) -> list[Loss]:
    """Return what was lost by source, the greatest share first; then what has none, the greatest count first.

    What came and was not believed is no loss (`outliers`).

    Args:
        counts: as `losses` returns them.
        received: as `Received` counts them.
        doubled: as `two_senders` names them: a part of what they lost is what a second sender took the place of.
    """
    risen = {name: count for name, count in counts.items() if count and not name.startswith(OUTLIERS)}
    found = [loss for loss in _found(risen, received, doubled) if loss.lost]
    return sorted(found, key=lambda loss: (not loss.of, -loss.share if loss.of else -loss.lost))


def _found(counts: dict[str, int], received: Mapping[str, int], doubled: Collection[str]) -> Iterator[Loss]:
    lines = sum(counts.pop(name, 0) for name in _OF_LINES)
    yield Loss(_NAMES["dvl"], "lines lost", lines, lines + received.get("dvl", 0))
    for source, fields in _FIELDS.items():
        own = _taken(counts, source)
        missed, strays = own["missed"], own["strays"]
        sent = missed + received.get(source, 0) if fields else None
        two = source in doubled
        why = f"two senders, {strays} messages not believed" if two and strays else ""
        yield Loss(_named(source), "messages lost", missed, sent, why)
        if strays > missed and not (missed and two):
            what = "messages of two senders, not believed" if two else "messages out of sequence, not believed"
            yield Loss(f"{_named(source)}, strays", what, strays)
        elif not missed:
            yield Loss(_named(source), "frames or messages dropped", sum(own.values()))
        yield Loss(f"{_named(source)}, restarts", "times", counts.pop(f"{source}_restarts", 0))
    for node in {found[1]: None for name in counts if (found := _OF_NODE.match(name))}:
        yield Loss(f"node {node}", "frames or messages dropped", sum(_taken(counts, f"node{node}").values()))
        yield Loss(f"node {node}, restarts", "times", counts.pop(f"node{node}_restarts", 0))
    rest = sum(max(counts.pop(name), 0) for name in [*counts] if name.startswith("transfers_"))
    yield Loss(_NAMES["transfers"], "frames or messages dropped", rest)
    for name, count in counts.items():
        source, _, cause = name.partition("_")
        if source == "gcs":
            number, _, cause = cause.partition("_")
            yield Loss(f"station {number}", _WORDS.get(cause, cause.replace("_", " ")), count)
        elif further := _FURTHER.match(name):
            source, number, cause = further.groups()
            yield Loss(f"{_named(source)} {number}", _WORDS.get(f"{source}_{cause}", cause.replace("_", " ")), count)
        else:
            source = "dvl" if name.startswith("lines_of_the_dvl") else source
            yield Loss(_named(source), _WORDS.get(name, cause.replace("_", " ")), count)


def _taken(counts: dict[str, int], source: str) -> dict[str, int]:
    """Take the counts of a node's messages out of all, by cause, and out of those of all nodes."""
    own = {name: counts.pop(f"{source}_{name}", 0) for name in _OF_MESSAGES}
    for name, count in own.items():
        total = f"transfers_{name}"
        counts[total] = counts.get(total, 0) - count
    return own


def _named(source: str) -> str:
    return _NAMES.get(source, source.replace("_", " "))
