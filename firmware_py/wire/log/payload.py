"""What sensors that the autopilot does not know have said, as a log keeps it."""

from __future__ import annotations

from dataclasses import dataclass, field

from firmware_py.records.order import ANY_LENGTH
from firmware_py.records.sensing import PayloadReading


@dataclass(frozen=True, slots=True)
class LoggedPayload:
    """What came with tick `k`, in its order."""

    k: int
    readings: tuple[PayloadReading, ...] = field(metadata={ANY_LENGTH: True})
