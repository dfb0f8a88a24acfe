"""What runs inside an instrument on a line: it turns readings into bytes, and obeys what it is told."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Protocol, TypeAlias

CLOCK_S = 1742.0
"""Time of a device's own clock, which nobody has set, at t = 0, s."""
_ROUNDING = 1e-6
"""Times of ticks are products that may be rounded under a sample's time, in samples."""


class Firmware(Protocol):
    """An instrument's program.

    Attributes:
        hears: whether it is told anything; one that is not needs no listening.
    """

    hears: bool

    def report(self, value: Any, valid: float, now: float) -> bytes:
        """Return what is sent of a value.

        Args:
            value: what the sensor of its role delivers, see `instruments.Instruments`.
            valid: time of validity by the device's clock, s.
            now: time by the device's clock, s.
        """

    def answer(self, data: bytes) -> bytes:
        """Obey what was told; return what is answered."""

    def restart(self) -> None:
        """Forget what is lost without power."""


Encode: TypeAlias = Callable[[Any, float, float], bytes]
"""`Firmware.report` of an instrument that speaks by itself and obeys nothing."""


class Talker:
    """One that speaks by itself, once for each reading, and obeys nothing."""

    hears = False

    def __init__(self, encode: Encode) -> None:
        self.report = encode

    def answer(self, _data: bytes) -> bytes:
        """Return nothing."""
        return b""

    def restart(self) -> None:
        """Forget nothing: its settings were written to it for good."""


class Pace:
    """Lets through so many samples a second at most, evenly by their time; 0 is none."""

    def __init__(self, rate: float) -> None:
        self.rate = rate
        self._last = -math.inf

    def due(self, t: float) -> bool:
        """Return whether the sample of time t, s, is sent."""
        step = math.floor(t * self.rate + _ROUNDING)
        if self.rate <= 0.0 or step == self._last:
            return False
        self._last = step
        return True
