"""A dive with one foreign node that steers, drives, tells the depth and the position, between autopilot and plant."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sternplane.logs.reading import read
from sternplane.logs.replay import replay
from sternplane.logs.summary import summarise
from sternplane.sitl import flight as sitl_flight
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.adapters.buses.can_bus import CanBus, open_bus
from firmware_py.adapters.installation import configs
from firmware_py.app import build as build_autopilot
from sim_bridge import build
from sim_bridge.bridge import Bridge
from sim_bridge.devices.devices import Devices
from sim_bridge.plant.plant import Plant
from tests.flights.test_foreign_actuators import Without
from tests.foreign_actuators import ForeignBus
from tests.foreign_periph import ApPeriph
from tests.straight_run import hold, surface, under_way

IO = configs() / "npsauv2" / "io_periph.toml"
NODE, FULL_RPM, DEPTH = 21, 1000.0, 6.0


class OnePeriph:
    """A `bridge.DevicePort`: our simulated devices, but for what the foreign node is."""

    def __init__(self, devices: Devices, periph: ApPeriph, bus: CanBus, base_hz: int) -> None:
        self._devices, self.periph, self._hz = devices, periph, base_hz
        self._bus = ForeignBus(bus, periph)

    @property
    def released(self) -> bool:
        return self._devices.released

    def initialise(self, plant: Plant) -> None:
        self._devices.initialise(plant)

    def receive(self, t: float) -> None:
        self._devices.receive(t)
        self._bus.hear()

    def commands(self, _t: float, fins: Sequence[float]) -> tuple[Sequence[float], float]:
        angles = self.periph.angles
        return [fin if angle is None else angle for angle, fin in zip(angles, fins, strict=True)], self.periph.n

    def publish(self, k: int, t: float, plant: Plant) -> None:
        self._devices.publish(k, t, plant)
        self.periph.live(k, self._hz, plant)


@pytest.fixture
def foreign(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[OnePeriph]]:
    """Put the foreign node between bus and plant of the flights that follow; returns it for each."""
    made: list[OnePeriph] = []
    with contextlib.ExitStack() as stack:

        def with_foreign(*arguments: Any) -> Bridge:
            *before, scenario, bus, lines, seed, hz, own_id, second = arguments
            theirs = open_bus(bus.name)
            stack.callback(theirs.close)

            def fitted(plant: Plant, devices: Devices, faults: Any) -> Bridge:
                periph = ApPeriph(NODE, theirs, FULL_RPM, scenario.environment.origin)
                made.append(OnePeriph(devices, periph, theirs, hz))
                return Bridge(plant, made[-1], faults)

            monkeypatch.setattr(build, "Bridge", fitted)
            return build.build_bridge(*before, scenario, Without(bus, (NODE,)), lines, seed, hz, own_id, second)

        monkeypatch.setattr(sitl_flight, "build_bridge", with_foreign)
        yield made


def test_a_dive_with_one_foreign_node_for_four_roles_is_flown_and_ends_at_the_surface(
    tmp_path: Path, foreign: list[OnePeriph]
) -> None:
    scenario, path = tmp_path / "dive.toml", tmp_path / "log.mcap"
    scenario.write_text(under_way(80.0, DEPTH, hold(DEPTH), surface(30.0), completes="surfaced"))
    outcome = fly(prepare(FlightRequest(str(scenario), io=IO), {}), path)
    assert outcome.completed, outcome.reason
    assert len(foreign) == 1
    log = read(path)
    c, found = log.columns, summarise(log)
    held = (c["t"] > 8.0) & (c["t"] < 30.0)
    assert np.abs(log.truth["eta.z"][held] - DEPTH).max() < 0.5
    assert c["frame.fins.ok"][held].all()
    assert math.isclose(c["frame.n.value"][held].mean(), 8.0, rel_tol=0.15)
    assert c["frame.fix.ok"][-1]
    assert found["health"]["actuators"] == {}
    assert not any(count for cause, count in found["losses"].items() if not cause.startswith("dvl"))
    assert replay(log, build_autopilot).equal
