"""The devices of an io file with their drivers: what is on the bus, and what is on lines of its own."""

from __future__ import annotations

from firmware_py.adapters.buses.can_bus import FramePort
from firmware_py.adapters.device_hardware import DeviceHardware
from firmware_py.adapters.drivers.dronecan.devices import DroneCan
from firmware_py.adapters.drivers.stream_driver import ByteStream, StreamDriver
from firmware_py.adapters.drivers.waterlink import WATERLINK
from firmware_py.adapters.io_params import IoParams


def fitted(io: IoParams, fins: int, bus: FramePort, dvl: ByteStream) -> DeviceHardware:
    """Return the hardware of a vehicle with so many fins, on its bus and the line of its DVL."""
    return DeviceHardware(fins, (DroneCan(io, fins, bus), StreamDriver("dvl", WATERLINK, dvl)))
