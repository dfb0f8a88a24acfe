"""The driver of a pressure sensor MS5837 on an I2C bus: Blue Robotics Bar30 and Bar02.

The sensor converts for milliseconds and is never waited for: each tick begins or ends one step, which moves a few bytes
(about 1 ms at 100 kHz). A transfer that nobody answers is done again, with ever longer pauses: long cables lose some.
A sensor that has not answered for a while is begun with anew: it has lost its power, or is another one.

Ticks that are caught up on after a late one follow at once, and a conversion may be read before its end. The answer is
0, the conversion goes on with a wrong result, and one that is begun meanwhile is wrong too (data sheet, "Conversion
sequence"). So after a 0 the sensor is left alone for a conversion, and the next result is not told: it only shows that
the sensor is idle.
"""

from __future__ import annotations

import math
from typing import Protocol

from firmware_py.adapters.drivers.driver import Driver, Reading
from firmware_py.records.sensing import Heard
from firmware_py.wire.serial import ms5837
from firmware_py.wire.serial.ms5837 import Model, Prom
from firmware_py.wire.serial.stream import ChecksumError, SentenceError

OVERSAMPLING = 4096
"""Converts for 9 ms."""
MARGIN = 2e-3
"""A conversion is read so much later, s: ticks begin at uneven times."""
CONVERTED_S = ms5837.CONVERSION_TIME[OVERSAMPLING] + MARGIN
TEMPERATURE_S = 0.5
"""How often the temperature is converted too, s."""
FIRST_PAUSE_S, LONGEST_PAUSE_S = 5e-3, 0.25
"""Before a transfer is tried again, s: twice as long each time. One that hangs makes a cycle late."""
KEPT_S = 0.25
"""So long after its last answer a sensor is still the same one, s, and its calibration holds."""
MOST_UNREADY = 3
"""After so many conversions in a row without a result the sensor is begun with anew."""


class SmBus(Protocol):
    """What of smbus2.SMBus is used. Each raises OSError where nobody answers."""

    def write_byte(self, i2c_addr: int, value: int) -> None:
        """Send a command."""

    def read_i2c_block_data(self, i2c_addr: int, register: int, length: int) -> list[int]:
        """Send a command, and return the bytes that answer it."""

    def close(self) -> None:
        """Leave the bus."""


