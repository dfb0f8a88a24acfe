"""io_*.toml as the vehicle reads it: the bus, the node ids, the instruments, the latency of each device."""

from __future__ import annotations

from dataclasses import dataclass, field

from firmware_py.adapters.buses.can_bus import CanParams, NodeIds, same_bus, unknown_kind
from firmware_py.adapters.drivers.dronecan.bus_params import CommandParams, LatencyParams, NetworkParams
from firmware_py.adapters.drivers.dronecan.node_client import TOOL_ID
from firmware_py.adapters.drivers.instrument_params import Device, InstrumentParams, devices_of, line_of, refuse_port
from firmware_py.adapters.linux_realtime import RealtimeParams
from firmware_py.adapters.storage.log_params import LogParams
from firmware_py.error_text import quoted
from firmware_py.params import ParamError, param
from firmware_py.records.sensing import NODE_OF
from firmware_py.wire.canopen.fin_drive import CanOpenParams
from firmware_py.wire.dronecan.fin_servo import FinServoParams, refuse_shared_ids
from firmware_py.wire.dronecan.propeller_drive import PropellerParams
from firmware_py.wire.serial.dynamixel_fins import DynamixelParams


@dataclass(frozen=True, slots=True)
class StateParams:
    """Table [state]: what is kept from one run to the next, and how far a vehicle goes between them."""

    interval: float = param(5.0, unit="s", low=0.5, high=3600.0, doc="How often navigation is saved in flight.")
    drift_std: float = param(
        0.5,
        unit="m/s",
        low=0.0,
        high=10.0,
        doc="1 sigma of the velocity of a vehicle that lies still, as of a current.",
    )
    coast_time: float = param(
        10.0, unit="s", low=0.0, high=600.0, doc="For so long it goes on as fast as it was when its program ended."
    )
    unknown_std: float = param(
        1e4,
        unit="m",
        low=1.0,
        high=1e7,
        doc="1 sigma of the position after an unknown time, and after any time at most.",
    )
    armed_time: float = param(
        3600.0,
        unit="s",
        low=0.0,
        high=1e6,
        doc="A vehicle that was armed so long ago at most, by a known time, may come up by itself.",
    )
    passport_interval: float = param(
        30.0,
        unit="s",
        low=1.0,
        high=3600.0,
        doc="How often what is learned is saved in flight; what it was so long before damage is found is good.",
    )
    passport_std: float = param(
        15.0,
        unit="%",
        low=0.0,
        high=1000.0,
        doc="How much less certain it is in the next run, of its 1 sigma before any flight: trim, fins mounted anew.",
    )
    passport_year_std: float = param(
        50.0, unit="%", low=0.0, high=1000.0, doc="The same for a year between, growing with the square root of time."
    )
    clock_kept: bool = param(True, doc="Whether the computer's clock goes on without power.")


