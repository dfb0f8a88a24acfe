"""A station that fetches logs and parameters in flight changes not one byte of any cycle."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import all as mavlink
from sternplane.logs.reading import Log, read
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py import app, config_files
from firmware_py.adapters.ground.mavlink_ground import Grounds
from firmware_py.adapters.storage.disk_log_storage import DiskLogStorage
from firmware_py.marine import Origin
from firmware_py.mavlink.base.identity import Identity
from firmware_py.mavlink.base.link_configuration import LinkConfiguration
from firmware_py.mavlink.node import Node, SharedState, VehicleDescription
from firmware_py.mavlink.telemetry.health import Actuators
from firmware_py.reconfiguration import node_settings
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import Order
from firmware_py.tick import Tick
from tests.dive import DIVE

LIST, OPEN, BURST, CRC = 3, 4, 15, 14


class Station:
    """Asks for something every tenth of a second, and counts what comes."""

    def __init__(self, configuration: Any, folder: Path) -> None:
        settings = node_settings(config_files.autopilot_params(configuration))
        vehicle = VehicleDescription(Origin(0.8, 0.1), Actuators((0.4,) * 4, 10.0))
        links = [LinkConfiguration(Identity.ARDUSUB)] * 2
        self.node = Node(settings, vehicle, links, SharedState(parameters=app.parameter_store(configuration)))
        self.store = DiskLogStorage(folder, beside=False)
        self.node.offer_logs(self.store)
        self.mav = mavlink.MAVLink(None, 255, 190)
        self.bytes = [0, 0]

    def read(self, tick: Tick) -> Order:
        if tick.k % 10 == 0:
            self.node.receive(tick, [[self.files(tick.k // 10)], [self.logs(tick.k // 10)]])
        return self.node.order()

    def files(self, i: int) -> bytes:
        steps = [(LIST, b"logs"), (OPEN, f"logs/{self.store_name}".encode()), (BURST, b""), (CRC, b"@PARAM/param.pck")]
        op, data = steps[i % 4]
        payload = struct.pack("<HBBBBBxI", i, 0, op, len(data), 0, 0, 0) + data
        return mavlink.MAVLink_file_transfer_protocol_message(0, 1, 1, payload.ljust(251, b"\0")).pack(self.mav)

    def logs(self, i: int) -> bytes:
        if i % 40 == 0:
            return mavlink.MAVLink_log_request_data_message(1, 1, 1, 0, 2**32 - 1).pack(self.mav)
        return mavlink.MAVLink_timesync_message(0, i).pack(self.mav)

    store_name = ""

    def write(self, cycle: Cycle) -> None:
        for i, datagram in enumerate(self.node.report(cycle)):
            assert len(datagram) <= 1472
            for message in mavlink.MAVLink(None).parse_buffer(datagram) or []:
                if message.get_type() == "LOG_DATA":
                    self.bytes[i] += message.count
                elif message.get_type() == "FILE_TRANSFER_PROTOCOL" and message.payload[5] == BURST:
                    self.bytes[i] += message.payload[4]


def flown(folder: Path, downloads: bool) -> tuple[Log, list[int]]:
    folder.mkdir()
    scenario = folder / "scenario.toml"
    scenario.write_text(DIVE)
    flight = prepare(FlightRequest(scenario=str(scenario)), {})
    stations = [Station(flight.configuration, folder)] if downloads else []
    for station in stations:
        station.store_name = f"{folder.name}.mcap"
    try:
        outcome = fly(flight, folder / "log.mcap", command=lambda pilot: Grounds(pilot, *stations))
    finally:
        for station in stations:
            station.store.close()
    assert outcome.completed, outcome
    return read(folder / "log.mcap"), stations[0].bytes if stations else []


def test_downloads_in_flight_leave_every_cycle_as_it_is(tmp_path: Path) -> None:
    quiet, _ = flown(tmp_path / "quiet", downloads=False)
    busy, counts = flown(tmp_path / "busy", downloads=True)
    assert min(counts) > 10_000, counts
    assert busy.cycle_bytes == quiet.cycle_bytes