class Bar30(Driver):
    """One sensor.

    Args:
        name: of the device, for its losses.
        bus: where it is.
        latency: taken off the time of validity, which is the middle of the conversion, s.
        number: which of the pressure sensors, from 0.
        unversioned: what a sensor is that does not tell its version.
        address: on the bus.
    """

    def __init__(
        self,
        name: str,
        bus: SmBus,
        latency: float = 0.0,
        number: int = 0,
        unversioned: Model = ms5837.BAR30,
        address: int = ms5837.ADDRESS,
    ) -> None:
        self._name, self._bus, self._latency, self._number = name, bus, latency, number
        self._unversioned, self._address = unversioned, address
        self._words: bytes = b""
        self._prom: Prom | None = None
        self._there = False
        self._command = 0
        """The conversion that is under way; 0: none."""
        self._t_step = self._t_answered = self._t_temperature = -math.inf
        self._t_next, self._pause = -math.inf, FIRST_PAUSE_S
        self._d2 = 0
        self._unready_in_row = 0
        self._unanswered = self._breaks = self._bad_checksum = self._malformed = self._unready = 0

    def poll(self, t: float) -> list[Reading]:
        """Take the step that is due at `t`, s; return the pressure if it ends a conversion."""
        readings: list[Reading] = []
        if t < self._t_next:
            return readings
        try:
            if not self._there:
                self._begin(t)
            elif self._prom is None:
                self._read_prom(t)
            elif not self._command:
                self._convert(t)
            elif t - self._t_step >= CONVERTED_S:
                readings = self._end(self._prom, t)
                if t >= self._t_next:
                    self._convert(t)
        except OSError:
            self._unanswered += 1
            self._wait(t)
        except ChecksumError:
            self._bad_checksum += 1
            self._lose()
        except SentenceError:
            self._malformed += 1
            self._lose()
        else:
            self._t_answered, self._pause = t, FIRST_PAUSE_S
        return readings

    def losses(self) -> dict[str, int]:
        """Return what is wrong with the sensor.

        Returns:
            broken: 1 while it does not answer; breaks: how often that began.
            unanswered: transfers to which nobody answered.
            bad_checksum, malformed: calibrations that could not be read; unready: conversions without a result.
        """
        counts = {
            "broken": int(self._prom is None),
            "breaks": self._breaks,
            "unanswered": self._unanswered,
            "bad_checksum": self._bad_checksum,
            "malformed": self._malformed,
            "unready": self._unready,
        }
        return {f"{self._name}_{cause}": count for cause, count in counts.items()}

    def close(self) -> None:
        """Leave the bus."""
        self._bus.close()

    def _begin(self, t: float) -> None:
        self._bus.write_byte(self._address, ms5837.RESET)
        self._there, self._t_step, self._words = True, t, b""

    def _read_prom(self, t: float) -> None:
        """Read a word of the calibration."""
        if t - self._t_step < ms5837.RESET_TIME + MARGIN:
            return
        self._words += bytes(self._bus.read_i2c_block_data(self._address, ms5837.PROM_READ[len(self._words) // 2], 2))
        if len(self._words) >= 2 * len(ms5837.PROM_READ):
            self._prom = ms5837.decode_prom(self._words)
            self._command, self._d2, self._unready_in_row, self._t_temperature = 0, 0, 0, -math.inf

    def _convert(self, t: float) -> None:
        """Begin a conversion, if the sensor is still there."""
        if self._prom is None:
            return
        temperature = not self._d2 or t - self._t_temperature >= TEMPERATURE_S
        command = (ms5837.CONVERT_TEMPERATURE if temperature else ms5837.CONVERT_PRESSURE)[OVERSAMPLING]
        self._bus.write_byte(self._address, command)
        self._command, self._t_step = command, t

    def _end(self, prom: Prom, t: float) -> list[Reading]:
        """Read what was converted; it stays in the sensor until it is read, or the next conversion begins."""
        content = bytes(self._bus.read_i2c_block_data(self._address, ms5837.ADC_READ, 3))
        command, self._command = self._command, 0
        try:
            value = ms5837.decode_adc(content)
        except SentenceError:
            self._unready += 1
            self._unready_in_row += 1
            self._t_next = t + CONVERTED_S
            if self._unready_in_row >= MOST_UNREADY:
                self._lose()
            return []
        doubtful, self._unready_in_row = self._unready_in_row > 0, 0
        return [] if doubtful else self._converted(command, value, prom)

    def _converted(self, command: int, value: int, prom: Prom) -> list[Reading]:
        if command == ms5837.CONVERT_TEMPERATURE[OVERSAMPLING]:
            self._d2, self._t_temperature = value, self._t_step
            return []
        model = ms5837.VERSIONS.get(prom.version, self._unversioned)
        pressure, _, ok = ms5837.compensate(prom, model, value, self._d2)
        t_valid = self._t_step + 0.5 * ms5837.CONVERSION_TIME[OVERSAMPLING] - self._latency
        return [Reading("pressure", self._number, Heard(pressure, t_valid, True, ok))]

    def _wait(self, t: float) -> None:
        """Leave the sensor alone for a while, and begin with it anew if it has been silent for too long."""
        self._t_next, self._pause = t + self._pause, min(2.0 * self._pause, LONGEST_PAUSE_S)
        if t - self._t_answered > KEPT_S:
            self._lose()

    def _lose(self) -> None:
        self._breaks += self._prom is not None
        self._there, self._prom = False, None
