"""Lines of instruments in one process: the plant's ends, and those of the autopilot."""

from __future__ import annotations

import contextlib

from firmware_py.adapters.drivers.bar30 import SmBus
from firmware_py.adapters.drivers.instrument_params import Device
from firmware_py.adapters.drivers.instrument_table import I2C_SENSORS
from firmware_py.adapters.drivers.stream_driver import ByteStream
from firmware_py.adapters.fitting import open_line
from sim_bridge.devices.i2c_line import I2cLine
from sim_bridge.devices.serial_line import SerialLine

PlantEnd = SerialLine | I2cLine


def opened(stack: contextlib.ExitStack, device: Device, timeout: float) -> tuple[PlantEnd, ByteStream | SmBus]:
    """Open a line: a pseudo-terminal, or an I2C bus, of which both ends are one. `stack` closes the plant's.

    Args:
        stack: closes it.
        device: what is on it.
        timeout: how long the plant waits for bytes to arrive, s.
    """
    if device.line.driver in I2C_SENSORS:
        bus = stack.enter_context(I2cLine())
        return bus, bus
    line = stack.enter_context(SerialLine(timeout))
    return line, open_line(device, line.path)
