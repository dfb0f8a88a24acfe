"""The devices of an io file, opened for a bench tool: what is not there is no error, but something to tell."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.adapters.device_hardware import DeviceHardware
from firmware_py.adapters.drivers.dronecan.bus_params import NetworkParams
from firmware_py.adapters.drivers.dronecan.node_roles import SENDS
from firmware_py.adapters.drivers.i2c_bus import I2cBus
from firmware_py.adapters.drivers.instrument_params import Device
from firmware_py.adapters.fitting import fitted, open_line, open_second
from firmware_py.adapters.io_params import IoParams
from firmware_py.records.sensing import NODE_OF, candidate_name
from firmware_py.vehicle.fins import Fin
from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan.fin_servo import servos_of
from firmware_py.wire.dronecan.message_table import MessageType
from sternplane.hardware.fin_tables import HUB, FinTable, table_of
from sternplane.hardware.shared_bus import shared_bus
from sternplane.hardware.watched_bus import WatchedBus

_MESSAGE_OF: Mapping[str, MessageType[Any]] = {role: SENDS[name][0] for role, name in NODE_OF.items()}
"""What a node sends that measures a role."""
_OTHERS: Mapping[str, tuple[str, MessageType[Any]]] = {
    "n": ("esc", m.ESC_STATUS),
    "battery": ("battery", m.BATTERY_INFO),
    "leak": ("battery", m.HYGROMETER),
    "hardpoint": ("hardpoint", m.HARDPOINT_STATUS),
}
"""The node in [nodes] of the other roles, and what it sends; the fins are apart."""


class Place(NamedTuple):
    """Where a role is measured.

    Attributes:
        device: for people.
        name: of the device, as counts of losses begin.
        key: where its place stands in the io file.
        node: its node id on the bus; 0 for what is on a line of its own.
        sends: the name of the message that is wanted of the node.
        data_type_id: of that message.
        number: of the actuator or motor that the message must be about; -1 for any.
    """

    device: str
    name: str
    key: str
    node: int = 0
    sends: str = ""
    data_type_id: int = 0
    number: int = -1


class CountedLine:
    """A line of its own for a driver, which counts what comes.

    Attributes:
        missing: why there is none; "" if there is one.
        received: how many bytes have come.
        openings: how often it was opened.
    """

    def __init__(self, device: Device, port: str) -> None:
        self.missing, self.received, self.openings = "", 0, 0
        self._port: Any = None
        try:
            self._port = open_line(device, port, absent=True)
            self.missing = self._port.missing
        except BusError as error:
            self.missing = str(error)

    def read(self, t: float) -> bytes:
        """Return the bytes that have arrived."""
        if self._port is None:
            return b""
        data: bytes = self._port.read(t)
        self.openings = self._port.openings
        if data:
            self.missing = ""
        self.received += len(data)
        return data

    def write(self, data: bytes) -> None:
        """Send what the driver asks of its device."""
        if self._port is not None:
            self._port.write(data)

    def losses(self) -> dict[str, int]:
        """Return what is wrong with the line."""
        return {} if self._port is None else dict(self._port.losses())

    def close(self) -> None:
        """Leave it."""
        if self._port is not None:
            self._port.close()


class NoLine:
    """The line of a device that a tool leaves alone: silence, on a stream and on I2C."""

    openings = 0

    def read(self, _t: float) -> bytes:
        """Return nothing."""
        return b""

    def write(self, _data: bytes) -> None:
        """Send nothing."""

    def write_byte(self, *_: int) -> None:
        """Say that nobody answers."""
        raise OSError

    def read_i2c_block_data(self, *_: int) -> list[int]:
        """Say that nobody answers."""
        raise OSError

    def losses(self) -> dict[str, int]:
        """Return nothing."""
        return {}

    def close(self) -> None:
        """Leave it."""


class FittedVehicle(NamedTuple):
    """The hardware of a vehicle, and where each role is measured.

    Attributes:
        hardware: all of it.
        bus: the bus that it is on.
        places: by role, as `heard_roles` names them.
        lines: the lines of devices that are not on the bus, by role.
        table: where the io file describes the fins' servos.
    """

    hardware: DeviceHardware
    bus: WatchedBus
    places: dict[str, Place]
    lines: dict[str, CountedLine | I2cBus]
    table: FinTable = HUB


@contextlib.contextmanager
def fitted_vehicle(
    io: IoParams,
    fins: Sequence[Fin],
    spec: str,
    see: Callable[[int, bytes, float], None],
    ports: Sequence[str] | None = None,
) -> Iterator[FittedVehicle]:
    """Yield the hardware of a vehicle.

    Args:
        io: the io file; what the autopilot does for other nodes, as to say the time, is left out.
        fins: of the vehicle.
        spec: the bus.
        see: is given every frame of the bus.
        ports: those of `io.lines`; None leaves these devices alone, but for the line of the fins.

    Raises:
        BusError, ParamError, UsageError: in one line, what cannot be used.
    """
    with contextlib.ExitStack() as stack:
        watched = WatchedBus(stack.enter_context(shared_bus(spec, standard=io.canopen.shares_bus)), see)
        places = ports if ports is not None else [device.place(spec) for device in io.lines]
        lines: list[Any] = []
        for device, port in zip(io.lines, places, strict=True):
            if ports is None and device.role != "fins":
                lines.append(NoLine())
            elif port.startswith("i2c:"):
                lines.append(open_line(device, port, absent=True))
            else:
                lines.append(CountedLine(device, port))
        alone = replace(io, network=NetworkParams(time_master=False, allocate=False))
        hardware = fitted(alone, fins, watched, lines, open_second(io, spec, stack, awaited=True))
        stack.callback(hardware.close)
        counted = {
            role: line
            for device, line in zip(io.lines, lines, strict=True)
            if isinstance(line, CountedLine | I2cBus)
            for role in _roles_of(device, fins)
        }
        yield FittedVehicle(hardware, watched, places_by_role(io, fins, spec, ports), counted, table_of(io))


def places_by_role(
    io: IoParams, fins: Sequence[Fin], spec: str, ports: Sequence[str] | None = None
) -> dict[str, Place]:
    """Return where each role is measured: fields of `SensorFrame`, "ROLE.2" of a second device, "fin NAME"."""

    def place(node: int, name: str, key: str, kind: MessageType[Any], number: int = -1) -> Place:
        which = "" if number < 0 else f", number {number}"
        return Place(f"node {node} on {spec}{which}", name, key, node, kind.name, kind.data_type_id, number)

    places = iter(ports if ports is not None else [device.place(spec) for device in io.lines])
    found: dict[str, Place] = {}
    for device in io.devices:
        role = candidate_name(device.role, device.number)
        if device.node:
            found[role] = place(device.node, device.source, _key(device), _MESSAGE_OF[device.role])
        else:
            port, baud = next(places), device.line.baud
            where = f"port {port}, {baud} baud" if port.startswith("/") else f"port {port}"
            found[role] = Place(where, device.source, device.key)
    for role, (name, kind) in _OTHERS.items():
        found[role] = place(getattr(io.nodes, name), name, f"[nodes] {name}", kind)
    found["n"] = place(io.nodes.esc, "esc", "[nodes] esc, [propeller] index", m.ESC_STATUS, io.propeller.index)
    names = [fin.name for fin in fins]
    if io.dynamixel.fins:
        port = next(places)
        for one in io.dynamixel.fins:
            where = f"port {port}, {io.dynamixel.baud} baud, servo {one.id}"
            found[f"fin {one.name}"] = Place(where, one.name, "[[dynamixel.fins]] id")
        return found
    if io.canopen.fins:
        bus = io.canopen.bus or spec
        for drive in io.canopen.fins:
            found[f"fin {drive.name}"] = Place(
                f"drive {drive.node} on {bus}", f"drive{drive.node}", "[[canopen.fins]] node"
            )
        return found
    key = "[[fins]] node, id and status_id" if io.fins else "[nodes] servo_hub; [[fins]] for other ids than 0, 1, ..."
    for name, servo in zip(names, servos_of(io.fins, names), strict=True):
        own = servo.params.node
        hub = f"servo{own}" if own else "servo_hub"
        found[f"fin {name}"] = place(own or io.nodes.servo_hub, hub, key, m.ACTUATOR_STATUS, servo.status_id)
    return found


def _roles_of(device: Device, fins: Sequence[Fin]) -> list[str]:
    """Return the roles that are measured on a line."""
    if device.role == "fins":
        return [f"fin {fin.name}" for fin in fins]
    return [candidate_name(device.role, device.number)]


def _key(device: Device) -> str:
    """Return where a device on the bus stands in the io file."""
    return device.key.replace("nodes.", "[nodes] ") if device.instrument is None else f"{device.key} node"
