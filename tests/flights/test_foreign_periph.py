"""A dive with one foreign node that steers, drives, tells the depth and the position, between autopilot and plant."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from sternplane.logs.reading import read
from sternplane.logs.replay import replay
from sternplane.logs.summary import summarise
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.adapters.buses.can_bus import CanBus
from firmware_py.adapters.installation import configs
from firmware_py.app import build as build_autopilot
from sim_bridge.devices.devices import Devices
from sim_bridge.plant.plant import Plant
from sim_bridge.scenarios import Scenario
from tests.foreign_periph import ApPeriph
from tests.foreign_port import ForeignPort, in_place_of
from tests.straight_run import hold, surface, under_way

IO = configs() / "npsauv2" / "io_periph.toml"
NODE, FULL_RPM, DEPTH = 21, 1000.0, 6.0


class OnePeriph(ForeignPort[ApPeriph]):
    """One node is foreign."""

    def __init__(self, devices: Devices, bus: CanBus, scenario: Scenario, base_hz: int) -> None:
        self._periph = ApPeriph(NODE, bus, FULL_RPM, scenario.environment.origin)
        super().__init__(devices, (self._periph,), bus, base_hz)

    def commands(self, _t: float, fins: Sequence[float]) -> tuple[Sequence[float], float]:
        angles = self._periph.angles
        return [fin if angle is None else angle for angle, fin in zip(angles, fins, strict=True)], self._periph.n

    def publish(self, k: int, t: float, plant: Plant) -> None:
        super().publish(k, t, plant)
        self._periph.live(k, self.base_hz, plant)


def test_a_dive_with_one_foreign_node_for_four_roles_is_flown_and_ends_at_the_surface(tmp_path: Path) -> None:
    scenario, path = tmp_path / "dive.toml", tmp_path / "log.mcap"
    scenario.write_text(under_way(80.0, DEPTH, hold(DEPTH), surface(30.0), completes="surfaced"))
    with in_place_of((NODE,), OnePeriph) as foreign:
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
