"""The devices of an io file with their drivers: what is on the bus, and what is on lines of its own."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from firmware_py.adapters.buses.can_bus import FramePort
from firmware_py.adapters.device_hardware import DeviceHardware
from firmware_py.adapters.drivers.driver import Driver
from firmware_py.adapters.drivers.dronecan.devices import DroneCan
from firmware_py.adapters.drivers.instrument_params import Device
from firmware_py.adapters.drivers.instrument_table import INSTRUMENTS
from firmware_py.adapters.drivers.serial_port import SerialPort
from firmware_py.adapters.drivers.stream_driver import ByteStream, StreamDriver
from firmware_py.adapters.io_params import IoParams
from firmware_py.params import ParamError
from firmware_py.vehicle.fins import Fin
from firmware_py.wire.dronecan.fin_servo import servos_of


def fitted(io: IoParams, fins: Sequence[Fin], bus: FramePort, lines: Sequence[ByteStream]) -> DeviceHardware:
    """Return the hardware of a vehicle with these fins, on its bus and the lines of `io.lines`, in their order.

    Raises:
        ParamError: the io file has a servo for no fin, none for a fin, or one that does not turn far enough.
    """
    servos = servos_of(io.fins, [fin.name for fin in fins])
    for servo, fin in zip(servos, fins, strict=True):
        servo.refuse_less_than(fin.delta_max)
    drivers: list[Driver] = [DroneCan(io, servos, bus)]
    for device, line in zip(io.lines, lines, strict=True):
        if device.instrument is not None:
            instrument = INSTRUMENTS[device.instrument.driver]
            drivers.append(StreamDriver(device.source, instrument, line, device.latency, number=device.number))
    counts = Counter(device.role for device in io.devices)
    return DeviceHardware(len(fins), drivers, {role: count - 1 for role, count in counts.items() if count > 1})


def places_of(io: IoParams, spec: str, dvl: str | None = None) -> list[str]:
    """Return the port of each of `io.lines` for a bus; `dvl` is that of the first DVL, if it is another one.

    Raises:
        ParamError: a DVL's port, but no DVL.
    """
    places = [device.instrument.place(spec) for device in io.lines if device.instrument is not None]
    if dvl is not None:
        first = next((i for i, device in enumerate(io.lines) if device.role == "dvl"), None)
        if first is None:
            raise ParamError(f"--dvl {dvl}: the io file has no DVL on a line of its own")
        places[first] = dvl
    return places


def open_line(device: Device, port: str, *, absent: bool = False) -> SerialPort:
    """Open the line of a device; `absent`: whether one that is not there yet is silence, and not an error.

    Raises:
        BusError: it cannot be opened.
    """
    baud = device.instrument.baud if device.instrument is not None else 0
    return SerialPort(device.name, port, baud, absent=absent)
