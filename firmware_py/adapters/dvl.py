"""The serial driver of a Water Linked DVL: bytes from pyserial, sentences from `wire.serial.waterlink_dvl`."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import math
import os
import struct
from dataclasses import dataclass
from typing import Any

import serial

from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.error_text import quoted
from firmware_py.params import param
from firmware_py.records.sensing import Dvl, Heard
from firmware_py.wire.serial.waterlink_dvl import Velocity, lines

BYTES_PER_TICK = 4096
RETRY_S = 1.0
"""How often a broken line is opened again, s."""
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


_TIOCGICOUNT = 0x545D
_ICOUNTS = struct.Struct("20i")
_ERRORS = slice(6, 11)
"""Linux, linux/serial.h, serial_icounter_struct: frame, overrun, parity, brk, buf_overrun."""
_UNPLUGGED = (errno.ENOENT, errno.ENODEV, errno.ENXIO, errno.EIO)
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
    """Reads the serial line once a tick. A line that breaks is silence, not an error, and is opened again when it can.

    The device has its own clock, so the time of validity of a report is its arrival less the delay between validity and
    transmission that the device reports.

    Args:
        params: of the io file.
        port: replaces that of the io file.
        absent: whether a port that is not there yet is silence too, and not an error.

    Attributes:
        broken: whether the line is broken, or was not there yet.

    Raises:
        BusError: the port cannot be opened.
    """

    def __init__(self, params: DvlPortParams, port: str = "", *, absent: bool = False) -> None:
        self._port, self._baud = port or params.port, params.baud
        self._lines = lines()
        self._serial: Any = None
        self._t_tried = 0.0
        self._breaks = self._line_errors = self._first_errors = 0
        self._name: object = None
        self.missing = ""
        """Why there is no port at the start; empty if there is one."""
        try:
            self._serial = self._open()
        except (serial.SerialException, ValueError) as error:
            text = f"dvl: port {quoted(self._port)} cannot be opened: {_why(error)}"
            if not (absent and self._port) or getattr(error, "errno", None) not in _UNPLUGGED:
                raise BusError(text) from None
            self.missing = text

    @property
    def broken(self) -> bool:
        """Return whether the line is broken."""
        return self._serial is None

    def read(self, t: float) -> Heard[Dvl] | None:
        """Return the newest report that is complete at `t`, s, if one has arrived; open a broken line again."""
        if self._serial is None and not self._reopened(t):
            return None
        try:
            waiting = self._serial.in_waiting
            reports = self._lines.feed(self._serial.read(min(waiting, BYTES_PER_TICK))) if waiting else []
        except (serial.SerialException, OSError):
            self._leave()
            self._breaks += 1
            self._t_tried = t
            return None
        return _heard(reports[-1], t) if reports else None

    def losses(self) -> dict[str, int]:
        """Return how much of what came could not be used, by cause.

        Returns:
            dvl_broken: 1 while the line is broken; dvl_breaks: how often that happened.
            dvl_bad_checksum, dvl_malformed, dvl_too_long: lines; other than `wrz` alone are not counted.
            dvl_line_errors: bytes with a wrong frame or parity, breaks and overruns, where the driver counts them.
        """
        counts = self._lines.counts
        return {
            "dvl_broken": int(self.broken),
            "dvl_breaks": self._breaks,
            "dvl_bad_checksum": counts.bad_checksum,
            "dvl_malformed": counts.malformed,
            "dvl_too_long": counts.too_long,
            "dvl_line_errors": self._line_errors + self._count_line_errors() - self._first_errors,
        }

    def close(self) -> None:
        """Close the port; may be called twice."""
        self._leave()

    def _open(self) -> Any:
        port: Any = serial.Serial(self._port, self._baud, timeout=0, exclusive=True)
        self._serial, self._name = port, self._named()
        self._first_errors = self._count_line_errors()
        return port

    def _named(self) -> object:
        """Return what tells this name of a pseudo-terminal from the next of that name; None for a device."""
        if not os.path.realpath(self._port).startswith("/dev/pts/"):
            return None
        name = os.lstat(self._port)
        return os.path.realpath(self._port), name.st_ino, name.st_mtime_ns if os.path.islink(self._port) else 0

    def _reopened(self, t: float) -> bool:
        if t - self._t_tried < RETRY_S:
            return False
        self._t_tried = t
        try:
            if (
                self._name is not None and self._name == self._named()
            ):  # the terminal of a simulation that ended: its number may be another's now
                return False
            self._serial = self._open()
        except (serial.SerialException, ValueError, OSError):
            return False
        self._lines.restart()
        return True

    def _leave(self) -> None:
        if self._serial is not None:
            self._line_errors += self._count_line_errors() - self._first_errors
            self._first_errors = 0
            with contextlib.suppress(serial.SerialException, OSError):
                self._serial.close()
            self._serial = None

    def _count_line_errors(self) -> int:
        """Return what the UART's driver has counted; 0 where it counts nothing, as on a pseudo-terminal."""
        if self._serial is None:
            return 0
        try:
            counts = _ICOUNTS.unpack(fcntl.ioctl(self._serial.fileno(), _TIOCGICOUNT, bytes(_ICOUNTS.size)))
        except (OSError, serial.SerialException, TypeError, ValueError):
            return 0
        return sum(counts[_ERRORS])


def _heard(report: Velocity, t: float) -> Heard[Dvl]:
    delay_us = report.time_of_transmission_us - report.time_of_validity_us
    timed = 0 <= delay_us <= LONGEST_DELAY_US
    value = Dvl(report.vx, report.vy, report.vz, report.fom, report.bottom)
    ok = report.usable and timed and math.isfinite(report.fom)
    return Heard(value, t - delay_us * 1e-6 if timed else t, True, ok)
