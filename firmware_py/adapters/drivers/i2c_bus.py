"""An I2C bus of the computer, i2c:N, by smbus2."""

from __future__ import annotations

import contextlib
import fcntl
import importlib
import re
from typing import Any

from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.adapters.drivers.bar30 import SmBus
from firmware_py.error_text import quoted

_PORT = re.compile(r"i2c:(\d{1,3})")
_RETRIES, _TIMEOUT = 0x0701, 0x0702
"""Linux, linux/i2c-dev.h: I2C_RETRIES; I2C_TIMEOUT in units of 10 ms."""


def open_i2c(device: str, port: str) -> SmBus:
    """Open a bus; a transfer that hangs ends after 10 ms where the kernel's driver heeds it, and is not repeated.

    Args:
        device: what is on the bus, for errors.
        port: "i2c:N" for /dev/i2c-N.

    Raises:
        BusError: no such bus, or smbus2 is not installed.
    """
    found = _PORT.fullmatch(port)
    if found is None:
        raise BusError(f"{device}: port {quoted(port)}: must be i2c:N for /dev/i2c-N, such as i2c:1")
    try:
        smbus2 = importlib.import_module("smbus2")
    except ImportError:
        raise BusError(f"{device}: port {quoted(port)} needs smbus2: pip install smbus2") from None
    try:
        bus: Any = smbus2.SMBus(int(found[1]))
    except OSError as error:
        text = f"{error.strerror or error}; switch I2C on, and ask for permission of /dev/i2c-{found[1]}"
        raise BusError(f"{device}: port {quoted(port)} cannot be opened: {text}") from None
    with contextlib.suppress(OSError):
        fcntl.ioctl(bus.fd, _TIMEOUT, 1)
        fcntl.ioctl(bus.fd, _RETRIES, 0)
    opened: SmBus = bus
    return opened
