"""What became of a driver that was given hostile bytes."""

from __future__ import annotations

from typing import NamedTuple


class Outcome(NamedTuple):
    """What became of one driver.

    Attributes:
        name: of its device.
        given: so many bytes.
        readings: of these, and how many were ok.
        ok: see readings.
        longest_ms: the longest call.
        broken: how a rule was broken; empty if none was.
    """

    name: str
    given: int
    readings: int
    ok: int
    longest_ms: float
    broken: str
