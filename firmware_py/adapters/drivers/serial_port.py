"""A serial port that a device is plugged into, or will be: pyserial, which never waits here."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import struct
import termios
from typing import Any

import serial

from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.adapters.serial_open import open_serial
from firmware_py.error_text import quoted

BYTES_PER_TICK = 4096
RETRY_S = 1.0
"""How often a broken line is opened again, s."""

_TIOCGICOUNT = 0x545D
_ICOUNTS = struct.Struct("20i")
_ERRORS = slice(6, 11)
"""Linux, linux/serial.h, serial_icounter_struct: frame, overrun, parity, brk, buf_overrun."""
_NOT_YET = (errno.ENOENT, errno.ENODEV, errno.ENXIO, errno.EIO, errno.EAGAIN, errno.EBUSY, errno.EACCES)
"""Errors that pass: at boot a modem manager tries ports, and udev gives one to its group when it is there already."""
_SIMULATED = "a simulated plant makes its own: start it first, sternplane plant"
_WHY = {
    errno.ENOENT: "there is no such device; is it plugged in, its name right (ls -l /dev/serial/by-id)?",
    errno.EIO: "its other end is closed",
    errno.EAGAIN: "another program has it; end that one, or give another port",
    errno.EBUSY: "another program has it; end that one, or give another port",
    errno.EACCES: "no permission; ask for it, or give another port",
    errno.ENOTTY: "it is no serial device",
}
_GONE = (errno.ENOENT, errno.EIO, errno.EAGAIN)
"""EAGAIN also results from the name of an ended simulation whose terminal belongs to another program by now."""


def _why(error: Exception, port: str) -> str:
    number: int = getattr(error, "errno", None) or 0
    if not number and isinstance(error.__context__, termios.error):  # pyserial has it in its text alone
        number = error.__context__.args[0]
    why = _WHY.get(number) or (os.strerror(number) if number else str(error))
    if number not in _GONE:
        return why
    place = os.path.realpath(port)
    real = place.startswith("/dev/") and not place.startswith("/dev/pts/")  # no plant puts a name there
    return why if real else f"{why}; {_SIMULATED}"


class SerialPort:
    """A byte stream. A line that breaks is silence, not an error, and is opened again when it can.

    Args:
        device: what is plugged in, for errors.
        port: its name.
        baud: bits a second.
        absent: whether a port that is not there yet, or may not be opened yet, is silence too, and not an error.

    Attributes:
        missing: why there is no port yet, as it was tried last; empty if there was one at the start.
        openings: how often it was opened: after another opening the rest of a message does not come.

    Raises:
        BusError: the port cannot be opened.
    """

    def __init__(self, device: str, port: str, baud: int, *, absent: bool = False) -> None:
        self._device, self._port, self._baud = device, port, baud
        self._serial: Any = None
        self._t_tried = 0.0
        self._breaks = self._line_errors = self._first_errors = self._last_errors = self._not_sent = 0
        self._name: object = None
        self.missing, self.openings = "", 0
        try:
            self._open()
        except (OSError, ValueError) as error:
            self.missing = self._text(error)
            if not (absent and port) or getattr(error, "errno", None) not in _NOT_YET:
                raise BusError(self.missing) from None

    @property
    def broken(self) -> bool:
        """Return whether the line is broken, or was not there yet."""
        return self._serial is None

    def read(self, t: float) -> bytes:
        """Return the bytes that have arrived, a bounded number; try to open a broken line again at `t`, s."""
        if self._serial is None and not self._reopened(t):
            return b""
        try:
            waiting = self._serial.in_waiting
            return self._serial.read(min(waiting, BYTES_PER_TICK)) if waiting else b""
        except (serial.SerialException, OSError):
            self._leave()
            self._breaks += 1
            self._t_tried = t
            return b""

    def write(self, data: bytes) -> None:
        """Send bytes; what the line does not take at once is counted. A broken line takes nothing."""
        if self._serial is None:
            return
        try:
            sent = os.write(self._serial.fileno(), data)  # pyserial's own waits for room
        except (serial.SerialException, OSError):  # a line that broke is noticed when it is read
            sent = 0
        self._not_sent += sent < len(data)

    def losses(self) -> dict[str, int]:
        """Return what is wrong with the line.

        Returns:
            broken: 1 while the line is broken; breaks: how often that happened.
            line_errors: bytes with a wrong frame or parity, breaks and overruns, where the driver counts them.
            not_sent: how often it did not take what the device should have been told.
        """
        errors = self._line_errors + self._count_line_errors() - self._first_errors
        return {
            "broken": int(self.broken),
            "breaks": self._breaks,
            "line_errors": errors,
            "not_sent": self._not_sent,
        }

    def close(self) -> None:
        """Close the port; may be called twice."""
        self._leave()

    def _open(self) -> None:
        self._serial = open_serial(self._port, self._baud)
        self._name = self._named()
        self._first_errors = self._count_line_errors()
        self.openings += 1

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
            self._open()
        except (OSError, ValueError) as error:
            if not self.openings:
                self.missing = self._text(error)
            return False
        return True

    def _text(self, error: Exception) -> str:
        return f"{self._device}: port {quoted(self._port)} cannot be opened: {_why(error, self._port)}"

    def _leave(self) -> None:
        if self._serial is not None:
            self._line_errors += self._count_line_errors() - self._first_errors
            self._first_errors = self._last_errors = 0
            with contextlib.suppress(serial.SerialException, OSError):
                self._serial.close()
            self._serial = None

    def _count_line_errors(self) -> int:
        """Return what the UART's driver has counted; 0 where it counts nothing, as on a pseudo-terminal.

        Of an adapter that has just been unplugged it is what it counted last.
        """
        if self._serial is not None:
            with contextlib.suppress(OSError, serial.SerialException, TypeError, ValueError):
                counts = _ICOUNTS.unpack(fcntl.ioctl(self._serial.fileno(), _TIOCGICOUNT, bytes(_ICOUNTS.size)))
                self._last_errors = sum(counts[_ERRORS])
        return self._last_errors
