"""A simulated on a real python-can bus, and pydronecan at the other end of it."""

from __future__ import annotations

import itertools
import tomllib
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace

import can
import dronecan
import pytest
from dronecan.transport import Frame, Transfer

from firmware_py.adapters.buses.can_bus import CanBus, NodeIds, open_bus
from firmware_py.marine import Eta, Nu, Origin
from firmware_py.params import load
from firmware_py.wire.dronecan.fin_servo import FinServoParams, servos_of
from firmware_py.wire.dronecan.propeller_drive import PropellerParams
from sim_bridge.devices.devices import Devices, DevicesParams, Wiring
from sim_bridge.devices.instruments import Instruments, Water
from sim_bridge.devices.line_device import LineDevice
from sim_bridge.devices.lines.table import FIRMWARE
from sim_bridge.devices.serial_line import SerialLine

CONFIGS = Path(__file__).resolve().parents[2] / "configs" / "npsauv2"
BASE_HZ = 100
ORIGIN = Origin(0.64, -2.13)
_channels = itertools.count()


class Peer:
    """A foreign node: pydronecan's types over a bare python-can bus."""

    def __init__(self, bus: can.BusABC, node_id: int = 10) -> None:
        self.bus = bus
        self.node_id = node_id
        self.frames: list[can.Message] = []
        self._transfer_id = itertools.count()

    def send(self, payload, to: int | None = None) -> int:
        transfer_id = next(self._transfer_id) % 32
        transfer = Transfer(
            transfer_id=transfer_id,
            source_node_id=self.node_id,
            dest_node_id=to,
            payload=payload,
            transfer_priority=16,
            service_not_message=to is not None,
            request_not_response=to is not None,
        )
        for frame in transfer.to_frames():
            self.raw(frame.message_id, bytes(frame.bytes))
        return transfer_id

    def raw(self, can_id: int, data: bytes, extended: bool = True) -> None:
        self.bus.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=extended))

    def listen(self) -> list[Transfer]:
        """Every transfer that has come since the last time, in order of its last frame."""
        open_transfers: dict[object, list[Frame]] = {}
        done = []
        while (message := self.bus.recv(0)) is not None:
            assert message.is_extended_id
            assert message.dlc <= 8
            frame = Frame(message.arbitration_id, message.data)
            open_transfers.setdefault(frame.transfer_key, []).append(frame)
            if frame.end_of_transfer:
                transfer = Transfer()
                transfer.from_frames(open_transfers.pop(frame.transfer_key))
                done.append(transfer)
        assert not open_transfers
        return done

    def hear(self, name: str) -> list[tuple[int, object]]:
        """(source, payload) of every message of a type that has come; the rest is thrown away."""
        kind = dronecan.TYPENAMES[name]
        return [
            (t.source_node_id, t.payload) for t in self.listen() if dronecan.get_dronecan_data_type(t.payload) == kind
        ]


BY_RPM = PropellerParams()
FIN_NAMES = ("stern_port", "stern_starboard", "rudder_upper", "rudder_lower")


class SimulatedDevices:
    """Devices around a plant that stands where a test puts it."""

    def __init__(
        self,
        bus: CanBus,
        params: DevicesParams,
        servos: Sequence[FinServoParams] = (),
        propeller: PropellerParams = BY_RPM,
    ) -> None:
        self.params = params
        self.ids = load(NodeIds, tomllib.loads((CONFIGS / "io_sitl.toml").read_text())["nodes"], "io_sitl.toml")
        self.plant = SimpleNamespace(
            eta=Eta(0.0, 0.0, 5.0, 0.0, 0.0, 0.0),
            nu=Nu(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            n=0.0,
            altitude=20.0,
            fins=(0.0, 0.0, 0.0, 0.0),
            drop_weight=1335.0,
        )
        self.line = SerialLine()
        self.bus = bus
        instruments = Instruments(params, Water(1000.0, 101_325.0, ORIGIN), 1, BASE_HZ)
        dvl = LineDevice(instruments.dvl, self.line, FIRMWARE["waterlink"]())
        wiring = Wiring(self.ids, servos_of(servos, FIN_NAMES), propeller)
        self.devices = Devices(params, wiring, instruments, bus, {"dvl": dvl}, BASE_HZ, autopilot_id=10)

    def publish(self, first: int, last: int | None = None) -> None:
        for k in range(first, first + 1 if last is None else last):
            self.devices.publish(k, k / BASE_HZ, self.plant)

    def commanded(self, t: float) -> tuple[list[float], float]:
        """The commands to servos and shaft at `t`, after everything that came until then."""
        self.devices.receive(t)
        return self.later(t)

    def later(self, t: float) -> tuple[list[float], float]:
        fins, n = self.devices.commands(t, self.plant.fins)
        return list(fins), n

    def close(self) -> None:
        self.line.close()
        self.bus.close()


def shipped(**changes: dict[str, object]) -> DevicesParams:
    """The parameters of sensors.toml, with keys of its tables changed."""
    table = tomllib.loads((CONFIGS / "sensors.toml").read_text())
    for name, keys in changes.items():
        table[name] = table[name] | keys
    return load(DevicesParams, table, "sensors.toml")


def quiet(**changes: dict[str, object]) -> DevicesParams:
    """Instruments without errors, and an AHRS without latency."""
    table = tomllib.loads((CONFIGS / "sensors.toml").read_text())
    silence = {
        name: {key: 0.0 for key in keys if "noise" in key or "bias" in key or key == "dropout"}
        for name, keys in table.items()
    }
    silence["ahrs"]["latency_s"] = 0.0
    for name, keys in changes.items():
        silence[name] = silence[name] | keys
    return shipped(**silence)


@pytest.fixture
def launch():
    """launch(servos, propeller, **changes of sensors.toml) -> (simulated, peer), on a bus of their own."""
    opened = []

    def make(servos=(), propeller=BY_RPM, **changes):
        channel = f"contract-{next(_channels)}"
        theirs = can.Bus(interface="virtual", channel=channel)
        simulated = SimulatedDevices(open_bus("virtual", channel), quiet(**changes), servos, propeller)
        opened.extend((simulated.close, theirs.shutdown))
        return simulated, Peer(theirs)

    yield make
    for close in opened:
        close()
