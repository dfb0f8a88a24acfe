"""The devices that measure, as an io file names them: which role each has, and in which order they are believed."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple, Protocol

from firmware_py.adapters.drivers.instrument_table import I2C_SENSORS, INSTRUMENTS
from firmware_py.adapters.drivers.mounting import LEVER_ARMS, STRAIGHT, Mounting
from firmware_py.adapters.tcp_dial import address_of
from firmware_py.error_text import probably, quoted
from firmware_py.params import ParamError, param, prefix_errors
from firmware_py.records.sensing import MOST_CANDIDATES, NODE_OF, ROLES, candidate_name

DRONECAN = "dronecan"
"""The driver of a device on the CAN bus."""
_ROLES = {
    **{name: instrument.role for name, instrument in INSTRUMENTS.items()},
    **{name: sensor.role for name, sensor in I2C_SENSORS.items()},
}
_HOST_PORT = re.compile(r"(?!i2c:)[\w.-]+:\d+")
_ACTUATORS = ("fins", "servo_hub", "propeller", "esc", "hardpoint")
"""What nobody has twice: two that command one actuator would fight."""
_TURNED = ("ahrs", "dvl")
"""What these measure depends on how they are mounted."""


def refuse_port(key: str, port: str) -> None:
    """Refuse the name of a line that would be waited for as a device that never comes.

    Raises:
        ParamError: the name of a TCP port in another form, one without host or port, a URL, or no name.
    """
    if port != port.strip() or not port.isprintable():
        raise ParamError(f"{key}port = {quoted(port)}: must be a name without blanks around it")
    if (found := re.match(r"(?i)(tcp|i2c):", port)) and not found[0].islower():
        raise ParamError(f"{key}port = {quoted(port)}: write {found[0].lower()} in small letters")
    if _HOST_PORT.fullmatch(port):
        raise ParamError(f"{key}port = {quoted(port)}: of a TCP port write tcp:{port}")
    if "://" in port:
        raise ParamError(f"{key}port = {quoted(port)}: must be a serial device, or tcp:HOST:PORT")
    if port.startswith("tcp:"):
        with prefix_errors(f"{key}port = {quoted(port)}"):
            address_of(port)


def line_of(port: str) -> str:
    """Return the one name of a line that may be written in several ways: two drivers would take its bytes in turns."""
    if found := re.fullmatch(r"(tcp:.*:)0*(\d+)", port):
        return found[1] + found[2]
    return posixpath.normpath(port)


@dataclass(frozen=True, slots=True)
class InstrumentParams:
    """Table [[instruments]] of io_*.toml: a device on a line of its own, or a further one on the bus.

    Raises:
        ParamError: an unknown driver or role, or a key that this driver needs or does not have.
    """

    ELSEWHERE: ClassVar[Mapping[str, str]] = LEVER_ARMS

    driver: str = param(doc=f'Its protocol: {", ".join(_ROLES)}; or "{DRONECAN}": a node of the bus.')
    port: str = param(
        "", doc="Serial device, tcp:HOST:PORT or i2c:N; {bus} in it stands for the name of the bus. Not of a node."
    )
    baud: int = param(115200, low=1200, high=4_000_000, doc="Bits a second of a serial device.")
    node: int = param(0, low=0, high=127, doc=f'Its node id, of driver "{DRONECAN}".')
    role: str = param("", doc=f'What a node measures, of driver "{DRONECAN}": {", ".join(NODE_OF)}.')
    priority: int = param(
        1, low=1, high=9, doc="Of the devices of a role, that with 1 is believed first. Those of [nodes] have 1."
    )
    latency: float = param(
        0.0, unit="s", low=0.0, high=2.0, doc="From the validity of a value to its arrival, beyond what it tells."
    )
    mounting: Mounting = field(default_factory=Mounting)

    def __post_init__(self) -> None:
        """Refuse what cannot be."""
        if self.driver == DRONECAN:
            if self.role in _ACTUATORS:
                raise ParamError(f"role = {quoted(self.role)}: is no sensor; an actuator has one driver, and no spare")
            if self.role not in NODE_OF:
                meant = next((f"; did you mean {role}?" for role, node in NODE_OF.items() if node == self.role), "")
                known = ", ".join(NODE_OF)
                raise ParamError(f"role = {quoted(self.role)}: must be what the node measures: {known}{meant}")
            if not self.node or self.port:
                raise ParamError(f'driver "{DRONECAN}" needs the node id of the device, node = ID, and no port')
            self._refuse_mounting()
            return
        if self.driver not in _ROLES:
            raise ParamError(f"driver = {quoted(self.driver)} is unknown; {probably(self.driver, [*_ROLES, DRONECAN])}")
        if not self.port or self.node or self.role:
            raise ParamError(f'driver "{self.driver}" needs the port of the device, port = NAME, and no node or role')
        refuse_port("", self.port)
        if (self.driver in I2C_SENSORS) != self.port.startswith("i2c:"):
            right = "i2c:N for /dev/i2c-N" if self.driver in I2C_SENSORS else "a serial device or tcp:HOST:PORT"
            raise ParamError(f'port = {quoted(self.port)}: of driver "{self.driver}" it must be {right}')
        if plain := re.fullmatch(r"i2c:0+(\d+)", self.port):  # one chip under two names would have two drivers
            raise ParamError(f"port = {quoted(self.port)}: write i2c:{plain[1]}")
        self._refuse_mounting()

    @property
    def measures(self) -> str:
        """Return its role, one of `sensing.ROLES`."""
        return self.role or _ROLES[self.driver]

    def _refuse_mounting(self) -> None:
        if self.mounting != STRAIGHT and self.measures not in _TURNED:
            raise ParamError(f"mounting: of {self.measures} it changes nothing; leave it out")
        if self.mounting.declination and self.measures != "ahrs":
            raise ParamError(f"mounting: declination_deg of {self.measures} changes nothing; leave it out")


class LineTable(Protocol):
    """A table of the io file that names a line: `InstrumentParams`, `DynamixelParams`."""

    @property
    def driver(self) -> str:
        """Return the name of the driver."""

    @property
    def port(self) -> str:
        """Return where the line is; {bus} in it stands for the name of the bus."""

    @property
    def baud(self) -> int:
        """Return bits a second of a serial line."""


class Device(NamedTuple):
    """A device that has a role, or the line of all fins' servos.

    Attributes:
        key: where it stands in the io file.
        role: one of `sensing.ROLES`, or "fins".
        number: its place in the order of priority, from 0.
        node: its id; 0: it is not on the bus.
        latency: s.
        instrument: its table; None: it stands in [nodes], or has no role of its own.
        on: the line that it is on; None: it is on the bus.
    """

    key: str
    role: str
    number: int
    node: int
    latency: float
    instrument: InstrumentParams | None
    on: LineTable | None = None

    @property
    def name(self) -> str:
        """Return its name for people, as nodes have it: "dvl", "altimeter", "pressure.2"."""
        return candidate_name(NODE_OF.get(self.role, self.role), self.number)

    @property
    def mounting(self) -> Mounting:
        """Return how it is turned in the body; what stands in [nodes] sits straight."""
        return self.instrument.mounting if self.instrument else STRAIGHT

    @property
    def table(self) -> InstrumentParams:
        """Return its table.

        Raises:
            LookupError: it stands in [nodes].
        """
        if self.instrument is None:
            raise LookupError(f"{self.key}: has no table of its own")
        return self.instrument

    @property
    def line(self) -> LineTable:
        """Return the table of the line that it is on.

        Raises:
            LookupError: it is on the bus.
        """
        if self.on is None:
            raise LookupError(f"{self.key}: is on the bus")
        return self.on

    def place(self, spec: str) -> str:
        """Return its port for a bus: "{bus}" in its name is replaced, so that several simulations can run at once."""
        return self.line.port.replace("{bus}", spec.replace(":", "-").replace("/", "-"))

    @property
    def source(self) -> str:
        """Return the same as the beginning of the names of its losses."""
        return self.name.replace(".", "_")


def devices_of(
    nodes: Mapping[str, int], latencies: Mapping[str, float], instruments: Sequence[InstrumentParams]
) -> tuple[Device, ...]:
    """Return all devices with a role: by roles, and of each by their priority.

    Args:
        nodes: ids of those in [nodes], by role; 0: there is none.
        latencies: theirs, s, by role.
        instruments: the others.

    Raises:
        ParamError: two of one priority, too many for a role, or none for one without which no vehicle is steered.
    """
    found: list[Device] = []
    for role in ROLES:
        ranked: dict[int, Device] = {}
        if nodes.get(role):
            key = f"nodes.{NODE_OF[role]}"
            ranked[1] = Device(key, role, 0, nodes[role], latencies[role], None)
        for i, one in enumerate(instruments):
            if one.measures != role:
                continue
            key = f"instruments[{i}]"
            if (other := ranked.get(one.priority)) is not None:
                move = ', or list that node as driver "dronecan"' if other.instrument is None else ""
                raise ParamError(f"{key}: {role} has priority {one.priority}, as {other.key} has; give another{move}")
            ranked[one.priority] = Device(key, role, 0, one.node, one.latency, one, None if one.node else one)
        if len(ranked) > MOST_CANDIDATES:
            raise ParamError(f"instruments: {len(ranked)} devices measure {role}; {MOST_CANDIDATES} are the most")
        if not ranked and role in ("ahrs", "pressure"):
            raise ParamError(f"nodes: nothing measures {role}; give nodes.{role}, or one of [[instruments]] that does")
        found += [ranked[priority]._replace(number=n) for n, priority in enumerate(sorted(ranked))]
    return tuple(found)
