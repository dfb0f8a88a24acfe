"""The devices of an io file with their drivers: what is on the bus, and what is on lines of its own."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

from firmware_py.adapters.buses.awaited_bus import AwaitedBus
from firmware_py.adapters.buses.can_bus import CanBus, FramePort, open_bus
from firmware_py.adapters.buses.shared_port import split
from firmware_py.adapters.device_hardware import DeviceHardware
from firmware_py.adapters.drivers.bar30 import SmBus
from firmware_py.adapters.drivers.bus_watch import BusWatch
from firmware_py.adapters.drivers.canopen.drives import CanOpenDrives
from firmware_py.adapters.drivers.driver import Driver
from firmware_py.adapters.drivers.dronecan.devices import DroneCan
from firmware_py.adapters.drivers.dronecan.node_roles import roles_of, shared_bits
from firmware_py.adapters.drivers.dronecan.own_node import KeptNodeIds
from firmware_py.adapters.drivers.dynamixel.servos import DynamixelServos
from firmware_py.adapters.drivers.i2c_bus import I2cBus
from firmware_py.adapters.drivers.instrument_params import Device
from firmware_py.adapters.drivers.instrument_table import I2C_SENSORS, INSTRUMENTS
from firmware_py.adapters.drivers.serial_port import SerialPort
from firmware_py.adapters.drivers.stream_driver import ByteStream, StreamDriver
from firmware_py.adapters.drivers.tcp_stream import TcpStream
from firmware_py.adapters.fin_reports import FinReports
from firmware_py.adapters.io_params import IoParams
from firmware_py.params import ParamError
from firmware_py.vehicle.fins import Fin
from firmware_py.wire.canopen.fin_drive import FinDrive, drives_of
from firmware_py.wire.dronecan.fin_servo import FinServo, servos_of
from firmware_py.wire.fin_positions import FinPositions
from firmware_py.wire.serial import dynamixel_fins


def fitted(
    io: IoParams,
    fins: Sequence[Fin],
    bus: FramePort,
    lines: Sequence[ByteStream | SmBus],
    second: FramePort | None = None,
    node_ids: KeptNodeIds | None = None,
) -> DeviceHardware:
    """Return the hardware of a vehicle with these fins.

    Args:
        io: the io file.
        fins: of the vehicle.
        bus: that of the DroneCAN devices.
        lines: of `io.lines`, in their order.
        second: the bus of the fin drives, if it is another one.
        node_ids: given out in earlier runs.

    Raises:
        ParamError: the io file has a servo for no fin, none for a fin, or one that does not turn far enough.
    """
    drives, on_line, servos = actuators_of(io, fins)
    watches: list[Driver] = [BusWatch("bus", bus)]
    if drives and second is None:
        bus, standard = split(bus)
        watches.append(CanOpenDrives(io.canopen, drives, standard, "canopen_"))
    elif second is not None:
        watches += [CanOpenDrives(io.canopen, drives, second, "second_bus_"), BusWatch("second_bus", second)]
    own: list[Driver] = []
    for device, line in zip(io.lines, lines, strict=True):
        if device.role == "fins":
            own.append(DynamixelServos(device.source, io.dynamixel, on_line, cast("ByteStream", line)))
        else:
            own.append(_driver(device, line))
    counts = Counter(device.role for device in io.devices)
    spares = {role: count - 1 for role, count in counts.items() if count > 1}
    reports = FinReports([fin.name for fin in fins], [one.reach for one in drives or on_line or servos])
    return DeviceHardware(reports, [DroneCan(io, servos, bus, node_ids), *watches, *own], spares)


def actuators_of(
    io: IoParams, fins: Sequence[Fin]
) -> tuple[tuple[FinDrive, ...], tuple[dynamixel_fins.DynamixelFin, ...], tuple[FinServo, ...]]:
    """Return what moves the fins, in their order: drives, servos on a line, or servos on the bus.

    Raises:
        ParamError: a servo for no fin, none for a fin, or one that does not turn far or fast enough.
    """
    names = [fin.name for fin in fins]
    drives, on_line = drives_of(io.canopen.fins, names), dynamixel_fins.servos_of(io.dynamixel.fins, names)
    servos = () if drives or on_line else servos_of(io.fins, names)
    moved: Sequence[FinServo | FinPositions] = drives or on_line or servos
    for one, fin in zip(moved, fins, strict=True):
        one.refuse_less_than(fin.delta_max)
        if isinstance(one, FinPositions):
            one.refuse_slower_than(fin.rate_max)
    return drives, on_line, servos


def shared_nodes(io: IoParams, fins: Sequence[Fin]) -> dict[str, list[int]]:
    """Return what a configuration says of the nodes with several roles; nothing where there is none.

    Raises:
        ParamError: the io file has a servo for no fin, none for a fin, or one that does not turn far enough.
    """
    _, _, servos = actuators_of(io, fins)
    bits = shared_bits(roles_of(io, servos))
    return {"shared_nodes": bits} if bits else {}


def open_second(io: IoParams, spec: str, stack: ExitStack, *, awaited: bool = False) -> CanBus | None:
    """Open the second bus of an io file, if it has one: that of the fin drives; `stack` closes it.

    Args:
        io: the io file.
        spec: the first bus, that of the DroneCAN devices.
        stack: closes it.
        awaited: whether one that is not there yet is silence, and not an error.

    Raises:
        BusError: it cannot be opened.
        ParamError: it is the first one.
    """
    io.refuse_second_bus_on(spec)
    if not (io.canopen.fins and io.canopen.bus):
        return None
    bus = (AwaitedBus if awaited else open_bus)(io.canopen.bus, standard=True)
    stack.callback(bus.close)
    return bus


def places_of(io: IoParams, spec: str, dvl: str | None = None) -> list[str]:
    """Return the port of each of `io.lines` for a bus; `dvl` is that of the first DVL, if it is another one.

    Raises:
        ParamError: a DVL's port, but no DVL.
    """
    places = [device.place(spec) for device in io.lines]
    if dvl is not None:
        first = next((i for i, device in enumerate(io.lines) if device.role == "dvl"), None)
        if first is None:
            raise ParamError(f"--dvl {dvl}: the io file has no DVL on a line of its own")
        places[first] = dvl
    return places


def at_desk(io: IoParams, folder: Path) -> IoParams:
    """Return the same io file with its lines at a desk: serial devices in a folder, TCP ports on this computer.

    Args:
        io: the io file.
        folder: where serial devices have the last part of their names, and bus i2c:1 is the socket i2c-1.

    Raises:
        ParamError: two devices would have one place there.
    """
    taken: dict[str, str] = {}

    def moved(port: str) -> str:
        asked = port
        if port.startswith("tcp:"):
            port = f"tcp:127.0.0.1:{port.rpartition(':')[2]}"
        elif port.startswith("i2c:"):
            port = f"i2c:{folder.resolve()}/{port.replace(':', '-')}"
        elif port:
            port = str(folder / Path(port).name)
        if port and taken.setdefault(port, asked) != asked:
            raise ParamError(f"instruments: {taken[port]} and {asked} would both be {port} at a desk; rename one")
        return port

    instruments = tuple([replace(one, port=moved(one.port)) for one in io.instruments])
    return replace(io, instruments=instruments, dynamixel=replace(io.dynamixel, port=moved(io.dynamixel.port)))


def open_line(device: Device, port: str, *, absent: bool = False) -> SerialPort | TcpStream | I2cBus:
    """Open the line of a device: a serial device, tcp:HOST:PORT, or the bus i2c:N.

    Args:
        device: one of `io.lines`.
        port: its place.
        absent: whether what is not there yet is silence, and not an error.

    Raises:
        BusError: it cannot be opened.
    """
    if port.startswith("i2c:"):
        return I2cBus(device.name, port, absent=absent)
    if port.startswith("tcp:"):
        return TcpStream(device.name, port, absent=absent)
    return SerialPort(device.name, port, device.line.baud, absent=absent)


def _driver(device: Device, line: Any) -> Driver:
    """Return the driver of a device on its line."""
    name = device.table.driver
    if name in I2C_SENSORS:
        return I2C_SENSORS[name].driver(device.source, line, device.latency, device.number)
    return StreamDriver(device.source, INSTRUMENTS[name], line, device.latency, device.mounting, device.number)
