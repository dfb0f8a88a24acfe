"""Whole flights with an AHRS that has told one attitude since it was switched on, judged by the plant."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sternplane.logs.reading import read
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.records.health import SourceFault
from firmware_py.records.order import Mode
from tests.straight_run import at_rest, mission


@pytest.mark.parametrize("others", [(), ("pressure",), ("pressure", "dvl", "altimeter", "fix")])
def test_it_is_named_at_the_surface_whatever_is_frozen_beside_it(tmp_path: Path, others: tuple[str, ...]) -> None:
    """Alone it sent the vehicle down with a bow of 37 deg and convicted the pressure; with that frozen too, aground."""
    place = tmp_path / "dive.toml"
    place.write_text(at_rest(40.0, mission([(140.0, 6.0), (600.0, 6.0)]), bottom=14.0))
    faults = [f"freeze:{sensor}@0" for sensor in ("ahrs", *others)]
    fly(prepare(FlightRequest(scenario=str(place), faults=faults, seed=7), {}), tmp_path / "log.mcap")
    log = read(tmp_path / "log.mcap")
    fault = np.array([cycle.state.sensors.ahrs.fault for cycle in log.cycles])
    assert log.columns["t"][fault == SourceFault.FROZEN][0] < 15.0
    assert log.truth["eta.z"].max() < 0.5
    assert Mode.SURFACE in log.columns["mode.mode"]
    assert {cycle.state.sensors.pressure.fault for cycle in log.cycles} <= {SourceFault.NONE, SourceFault.FROZEN}
