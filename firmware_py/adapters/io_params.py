"""io_*.toml as the vehicle reads it: the bus, the node ids, the latency of each device."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

from firmware_py.adapters.buses.can_bus import CanParams, NodeIds
from firmware_py.adapters.linux_realtime import RealtimeParams
from firmware_py.adapters.storage.log_params import LogParams
from firmware_py.params import ParamError, param
from firmware_py.tick import Rate
from firmware_py.wire.dronecan.fin_servo import FinServoParams
from firmware_py.wire.dronecan.propeller_drive import PropellerParams


@dataclass(frozen=True, slots=True)
class DvlPortParams:
    """Table [dvl] of io_*.toml."""

    port: str = param(doc="Serial device of the DVL; {bus} in it stands for the name of the bus.")
    baud: int = param(115200, low=1200, high=4_000_000, doc="Bits a second; the device's default is 115200.")

    def place(self, spec: str) -> str:
        """Return the port for a bus: "{bus}" in its name is replaced, so that several simulations can run at once."""
        return self.port.replace("{bus}", spec.replace(":", "-").replace("/", "-"))


@dataclass(frozen=True, slots=True)
class CommandParams:
    """Table [commands]."""

    rate: Rate = Rate.HZ_50
    safety_state: bool = param(True, doc="Whether SafetyState is sent: AP_Periph holds its outputs until it hears it.")


@dataclass(frozen=True, slots=True)
class LatencyParams:
    """Table [latency]: delay from the validity of a value to its arrival; the DVL reports its own."""

    ahrs: float = param(0.0, unit="s", low=0.0, high=1.0, doc="Attitude and rates.")
    pressure: float = param(0.0, unit="s", low=0.0, high=1.0, doc="Water pressure.")
    altimeter: float = param(0.0, unit="s", low=0.0, high=1.0, doc="Distance to the bottom.")
    fix: float = param(0.0, unit="s", low=0.0, high=2.0, doc="Position at the surface.")
    servo_hub: float = param(0.0, unit="s", low=0.0, high=1.0, doc="Fin angles.")
    esc: float = param(0.0, unit="s", low=0.0, high=1.0, doc="Propeller speed.")


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
    dvl: DvlPortParams
    commands: CommandParams = field(default_factory=CommandParams)
    fins: tuple[FinServoParams, ...] = ()
    propeller: PropellerParams = field(default_factory=PropellerParams)
    latency: LatencyParams = field(default_factory=LatencyParams)
    state: StateParams = field(default_factory=StateParams)
    log: LogParams = field(default_factory=LogParams)

    def __post_init__(self) -> None:
        """Refuse a device with the id of the autopilot or the plant, and one id for both of these."""
        taken = {self.can.node_id: "can.node_id"}
        devices = {f"nodes.{field.name}": getattr(self.nodes, field.name) for field in fields(self.nodes)}
        for name, node_id in {"can.plant_id": self.can.plant_id, **devices}.items():
            if node_id in taken:
                raise ParamError(f"{name} = {node_id}: is {taken[node_id]} already; every node needs an id of its own")
            taken[node_id] = name
        for one in self.fins:  # several servos may share a node
            if one.node in taken and one.node != self.nodes.servo_hub:
                name, other = f"fins: {one.name} = {one.node}", taken[one.node]
                raise ParamError(f"{name}: is {other} already; every node needs an id of its own")

    @property
    def device_ids(self) -> dict[int, str]:
        """Return the node id of each device on the bus, with its name."""
        named = {getattr(self.nodes, field.name): field.name for field in fields(self.nodes)}
        return {**{one.node: f"servo{one.node}" for one in self.fins if one.node}, **named}

    realtime: RealtimeParams = field(default_factory=RealtimeParams)
