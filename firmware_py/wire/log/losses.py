"""What was lost on wires and links, as a log keeps it: once a second the counts that have changed."""

from __future__ import annotations

from dataclasses import dataclass, field

from firmware_py.records.order import ANY_LENGTH


@dataclass(frozen=True, slots=True)
class LoggedLoss:
    """How much was lost since the start, and from what: "bus_not_sent", "ahrs_bad_crc", "gcs_1_malformed"."""

    name: str
    count: int


@dataclass(frozen=True, slots=True)
class LoggedLosses:
    """The counts that have changed within the second before tick `k`."""

    k: int
    counts: tuple[LoggedLoss, ...] = field(metadata={ANY_LENGTH: True})
