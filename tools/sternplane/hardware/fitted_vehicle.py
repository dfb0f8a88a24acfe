"""The devices of an io file, opened for a bench tool: what is not there is no error, but something to tell."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.adapters.device_hardware import DeviceHardware
from firmware_py.adapters.drivers.serial_port import SerialPort
from firmware_py.adapters.fitting import fitted
from firmware_py.adapters.io_params import IoParams, NetworkParams
from firmware_py.vehicle.fins import Fin
from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan.fin_servo import servos_of
from firmware_py.wire.dronecan.message_table import MessageType
from sternplane.hardware.shared_bus import shared_bus
from sternplane.hardware.watched_bus import WatchedBus

_MEASURED_BY: Mapping[str, tuple[str, MessageType[Any]]] = {
    "ahrs": ("ahrs", m.AHRS_SOLUTION),
    "pressure": ("pressure", m.STATIC_PRESSURE),
    "altitude": ("altimeter", m.RANGE_MEASUREMENT),
    "fix": ("fix", m.FIX2),
    "n": ("esc", m.ESC_STATUS),
    "battery": ("battery", m.BATTERY_INFO),
    "leak": ("battery", m.HYGROMETER),
    "hardpoint": ("hardpoint", m.HARDPOINT_STATUS),
}
"""The node of each role in table [nodes], and what it sends; the fins are apart."""


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
    """A serial line for a driver, which counts what comes.

    Attributes:
        missing: why there is no port; "" if there is one.
        received: how many bytes have come.
        openings: how often it was opened.
    """

    def __init__(self, device: str, port: str, baud: int) -> None:
        self.missing, self.received, self.openings = "", 0, 0
        self._port: SerialPort | None = None
        try:
            self._port = SerialPort(device, port, baud, absent=True)
            self.missing = self._port.missing
        except BusError as error:
            self.missing = str(error)

    def read(self, t: float) -> bytes:
        """Return the bytes that have arrived."""
        if self._port is None:
            return b""
        data = self._port.read(t)
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
        return {} if self._port is None else self._port.losses()

    def close(self) -> None:
        """Leave it."""
        if self._port is not None:
            self._port.close()


class NoLine(CountedLine):
    """The line of a device that a tool does not need."""

    def __init__(self) -> None:
        self.missing, self.received, self.openings = "", 0, 0
        self._port = None


class FittedVehicle(NamedTuple):
    """The hardware of a vehicle, and where each role is measured.

    Attributes:
        hardware: all of it.
        bus: the bus that it is on.
        places: by role, as `heard_roles` names them.
        lines: the devices on lines of their own, by role.
    """

    hardware: DeviceHardware
    bus: WatchedBus
    places: dict[str, Place]
    lines: dict[str, CountedLine]


@contextlib.contextmanager
def fitted_vehicle(
    io: IoParams,
    fins: Sequence[Fin],
    spec: str,
    dvl: str | None,
    see: Callable[[int, bytes, float], None],
) -> Iterator[FittedVehicle]:
    """Yield the hardware of a vehicle.

    Args:
        io: the io file; what the autopilot does for other nodes, as to say the time, is left out.
        fins: of the vehicle.
        spec: the bus.
        dvl: the DVL's serial port; None leaves it alone.
        see: is given every frame of the bus.

    Raises:
        BusError, ParamError, UsageError: in one line, what cannot be used.
    """
    with shared_bus(spec) as bus:
        watched = WatchedBus(bus, see)
        line = NoLine() if dvl is None else CountedLine("dvl", dvl, io.dvl.baud)
        alone = replace(io, network=NetworkParams(time_master=False, allocate=False))
        hardware = fitted(alone, fins, watched, line)
        places = {**_on_the_bus(io, fins, spec), "dvl": Place(f"port {dvl}, {io.dvl.baud} baud", "dvl", "[dvl]")}
        try:
            yield FittedVehicle(hardware, watched, places, {"dvl": line})
        finally:
            hardware.close()


def _on_the_bus(io: IoParams, fins: Sequence[Fin], spec: str) -> dict[str, Place]:
    def place(node: int, name: str, key: str, kind: MessageType[Any], number: int = -1) -> Place:
        which = "" if number < 0 else f", number {number}"
        return Place(f"node {node} on {spec}{which}", name, key, node, kind.name, kind.data_type_id, number)

    found = {
        role: place(getattr(io.nodes, name), name, f"[nodes] {name}", kind)
        for role, (name, kind) in _MEASURED_BY.items()
    }
    found["n"] = place(io.nodes.esc, "esc", "[nodes] esc, [propeller] index", m.ESC_STATUS, io.propeller.index)
    key = "[[fins]] node, id and status_id" if io.fins else "[nodes] servo_hub; [[fins]] for other ids than 0, 1, ..."
    for fin, servo in zip(fins, servos_of(io.fins, [fin.name for fin in fins]), strict=True):
        own = servo.params.node
        node, name = own or io.nodes.servo_hub, f"servo{own}" if own else "servo_hub"
        found[f"fin {fin.name}"] = place(node, name, key, m.ACTUATOR_STATUS, servo.status_id)
    return found
