"""The serial driver of a Water Linked DVL: bytes from pyserial, sentences from `wire.serial.waterlink_dvl`."""

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
from firmware_py.wire.serial.waterlink_dvl import LineBuffer, Velocity

BYTES_PER_TICK = 4096
LONGEST_DELAY_US = 10_000_000
"""A greater delay than this between validity and transmission is not accepted, us."""


@dataclass(frozen=True, slots=True)
class DvlPortParams:
    """Table [dvl] of io_*.toml."""

    port: str = param(doc="Serial device of the DVL; {bus} in it stands for the name of the bus.")
    baud: int = param(115200, low=1200, high=4_000_000, doc="Bits a second; the device's default is 115200.")

    def place(self, spec: str) -> str:
        """Return the port for a bus: "{bus}" in its name is replaced, so that several simulations can run at once."""
        return self.port.replace("{bus}", spec.replace(":", "-").replace("/", "-"))


_SIMULATED = "a simulated plant makes its own: start it first, sternplane plant"
_WHY = {
    errno.ENOENT: f"there is no such device; {_SIMULATED}",
    errno.EIO: f"its other end is closed; {_SIMULATED}",
    errno.EAGAIN: f"another program has it; end that one, or give another --dvl; {_SIMULATED}",
    errno.EBUSY: "another program has it; end that one, or give another --dvl",
    errno.EACCES: "no permission; ask for it, or give another --dvl",
}
"""EAGAIN also results from the name of an ended simulation whose terminal belongs to another program by now."""


def _why(error: Exception) -> str:
    number: int = getattr(error, "errno", None) or 0
    return _WHY.get(number) or (os.strerror(number) if number else str(error))


class DvlPort:
    """Reads the serial line once a tick. A line that breaks is silence, not an error: the supervisor reacts to it.

    The device has its own clock, so the time of validity of a report is its arrival less the delay between validity and
    transmission that the device reports.

    Args:
        params: of the io file.
        port: replaces that of the io file.

    Raises:
        BusError: the port cannot be opened.
    """

    def __init__(self, params: DvlPortParams, port: str = "") -> None:
        port = port or params.port
        try:
            self._serial: Any = serial.Serial(port, params.baud, timeout=0, exclusive=True)
        except (serial.SerialException, ValueError) as error:
            raise BusError(f"dvl: port {port!r} cannot be opened: {_why(error)}") from None
        self._lines = LineBuffer()
        self.broken = False

    def read(self, t: float) -> Heard[Dvl] | None:
        """Return the newest report that is complete at `t`, s, if one has arrived."""
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
        """Close the port; may be called twice."""
        self._serial.close()


def _heard(report: Velocity, t: float) -> Heard[Dvl]:
    delay_us = report.time_of_transmission_us - report.time_of_validity_us
    timed = 0 <= delay_us <= LONGEST_DELAY_US
    value = Dvl(report.vx, report.vy, report.vz, report.fom, report.bottom)
    ok = report.usable and timed and math.isfinite(report.fom)
    return Heard(value, t - delay_us * 1e-6 if timed else t, True, ok)
