"""A station inside a flight: it says what stands in a script, at its times, and takes down what it is answered."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import all as mavlink
from sternplane.logs.reading import Log, read
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.adapters.ground.mavlink_ground import Grounds
from firmware_py.marine import Origin
from firmware_py.mavlink.base.identity import Identity
from firmware_py.mavlink.base.link_configuration import LinkConfiguration
from firmware_py.mavlink.node import Node, VehicleDescription
from firmware_py.mavlink.settings import MavlinkParams, NodeSettings
from firmware_py.mavlink.telemetry.health import Actuators
from firmware_py.records.cycle import Cycle
from firmware_py.records.limits import OperatingLimits
from firmware_py.records.order import Order
from firmware_py.records.turning import AS_ASKED
from firmware_py.tick import Tick

ORIGIN = Origin(math.radians(36.8), math.radians(-121.8))


class Station:
    """Says what stands in a script, message by message; who needs more overrides `says` and `hears`."""

    def __init__(self, script: dict[float, Any], identity: Identity) -> None:
        vehicle = VehicleDescription(ORIGIN, Actuators((0.4,) * 4, 10.0))
        settings = NodeSettings(MavlinkParams(), OperatingLimits(math.inf, 0.0, AS_ASKED))
        self.node = Node(settings, vehicle, [LinkConfiguration(identity)])
        self.script = script
        self.mav = mavlink.MAVLink(None, 255, 190)
        self.results: list[tuple[int, int]] = []
        """Of commands: their numbers, and what became of them."""

    def read(self, tick: Tick) -> Order:
        self.node.receive(tick, [[message.pack(self.mav) for message in self.says(tick)]])
        return self.node.order()

    def write(self, cycle: Cycle) -> None:
        for message in mavlink.MAVLink(None).parse_buffer(self.node.report(cycle)[0]) or []:
            if message.get_type() == "COMMAND_ACK":
                self.results.append((message.command, message.result))
            else:
                self.hears(cycle, message)

    def says(self, tick: Tick) -> list[Any]:
        return [self.script[tick.t]] if tick.t in self.script else []

    def hears(self, cycle: Cycle, message: Any) -> None:
        """Take a message that answers no command."""


def command(number: int, *params: float) -> Any:
    return mavlink.MAVLink_command_long_message(1, 1, number, 0, *params, *(0.0,) * (7 - len(params)))


def flown_by(station: Station, scenario: str, folder: Path) -> Log:
    """Fly the text of a scenario while a station speaks."""
    place = folder / "scenario.toml"
    place.write_text(scenario)
    flight = prepare(FlightRequest(scenario=str(place)), {})
    fly(flight, folder / "log.mcap", command=lambda pilot: Grounds(pilot, station))
    return read(folder / "log.mcap")
