"""An SBG Systems sensor: attitude with the rates of the same moment, which come in two frames.

Both must be sent at the same rate (Euler angles or quaternion, and rates), as configured with the maker's tools.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from firmware_py.adapters.drivers.attitude import ahrs, scalar_last
from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.stream_driver import Instrument
from firmware_py.wire.serial import sbg
from firmware_py.wire.serial.sbg import Attitude, Rates
from firmware_py.wire.serial.stream import Counts, Decoder

WRAP = 2.0**32 * 1e-6


class Motion(NamedTuple):
    """Attitude and rates with the same time stamp."""

    attitude: Attitude
    rates: Rates


class Motions:
    """A decoder of attitudes with their rates, in whatever order the two come."""

    def __init__(self) -> None:
        self._frames: Decoder[Attitude | Rates] = sbg.frames()
        self.counts: Counts = self._frames.counts
        self._attitude: Attitude | None = None
        self._rates: Rates | None = None

    def feed(self, data: bytes) -> list[Motion]:
        """Return what these bytes complete, in order; count everything else."""
        motions = []
        for message in self._frames.feed(data):
            if isinstance(message, Attitude):
                self._attitude = message
            else:
                self._rates = message
            attitude, rates = self._attitude, self._rates
            if attitude is not None and rates is not None and attitude.time == rates.time:
                motions.append(Motion(attitude, rates))
                self._attitude = self._rates = None
        return motions

    def restart(self) -> None:
        """Forget what has come of a message, and what waits for its other half."""
        self._frames.restart()
        self._attitude = self._rates = None


def readings(motion: Motion, t: float) -> Iterable[Reading]:
    """Return attitude and rates that were valid at t, s; they are ok if the device vouches for heading and gyros."""
    attitude, rates = motion
    ok = attitude.usable and rates.usable
    yield ahrs(attitude.angles, scalar_last(attitude.quaternion), rates.rates, t, ok)


def _stamp(motion: Motion) -> float:
    return motion.attitude.time


SBG = Instrument(Motions, readings, "ahrs", _stamp, WRAP)
