"""The serial driver of a Water Linked DVL: bytes from pyserial, sentences from `wire.waterlink`."""

from __future__ import annotations

import errno
import math
import os
from dataclasses import dataclass
from typing import Any

import serial

from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.params import param
from firmware_py.records.sensing import Dvl, Heard
from firmware_py.wire.serial.waterlink import LineBuffer, Velocity

BYTES_PER_TICK = 4096
LONGEST_DELAY_US = 10_000_000
"""A report that claims to be older is not believed."""


@dataclass(frozen=True, slots=True)
class DvlParams:
    """Table [dvl] of io_*.toml."""

    port: str
    baud: int = param(115200, low=1200, high=4_000_000, doc="Bits a second; the device's default is 115200.")

    def place(self, spec: str) -> str:
        """The port for a bus: "{bus}" in its name stands for the bus's, so that several simulations have one each."""
        return self.port.replace("{bus}", spec.replace(":", "-").replace("/", "-"))


_BRINGS = "a simulated boat brings its own: start it first, sternplane plant"
_WHY = {
    errno.ENOENT: f"there is no such device; {_BRINGS}",
    errno.EIO: f"nobody is at its other end; {_BRINGS}",
    errno.EAGAIN: f"another program has it; end that one, or give another --dvl; {_BRINGS}",
    errno.EBUSY: "another program has it; end that one, or give another --dvl",
    errno.EACCES: "no permission; ask for it, or give another --dvl",
}
"""EAGAIN is also what a name gets that a boat left behind, whose terminal somebody else has by now."""


def _why(error: Exception) -> str:
    number: int = getattr(error, "errno", None) or 0
    return _WHY.get(number) or (os.strerror(number) if number else str(error))


class DvlPort:
    """Drains the line once a tick. A line that breaks is silence, not an error: the supervisor knows what to do.

    The device's clock is its own, so a report's time of validity is when it came less what the device says has passed
    between validity and transmission.

    Args:
        params: of the io file.
        port: takes the place of the io file's.

    Raises:
        BusError: the port cannot be opened.
    """

    def __init__(self, params: DvlParams, port: str = "") -> None:
        port = port or params.port
        try:
            self._serial: Any = serial.Serial(port, params.baud, timeout=0, exclusive=True)
        except (serial.SerialException, ValueError) as error:
            raise BusError(f"dvl: port {port!r} cannot be opened: {_why(error)}") from None
        self._lines = LineBuffer()
        self.broken = False

    def read(self, t: float) -> Heard[Dvl] | None:
        """The newest report that is complete at `t`, s, if one has come."""
        if self.broken:
            return None
        try:
            waiting = self._serial.in_waiting
            reports = self._lines.feed(self._serial.read(min(waiting, BYTES_PER_TICK))) if waiting else []
        except (serial.SerialException, OSError):
            self.broken = True
            return None
        return _heard(reports[-1], t) if reports else None

    def close(self) -> None:
        """Closes the port; may be called twice."""
        self._serial.close()


def _heard(report: Velocity, t: float) -> Heard[Dvl]:
    delay_us = report.time_of_transmission_us - report.time_of_validity_us
    timed = 0 <= delay_us <= LONGEST_DELAY_US
    value = Dvl(report.vx, report.vy, report.vz, report.fom, report.bottom)
    ok = report.usable and timed and math.isfinite(report.fom)
    return Heard(value, t - delay_us * 1e-6 if timed else t, True, ok)
