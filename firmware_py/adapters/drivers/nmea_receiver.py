"""A satellite receiver that speaks NMEA 0183: positions (GGA, GNS) with their standard deviations (GST).

Of one fix that comes as GGA and as GNS the first is read. RMC is not: it says nothing about accuracy.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from firmware_py.adapters.drivers import fix_accuracy
from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.stream_driver import Instrument
from firmware_py.records.sensing import Fix, Heard
from firmware_py.wire.serial import nmea0183
from firmware_py.wire.serial.nmea_messages import Message, Position, PositionSigma
from firmware_py.wire.serial.stream import Counts, Decoder

DAY = 86400.0
SIGMA_AGE = 2.5
"""A standard deviation is that of fixes so much later at most, s: receivers send it after the fix, some less often."""


class PlacedFix(NamedTuple):
    """A position and the standard deviation of each of its horizontal coordinates, m; NaN: unknown."""

    position: Position
    std: float


class Fixes:
    """A decoder of positions, each with what the receiver has told of its accuracy."""

    def __init__(self) -> None:
        self._lines: Decoder[Message] = nmea0183.lines()
        self.counts: Counts = self._lines.counts
        self._sigma: PositionSigma | None = None
        self._t = math.nan

    def feed(self, data: bytes) -> list[PlacedFix]:
        """Return the positions that these bytes complete, in order; count everything else."""
        fixes = []
        for message in self._lines.feed(data):
            if isinstance(message, PositionSigma):
                self._sigma = message if message.usable else None
            elif isinstance(message, Position) and message.sentence != "RMC" and message.time != self._t:
                self._t = message.time
                fixes.append(PlacedFix(message, self._std(message)))
        return fixes

    def restart(self) -> None:
        """Forget what has come of a message and of accuracy."""
        self._lines.restart()
        self._sigma, self._t = None, math.nan

    def _std(self, position: Position) -> float:
        sigma = self._sigma
        if sigma is not None and (position.time - sigma.time) % DAY <= SIGMA_AGE:
            return fix_accuracy.at_least(math.hypot(sigma.north, sigma.east) * math.sqrt(0.5))
        return fix_accuracy.of_dilution(position.hdop)


def readings(fix: PlacedFix, t: float) -> Iterable[Reading]:
    """Return the position of a fix that was valid at t, s; it is ok if satellites gave it, with known accuracy."""
    position, std = fix
    value = Fix(position.latitude, position.longitude, std)
    yield Reading("fix", 0, Heard(value, t, True, position.usable and std > 0.0))


def _stamp(fix: PlacedFix) -> float:
    return fix.position.time


NMEA_RECEIVER = Instrument(Fixes, readings, "fix", _stamp, DAY)
