"""The vehicle's real hardware on a real bus and a real pseudo-terminal, with pydronecan as everyone else on the bus."""

from __future__ import annotations

import itertools

import can
from dronecan.transport import Transfer

from firmware_py.adapters.buses.can_bus import open_bus
from firmware_py.adapters.drivers.dronecan.own_node import KeptNodeIds
from firmware_py.adapters.drivers.serial_port import SerialPort
from firmware_py.adapters.fitting import fitted
from firmware_py.adapters.io_params import IoParams
from firmware_py.params import load
from firmware_py.records.command import Applied
from firmware_py.records.sensing import SensorFrame
from firmware_py.tick import Tick
from firmware_py.vehicle.fins import Fin
from sim_bridge.devices.serial_line import SerialLine

from .conftest import Peer

OWN = 10
NODES = {
    "servo_hub": 21,
    "esc": 22,
    "ahrs": 23,
    "pressure": 24,
    "altimeter": 25,
    "fix": 26,
    "battery": 27,
    "hardpoint": 28,
}
LATENCY = {"ahrs": 0.02, "pressure": 0.03, "altimeter": 0.04, "fix": 0.5, "servo_hub": 0.06, "esc": 0.07}
FINS = 4
FIN_LIST = [Fin(name, hinge=0.0) for name in ("stern_port", "stern_starboard", "rudder_upper", "rudder_lower")]
DT_NS = 10_000_000
DISARMED = Applied((0.0,) * FINS, 0.0, armed=False, limited=False)
_channels = itertools.count()


class Vehicle:
    """The hardware of four fins, ticked by hand; to be used in a `with` block."""

    def __init__(self, rate: str = "hz_50", kept: KeptNodeIds | None = None, **tables: object) -> None:
        channel = f"vehicle-{next(_channels)}"
        self.line = SerialLine()
        io = {
            "can": {"node_id": OWN},
            "nodes": NODES,
            "instruments": [{"driver": "waterlink", "port": self.line.path}],
            "commands": {"rate": rate},
            "latency": {f"{name}_s": late for name, late in LATENCY.items()},
        }
        params = load(IoParams, io | tables, "a test")
        self.bus = open_bus("virtual", channel, standard=params.canopen.shares_bus)
        lines = [SerialPort("dvl", self.line.path, 115200) for _ in params.lines]
        self.hardware = fitted(params, FIN_LIST, self.bus, lines, node_ids=kept)
        self.others = can.Bus(interface="virtual", channel=channel)
        self._peers: dict[int, Peer] = {}

    def node(self, role_or_id: str | int) -> Peer:
        """The foreign node that holds a role or an id."""
        node_id = NODES[role_or_id] if isinstance(role_or_id, str) else role_or_id
        return self._peers.setdefault(node_id, Peer(self.others, node_id))

    def read(self, k: int) -> SensorFrame:
        return self.hardware.read(Tick(k, DT_NS))

    def write(self, k: int, applied: Applied = DISARMED) -> None:
        self.hardware.write(Tick(k, DT_NS), applied)

    def said(self) -> list[Transfer]:
        """Every transfer that the vehicle has sent since the last time."""
        return self.node(OWN + 1).listen()

    def __enter__(self) -> Vehicle:
        return self

    def __exit__(self, *_: object) -> None:
        self.hardware.close()
        self.others.shutdown()
        self.line.close()


def frames(
    payload, source: int, transfer_id: int = 0, cut: int | None = None, put: tuple[int, bytes] = (0, b"")
) -> list[tuple[int, bytes]]:
    """The frames of a broadcast as pydronecan cuts them.

    The payload may be cut to its first `cut` bytes, or have bytes `put` at an offset; the CRC fits it all the same.
    """
    transfer = Transfer(transfer_id=transfer_id, source_node_id=source, payload=payload, transfer_priority=16)
    content = bytearray(transfer.payload[:cut])
    content[put[0] : put[0] + len(put[1])] = put[1]
    transfer.payload = bytes(content)
    return [(frame.message_id, bytes(frame.bytes)) for frame in transfer.to_frames()]
