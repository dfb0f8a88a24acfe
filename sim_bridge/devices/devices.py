"""All simulated devices: the nodes on the bus, and the instruments on lines of their own.

The autopilot has no other connection to the plant.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple, Protocol

from firmware_py.adapters.buses.can_bus import FramePort, NodeIds
from firmware_py.adapters.buses.shared_port import split
from firmware_py.adapters.drivers.instrument_params import Device
from firmware_py.params import ParamError, table
from firmware_py.wire.canopen.fin_drive import CanOpenParams, FinDrive
from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan.dsdl_types import DecodeError
from firmware_py.wire.dronecan.fin_servo import FinServo
from firmware_py.wire.dronecan.propeller_drive import PropellerDrive, PropellerParams
from firmware_py.wire.dronecan.transfer import Reassembler, Transfer
from firmware_py.wire.serial.dynamixel_fins import DynamixelFin
from sim_bridge.devices.actuator_nodes import Esc, EscParams, FinServos, Hardpoint, HardpointParams, ServoHubParams
from sim_bridge.devices.canopen_drives import FinDrives
from sim_bridge.devices.dynamixel_servos import DynamixelFins
from sim_bridge.devices.faulty_bus import FaultyBus
from sim_bridge.devices.instrument_nodes import publishers
from sim_bridge.devices.instruments import Instruments, InstrumentsParams
from sim_bridge.devices.line_device import Line
from sim_bridge.devices.node import DeviceNode, NodeFunction
from sim_bridge.devices.payload import PayloadDevice, PayloadParams
from sim_bridge.devices.sensors import Corruption, Timing, due
from sim_bridge.plant.plant import Plant

NO_DRIVES = CanOpenParams()
SERVICE = 0x80
"""Bit of a CAN id: a request or a response, addressed to one node."""
FRAMES_PER_TICK = 128
"""Maximum number of frames taken from the bus in one tick; the rest waits."""


@dataclass(frozen=True, slots=True)
class DevicesParams(InstrumentsParams):
    """sensors.toml: the instruments, and the behaviour of the actuator nodes."""

    servo_hub: ServoHubParams
    esc: EscParams
    hardpoint: HardpointParams = table(HardpointParams)
    payload: tuple[PayloadParams, ...] = ()

    def within(self, base_hz: int) -> DevicesParams:
        """Return the same with no device faster than the base rate: a faster one sends once every tick."""
        slowed: dict[str, Any] = {}
        for field in fields(self):
            device = getattr(self, field.name)
            if field.name == "payload":
                slowed[field.name] = tuple(replace(one, rate=min(one.rate, base_hz)) for one in device)
                continue
            key = "rate" if isinstance(device, Timing) else "status"
            slowed[field.name] = replace(device, **{key: min(getattr(device, key), base_hz)})
        return replace(self, **slowed)


class Wiring(NamedTuple):
    """What of an io file the devices go by: node ids, the servo of each fin, the propeller's controller, and which
    of them measure what: of several of a kind each has errors of its own. `on_lines` are those on lines of their own,
    and the line of `line_servos`.
    """

    nodes: NodeIds
    servos: Sequence[FinServo]
    propeller: PropellerParams
    measuring: Sequence[Device] = ()
    canopen: CanOpenParams = NO_DRIVES
    drives: Sequence[FinDrive] = ()
    on_lines: Sequence[Device] = ()
    line_servos: Sequence[DynamixelFin] = ()

    @property
    def spares(self) -> tuple[str, ...]:
        """Return the names of the instruments that are not the first of their kind."""
        return tuple([device.name for device in self.measuring if device.number])


class OnLine(Protocol):
    """An instrument on a line of its own: `LineDevice`, `Ms5837Device`."""

    def update(self, k: int, t: float, plant: Plant) -> None:
        """Measure at tick `k`, at time `t`, s; return when the autopilot can read what is sent then."""

    def switch_off(self) -> None:
        """Take its power away."""

    def switch_on(self) -> None:
        """Give it power again."""


class Devices:
    """Every device of the simulated vehicle, a `bridge.DevicePort`; `nodes` by the names of `NodeIds`.

    Roles of one id in the io file are functions of one node, which speaks for all of them.

    `malformed` counts commands whose payload does not fit their type; they are ignored.
    """

    def __init__(
        self,
        params: DevicesParams,
        wiring: Wiring,
        instruments: Instruments,
        bus: FramePort,
        on_lines: Mapping[str, OnLine],
        base_hz: int,
        autopilot_id: int,
        second_bus: FramePort | None = None,
        fin_line: Line | None = None,
    ) -> None:
        self.bus = FaultyBus(bus)
        ids, servos = wiring.nodes, wiring.servos
        named = ids.by_name | {device.name: device.node for device in wiring.measuring if device.node}
        own = {servo.params.node for servo in servos} - {0, ids.servo_hub}
        roles = dict[int, list[str]]()
        for name, node_id in (*named.items(), *((f"servo{node_id}", node_id) for node_id in sorted(own))):
            roles.setdefault(node_id, []).append(name)
        self._by_id = {
            node_id: DeviceNode(node_id, names[0] if len(names) == 1 else f"node{node_id}", self.bus)
            for node_id, names in roles.items()
        }
        functions = {name: NodeFunction(self._by_id[node_id]) for node_id, names in roles.items() for name in names}
        self.nodes = {name: functions[name] for name in named}
        hub = self.nodes["servo_hub"]
        on_nodes = [functions.get(f"servo{servo.params.node}", hub) for servo in servos]
        self.malformed = 0
        self._port: FramePort = self.bus
        self._hub: FinServos | FinDrives | DynamixelFins = FinServos(params.servo_hub, on_nodes, servos)
        self._drives: FinDrives | None = None
        self._hub_rate, self._esc_rate = params.servo_hub.status, params.esc.status
        self._line_servos: DynamixelFins | None = None
        if fin_line is not None:
            self._hub = self._line_servos = DynamixelFins(wiring.line_servos, fin_line, hub)
            self._hub_rate = base_hz  # they are asked at any time
        if wiring.drives:
            drives_port: FramePort = second_bus if second_bus is not None else self.bus
            if second_bus is None:
                self._port, drives_port = split(self.bus)
            self._hub = self._drives = FinDrives(wiring.canopen, wiring.drives, drives_port, hub)
        self._esc = Esc(params.esc, self.nodes["esc"], PropellerDrive(wiring.propeller))
        self._hardpoint = Hardpoint(params.hardpoint, self.nodes["hardpoint"])
        self._on_lines = on_lines
        self._instruments = instruments
        self._autopilot_id = autopilot_id
        self._saying = [*self._by_id.values()]
        """Who sends NodeStatus here; a sensor of one's own does it itself."""
        mountings = {device.name: device.mounting for device in wiring.measuring}
        self._publishers = publishers(params, instruments, self.nodes, mountings)
        self._commands = Reassembler(
            [m.ARRAY_COMMAND, m.RPM_COMMAND, m.RAW_COMMAND, m.HARDPOINT_COMMAND, m.ARMING_STATUS]
        )
        self._payload: list[PayloadDevice] = []
        self._base_hz = base_hz
        self._hardpoint_rate = params.hardpoint.status

    def initialise(self, plant: Plant) -> None:
        """Sample before tick 0, so that readings delayed by latency arrive from tick 0 on."""
        for sensor in self._instruments.by_name.values():
            for k in range(-sensor.delay, 0):
                sensor.update(k, plant)

    def receive(self, t: float) -> None:
        """Take the commands and requests on the bus at `t`."""
        for steered in (self._drives, self._line_servos):
            if steered is not None:
                steered.receive(t)
        for can_id, data in self._port.drain(FRAMES_PER_TICK):
            if can_id & SERVICE:
                node = self._by_id.get(can_id >> 8 & 0x7F)
                if node is not None:
                    node.accept_request(can_id, data, t)
            else:
                transfer = self._commands.accept(can_id, data, t)
                if transfer is not None:
                    self._accept_command(transfer, t)
        self._hardpoint.watch(t)

    def commands(self, t: float, fins: Sequence[float]) -> tuple[Sequence[float], float]:
        """Return the commands to servos (rad) and shaft (rev/s) at `t`; `fins` are the true angles."""
        return self._hub.commands(t, fins), self._esc.command(t)

    @property
    def released(self) -> bool:
        """Return whether the drop weight was let go."""
        return self._hardpoint.released

    @property
    def babbled(self) -> int:
        """Return how many frames of no use a babbling node has sent."""
        return self.bus.babbled

    def publish(self, k: int, t: float, plant: Plant) -> None:
        """Send the messages of tick `k`, at time `t`; return when the autopilot can read all of them."""
        for publisher in self._publishers.values():
            publisher.update(k, plant)
        if self._drives is not None:
            self._drives.live(t)
        if due(k, self._hub_rate, self._base_hz):
            self._hub.publish_status(plant.fins, plant.servos if self._hub.by_servo else ())
        if due(k, self._esc_rate, self._base_hz):
            self._esc.publish_status(plant.n)
        if due(k, self._hardpoint_rate, self._base_hz):
            self._hardpoint.publish_status(plant.drop_weight)
        if due(k, 1, self._base_hz):
            for node in self._saying:
                node.publish_status(t)
        for device in self._on_lines.values():
            device.update(k, t, plant)
        for payload in self._payload:
            payload.update(k, t, plant)
        self.bus.tick(1.0 / self._base_hz)

    def add_payload(self, device: PayloadDevice) -> None:
        """Add a sensor of one's own.

        Raises:
            ParamError: another device has its node id.
        """
        node_id = device.node.node_id
        if node_id in self._by_id or node_id == self._autopilot_id:
            raise ParamError(f"sensors.toml: payload: node = {node_id}: another device has this id; choose a free one")
        self._by_id[node_id] = device.node
        self._payload.append(device)

    def switch_off(self, device: str) -> Callable[[], None]:
        """Switch a function of a node, or what is on a line, off; what it has measured and not yet sent is lost."""
        if device == "leak":  # the hygrometer is a part of the battery
            hygrometer = self._publishers["leak"]
            hygrometer.muted = True
            return lambda: setattr(hygrometer, "muted", False)
        if (on_line := self._on_lines.get(device)) is not None:
            on_line.switch_off()
            return on_line.switch_on
        self.nodes[device].switch_off()
        return self.nodes[device].switch_on

    def silence_fin(self, fin: int) -> Callable[[], None]:
        """Leave one fin out of the servo hub's reports."""
        self._hub.silent_fins.add(fin)
        return lambda: self._hub.silent_fins.discard(fin)

    def report_servo(self, fin: int) -> Callable[[], None]:
        """Report the angle of a fin's servo, not of the fin."""
        self._hub.by_servo.add(fin)
        return lambda: self._hub.by_servo.discard(fin)

    def add_duplicate(self, sensor: str, corruption: Corruption) -> Callable[[], None]:
        """Add a second node with the id of a sensor's: it sends what the sensor measures, corrupted."""
        publisher = self._publishers[sensor]
        entry = (DeviceNode(publisher.node.node_id, "duplicate", self.bus), corruption)
        publisher.duplicates.append(entry)
        return lambda: publisher.duplicates.remove(entry)

    def add_duplicate_autopilot(self) -> Callable[[], None]:
        """Add a node with the autopilot's id, which sends NodeStatus."""
        node = DeviceNode(self._autopilot_id, "duplicate", self.bus)
        self._saying.append(node)
        return lambda: self._saying.remove(node)

    def _accept_command(self, command: Transfer, t: float) -> None:
        try:
            if command.kind is m.ARRAY_COMMAND and isinstance(self._hub, FinServos):
                self._hub.accept_command(m.ARRAY_COMMAND.decode(command.payload), t)
            elif command.kind is m.RPM_COMMAND:
                self._esc.accept_command(m.RPM_COMMAND.decode(command.payload), t)
            elif command.kind is m.RAW_COMMAND:
                self._esc.accept_command(m.RAW_COMMAND.decode(command.payload), t)
            elif command.kind is m.HARDPOINT_COMMAND:
                self._hardpoint.accept_command(m.HARDPOINT_COMMAND.decode(command.payload), t)
            else:
                self._hardpoint.accept_arming(m.ARMING_STATUS.decode(command.payload))
        except DecodeError:
            self.malformed += 1
