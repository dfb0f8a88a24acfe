"""A simulated I2C bus with one sensor, as the driver of the autopilot sees it in the same process."""

from __future__ import annotations

import contextlib
import errno
from typing import Protocol


class I2cSensor(Protocol):
    """What answers on the bus. Each raises OSError where it does not."""

    def write_byte(self, i2c_addr: int, value: int) -> None:
        """Take a command."""

    def read_i2c_block_data(self, i2c_addr: int, register: int, length: int) -> list[int]:
        """Take a command, and return the bytes that answer it."""


class I2cLine(contextlib.AbstractContextManager["I2cLine"]):
    """The bus, with the methods of `smbus2.SMBus` that are used.

    Attributes:
        sensor: what is on the bus; None: nobody answers.
        lost, late: always 0, since nothing is under way on such a bus.
    """

    def __init__(self) -> None:
        self.lost = self.late = 0
        self.sensor: I2cSensor | None = None

    def write_byte(self, i2c_addr: int, value: int) -> None:
        """Pass on a command.

        Raises:
            OSError: nobody answers.
        """
        self._asked().write_byte(i2c_addr, value)

    def read_i2c_block_data(self, i2c_addr: int, register: int, length: int) -> list[int]:
        """Pass on a command, and return the bytes that answer it.

        Raises:
            OSError: nobody answers.
        """
        return self._asked().read_i2c_block_data(i2c_addr, register, length)

    def close(self) -> None:
        """Leave it, which changes nothing."""

    def __exit__(self, *_: object) -> None:
        self.close()

    def _asked(self) -> I2cSensor:
        if self.sensor is None:
            raise OSError(errno.EREMOTEIO, "Remote I/O error")
        return self.sensor