@dataclass(frozen=True, slots=True)
class IoParams:
    """All of io_*.toml."""

    can: CanParams
    nodes: NodeIds
    instruments: tuple[InstrumentParams, ...] = ()
    commands: CommandParams = field(default_factory=CommandParams)
    network: NetworkParams = field(default_factory=NetworkParams)
    fins: tuple[FinServoParams, ...] = ()
    propeller: PropellerParams = field(default_factory=PropellerParams)
    latency: LatencyParams = field(default_factory=LatencyParams)
    state: StateParams = field(default_factory=StateParams)
    log: LogParams = field(default_factory=LogParams)

    def __post_init__(self) -> None:
        """Refuse an unknown bus, an id of autopilot or plant for a device, a role twice at a node, one port for two."""
        for key, bus in (("can.bus", self.can.bus), ("canopen.bus", self.canopen.bus)):
            if bus and (why := unknown_kind(bus)):
                raise ParamError(f"{key} = {quoted(bus)}: {why}")
        taken = {TOOL_ID: "that of bench tools"}
        own = {"can.node_id": self.can.node_id, "can.plant_id": self.can.plant_id}
        devices = {f"nodes.{name}": node_id for name, node_id in self.nodes.by_name.items()}
        further = {f"{device.key}.node": device.node for device in self.devices if device.instrument and device.node}
        servos = {f"fins: {one.name}: node": one.node for one in self.fins if one.node}
        for name, node_id in {**own, **devices, **further, **servos}.items():
            if node_id in taken:
                raise ParamError(f"{name} = {node_id}: is {taken[node_id]} already; give another")
            if name in own:
                taken[node_id] = name
        self._refuse_role_twice()
        refuse_shared_ids(self.fins, self.nodes.servo_hub)
        ports = {line_of(self.dynamixel.port): "dynamixel"} if self.dynamixel.fins else {}
        for i, instrument in enumerate(self.instruments):
            key = f"instruments[{i}]"
            if instrument.port and (other := ports.setdefault(line_of(instrument.port), key)) != key:
                raise ParamError(f"{key}: port {quoted(instrument.port)} is that of {other} already; each has its own")
        if self.dynamixel.fins:
            refuse_port("dynamixel.", self.dynamixel.port)
            if self.dynamixel.port.startswith("i2c:"):
                raise ParamError(
                    f"dynamixel.port = {quoted(self.dynamixel.port)}: must be a serial device or tcp:HOST:PORT"
                )
        tables = {"fins": self.fins, "canopen.fins": self.canopen.fins, "dynamixel.fins": self.dynamixel.fins}
        given = [key for key, fins in tables.items() if fins]
        if len(given) > 1:
            raise ParamError(f"{given[1]}: there are [[{given[0]}]] too; all fins have servos of one protocol")
        self.refuse_second_bus_on(self.can.bus)

    def _refuse_role_twice(self) -> None:
        """Refuse two devices of one role at one node: a node may be several devices, told apart by their messages."""
        first: dict[tuple[str, int], str] = {}
        for device in self.devices:
            if device.node and (other := first.setdefault((device.role, device.node), device.key)) != device.key:
                raise ParamError(
                    f"{device.key}.node = {device.node}: {other} is {device.role} of that node already, and two of its "
                    "messages cannot be told apart; leave one out, or give its node another id"
                )

    def refuse_second_bus_on(self, spec: str) -> None:
        """Refuse a bus of the fin drives that is that of the DroneCAN devices, `spec`.

        It would be opened twice: two readers of one serial adapter take each other's frames, a maker's library refuses
        the second one, and of an interface of the kernel errors and health would be counted twice.

        Raises:
            ParamError: it is the same.
        """
        bus = self.canopen.bus
        if self.canopen.fins and bus and same_bus(bus, spec):
            raise ParamError(f"canopen.bus = {quoted(bus)}: is that of [can], or of --bus; leave it out, to share it")

    @property
    def devices(self) -> tuple[Device, ...]:
        """Return the devices that measure roles, by roles, and of each by their priority.

        Raises:
            ParamError: see `devices_of`.
        """
        nodes = {role: getattr(self.nodes, name) for role, name in NODE_OF.items()}
        latencies = {role: getattr(self.latency, name) for role, name in NODE_OF.items()}
        return devices_of(nodes, latencies, self.instruments)

    @property
    def lines(self) -> tuple[Device, ...]:
        """Return those of them that are on lines of their own, and behind them that of the fins, if there is one."""
        own = [device for device in self.devices if not device.node]
        if self.dynamixel.fins:
            own.append(Device("dynamixel", "fins", 0, 0, 0.0, None, self.dynamixel))
        return tuple(own)

    @property
    def device_ids(self) -> dict[int, tuple[str, ...]]:
        """Return the names of what each node on the bus is, by its id."""
        named = [(f"servo{one.node}", one.node) for one in self.fins if one.node not in (0, self.nodes.servo_hub)]
        named += self.nodes.by_name.items()
        named += [(device.name, device.node) for device in self.devices if device.node]
        return {node_id: tuple(dict.fromkeys(n for n, at in named if at == node_id)) for _, node_id in named}

    realtime: RealtimeParams = field(default_factory=RealtimeParams)
    canopen: CanOpenParams = field(default_factory=CanOpenParams)
    dynamixel: DynamixelParams = field(default_factory=DynamixelParams)
