"""The devices of an io file with their drivers: what is on the bus, and what is on lines of its own."""

from __future__ import annotations

from collections.abc import Sequence

from firmware_py.adapters.buses.can_bus import FramePort
from firmware_py.adapters.device_hardware import DeviceHardware
from firmware_py.adapters.drivers.dronecan.devices import DroneCan
from firmware_py.adapters.drivers.stream_driver import ByteStream, StreamDriver
from firmware_py.adapters.drivers.waterlink import WATERLINK
from firmware_py.adapters.io_params import IoParams
from firmware_py.vehicle.fins import Fin
from firmware_py.wire.dronecan.fin_servo import servos_of


def fitted(io: IoParams, fins: Sequence[Fin], bus: FramePort, dvl: ByteStream) -> DeviceHardware:
    """Return the hardware of a vehicle with these fins, on its bus and the line of its DVL.

    Raises:
        ParamError: the io file has a servo for no fin, none for a fin, or one that does not turn far enough.
    """
    servos = servos_of(io.fins, [fin.name for fin in fins])
    for servo, fin in zip(servos, fins, strict=True):
        servo.refuse_less_than(fin.delta_max)
    return DeviceHardware(len(fins), (DroneCan(io, servos, bus), StreamDriver("dvl", WATERLINK, dvl)))
