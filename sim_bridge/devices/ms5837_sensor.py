"""A pressure sensor MS5837 at the level of its registers: Blue Robotics Bar30 and Bar02."""

from __future__ import annotations

import errno

from firmware_py.wire.serial import ms5837
from firmware_py.wire.serial.ms5837 import BAR02, BAR30, Model, Prom
from sim_bridge.devices.i2c_line import I2cLine
from sim_bridge.devices.instruments import MeasuredPlant
from sim_bridge.devices.sensors import Sensor

BAR30_PROM = Prom(34982, 36352, 20328, 22354, 26646, 26146, 0x1A)
BAR02_PROM = Prom(46372, 43981, 29059, 27842, 31553, 28165, 0x15)
"""Calibrations; the numbers C1 to C6 are those of the examples in the data sheets."""
WATER = 10.0
"""°C."""


class Ms5837:
    """The sensor. After a reset it knows its calibration; a conversion that is read too early answers 0.

    Attributes:
        pressure: at it now, Pa, absolute; None: its conversions fail.
        temperature: °C.
        t: the time, s.
        powered: whether it answers.
    """

    def __init__(self, prom: Prom = BAR30_PROM, model: Model = BAR30) -> None:
        self.prom, self.model = prom, model
        self.pressure: float | None = 101_325.0
        self.temperature = WATER
        self.t = 0.0
        self.powered = True
        self._command, self._t_done, self._value = 0, 0.0, 0

    def write_byte(self, i2c_addr: int, value: int) -> None:
        """Reset, or begin to convert what is measured now."""
        self._refuse_other(i2c_addr)
        self._command = 0
        for commands, which in ((ms5837.CONVERT_PRESSURE, 0), (ms5837.CONVERT_TEMPERATURE, 1)):
            for ratio, command in commands.items():
                if value == command:
                    self._value, self._t_done = self.converted()[which], self.t + ms5837.CONVERSION_TIME[ratio]
                    self._command = value

    def read_i2c_block_data(self, i2c_addr: int, register: int, length: int) -> list[int]:
        """Return a word of the calibration, or what was converted."""
        self._refuse_other(i2c_addr)
        if register in ms5837.PROM_READ:
            at = 2 * ms5837.PROM_READ.index(register)
            content = ms5837.encode_prom(self.prom)[at:]
        elif register == ms5837.ADC_READ:
            done, self._command = self._command and self.t >= self._t_done, 0
            content = (self._value if done else 0).to_bytes(3, "big")
        else:
            content = b""
        return list(content[:length].ljust(length, b"\xff"))

    def converted(self) -> tuple[int, int]:
        """Return D1 and D2 of now; 0 of what cannot be converted."""
        if self.pressure is None:
            return 0, 0
        try:
            return ms5837.encode(self.prom, self.model, self.pressure, self.temperature)
        except (ValueError, OverflowError):
            return 0, 0

    def _refuse_other(self, address: int) -> None:
        if address != ms5837.ADDRESS or not self.powered:
            raise OSError(errno.EREMOTEIO, "Remote I/O error")


class Ms5837Device:
    """The sensor in the vehicle: it measures at every tick, and is asked when the driver likes.

    Args:
        sensor: what it measures, with its errors and faults.
        line: the bus that it is on.
        chip: which one.
    """

    def __init__(self, sensor: Sensor[MeasuredPlant, float], line: I2cLine, chip: Ms5837) -> None:
        self._sensor, self._chip = sensor, chip
        line.sensor = chip

    def update(self, k: int, t: float, plant: MeasuredPlant) -> None:
        """Measure at tick `k`, at time `t`, s."""
        reading = self._sensor.update(k, plant)
        self._chip.t, self._chip.pressure = t, reading.value if reading else None

    def switch_off(self) -> None:
        """Take its power away."""
        self._chip.powered = False

    def switch_on(self) -> None:
        """Give it power again."""
        self._chip.powered = True


def bar02() -> Ms5837:
    """Return a Bar02."""
    return Ms5837(BAR02_PROM, BAR02)
