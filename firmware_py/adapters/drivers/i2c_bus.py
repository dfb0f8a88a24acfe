"""A bus i2c:N of the computer, by smbus2, or i2c:PATH, a simulated one behind a socket."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import importlib
import re
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.adapters.drivers.bar30 import SmBus
from firmware_py.adapters.drivers.i2c_socket import I2cSocket
from firmware_py.error_text import quoted

_PORT = re.compile(r"i2c:(?:(\d{1,3})|(/.+))")
_RETRIES, _TIMEOUT = 0x0701, 0x0702
"""Linux, linux/i2c-dev.h: I2C_RETRIES; I2C_TIMEOUT in units of 10 ms."""
_NOBODY_ANSWERS = {errno.EREMOTEIO, errno.ENXIO, errno.EIO, errno.ETIMEDOUT, errno.EAGAIN}
"""Of a sensor on a bus that is there, by kind of controller; after other errors the bus is opened anew."""


class I2cBus:
    """A bus; a transfer that hangs ends after 10 ms where the kernel's driver heeds it, and is not repeated.

    One that is gone, as an adapter on USB that was unplugged, is opened again at the next transfer.

    Args:
        device: what is on the bus, for errors.
        port: "i2c:N" for /dev/i2c-N; "i2c:PATH" for the socket of a simulated one.
        absent: whether a bus that is not there yet is silence, and not an error.

    Attributes:
        missing: why there is no bus yet, as it was tried last; empty if there was one at the start.
        broken: whether there is none.
        openings: how often it was opened.

    Raises:
        BusError: no such bus, or smbus2 is not installed.
    """

    def __init__(self, device: str, port: str, *, absent: bool = False) -> None:
        self.missing, self.openings = "", 0
        self._bus: SmBus | None = None
        self._open, self._remedy = _opener(device, port)
        self._named = f"{device}: port {quoted(port)}"
        try:
            self._opened()
        except OSError:
            if not absent:
                raise BusError(self.missing) from None

    @property
    def broken(self) -> bool:
        """Return whether there is no bus."""
        return self._bus is None

    def write_byte(self, i2c_addr: int, value: int) -> None:
        """Send a command.

        Raises:
            OSError: nobody answers.
        """
        with self._opened() as bus:
            bus.write_byte(i2c_addr, value)

    def read_i2c_block_data(self, i2c_addr: int, register: int, length: int) -> list[int]:
        """Send a command, and return the bytes that answer it.

        Raises:
            OSError: nobody answers.
        """
        with self._opened() as bus:
            return bus.read_i2c_block_data(i2c_addr, register, length)

    def close(self) -> None:
        """Leave the bus."""
        if self._bus is not None:
            self._bus.close()
            self._bus = None

    def _opened(self) -> contextlib.AbstractContextManager[SmBus]:
        if self._bus is None:
            try:
                self._bus = self._open()
            except OSError as error:
                if not self.openings:
                    self.missing = f"{self._named} cannot be opened: {error.strerror or error}; {self._remedy}"
                raise
            self.openings += 1
        return self._left_if_gone(self._bus)

    @contextlib.contextmanager
    def _left_if_gone(self, bus: SmBus) -> Iterator[SmBus]:
        try:
            yield bus
        except OSError as error:
            if error.errno not in _NOBODY_ANSWERS:
                self.close()
            raise


def _opener(device: str, port: str) -> tuple[Callable[[], SmBus], str]:
    """Return what opens a bus, and what to do where it cannot."""
    found = _PORT.fullmatch(port)
    if found is None:
        raise BusError(f"{device}: port {quoted(port)}: must be i2c:N for /dev/i2c-N, such as i2c:1")
    if found[2]:
        return partial(I2cSocket, found[2]), "start the plant with the same --lines"
    try:
        smbus2 = importlib.import_module("smbus2")
    except ImportError:
        raise BusError(f"{device}: port {quoted(port)} needs smbus2: pip install smbus2") from None

    def opened() -> SmBus:
        bus: Any = smbus2.SMBus(int(found[1]))
        with contextlib.suppress(OSError):
            fcntl.ioctl(bus.fd, _TIMEOUT, 1)
            fcntl.ioctl(bus.fd, _RETRIES, 0)
        found_bus: SmBus = bus
        return found_bus

    return opened, f"switch I2C on, and ask for permission of /dev/i2c-{found[1]}"
