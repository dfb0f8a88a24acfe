"""An instrument on a line of its own: a sensor, and the program that turns its readings into bytes."""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Sequence
from typing import Any, Protocol

from firmware_py.adapters.drivers.instrument_params import Device
from firmware_py.adapters.drivers.mounting import STRAIGHT, Mounting
from sim_bridge.devices.instruments import MeasuredPlant
from sim_bridge.devices.lines.firmware import CLOCK_S, Firmware
from sim_bridge.devices.mounted import mounted
from sim_bridge.devices.sensors import Sensor


class Losing(Protocol):
    """What counts losses of a line.

    Attributes:
        lost: how often a reader left no room, and bytes were lost.
        late: how often bytes did not arrive in time.
    """

    lost: int
    late: int


class Line(Losing, Protocol):
    """The device's end: `serial_line.SerialLine`, `tcp_line.TcpLine`."""

    def send(self, line: bytes) -> None:
        """Send bytes whole, or lose them whole."""

    def receive(self) -> bytes:
        """Return what the autopilot wrote, a bounded number of bytes; empty if nothing."""


def line_losses(devices: Sequence[Device], lines: Sequence[Losing]) -> dict[str, int]:
    """Return what was lost and late on the lines of devices: of all DVLs together, and of each other one."""
    counts = {"lines_of_the_dvl_lost": 0, "lines_of_the_dvl_late": 0}
    for device, line in zip(devices, lines, strict=True):
        name = "lines_of_the_dvl" if device.role == "dvl" else f"{device.source}_lines"
        for key, count in ((f"{name}_lost", line.lost), (f"{name}_late", line.late)):
            counts[key] = counts.get(key, 0) + count
    return counts


class LineDevice:
    """The device: sends the readings of its sensor over its line, and answers what it is told there."""

    def __init__(
        self, sensor: Sensor[MeasuredPlant, Any], line: Line, firmware: Firmware, mounting: Mounting = STRAIGHT
    ) -> None:
        self._sensor, self._line, self._firmware = sensor, line, firmware
        self._seen = mounted(mounting)
        self._powered = True

    def update(self, k: int, t: float, plant: MeasuredPlant) -> None:
        """Send what is ready at tick `k`, at time `t`, s; return when the autopilot can read it."""
        reading = self._sensor.update(k, plant)
        sent = b""
        if reading is not None or self._firmware.hears:
            told = self._line.receive()  # also where nothing is heard, so that the autopilot's writes never block
            if told and self._powered:
                sent = self._firmware.answer(told)
        if reading is not None and self._powered:
            # a faulty value that its protocol cannot hold is not sent
            with contextlib.suppress(OverflowError, ValueError, struct.error):
                sent += self._firmware.report(self._seen(reading.value), CLOCK_S + reading.t_valid, CLOCK_S + t)
        if sent:
            self._line.send(sent)

    def switch_off(self) -> None:
        """Take its power away."""
        self._powered = False

    def switch_on(self) -> None:
        """Give it power again: what it was told is lost, but for what it keeps."""
        self._powered = True
        self._firmware.restart()
