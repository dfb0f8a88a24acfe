"""Whole flights with a receiver that tells of a place where the vehicle is not, judged by the plant."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from sternplane.logs.reading import Log, read
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.records.health import SourceFault
from firmware_py.records.order import Mode
from tests.straight_run import at_rest, hold, mission

STANDS_STILL = ("freeze:fix@2", "noise:fix.north=1@2.1", "noise:fix.east=1@2.1")
"""It tells of one place for ever, with noise on it."""


def from_the_surface(
    folder: Path, duration: float, orders: str, *faults: str, current: float = 0.0, seed: int = 1000
) -> Log:
    """Fly from rest at the surface, in a current to the north, m/s."""
    place = folder / "course.toml"
    place.write_text(at_rest(duration, orders, current=(current, 0.0)))
    fly(prepare(FlightRequest(scenario=str(place), faults=faults, seed=seed), {}), folder / "log.mcap")
    return read(folder / "log.mcap")


def off(log: Log) -> np.ndarray:
    """Return by how many sigmas the position is off."""
    north, east = (log.columns[f"state.eta.{axis}"] - log.truth[f"eta.{axis}"] for axis in "xy")
    return np.hypot(north, east) / log.columns["state.position_std"]


def test_a_receiver_that_was_heard_under_water_tells_nobody_of_the_surface_once_the_pressure_is_lost(
    tmp_path: Path,
) -> None:
    """It was believed again at once: the position leapt back by as much as had been dived, and it came up slowly."""
    log = from_the_surface(tmp_path, 130.0, hold(8.0), *STANDS_STILL, "off:pressure@70")
    t, z, depth_lost = log.columns["t"], log.truth["eta.z"], 71.0
    fault = np.array([cycle.state.sensors.fix.fault for cycle in log.cycles])
    assert (fault[(t > depth_lost) & (z > 1.5)] != SourceFault.NONE).all()
    assert off(log)[t > 45.0].max() < 3.0
    disarmed = (log.columns["mode.mode"] == Mode.DISARMED) & (t > depth_lost)
    assert disarmed.any()
    assert z[disarmed].max() < 1.0


def faults_of(log: Log, sensor: str) -> set[SourceFault]:
    return {getattr(cycle.state.sensors, sensor).fault for cycle in log.cycles}


def test_a_receiver_that_stands_still_is_left_out_and_the_mission_flown(tmp_path: Path) -> None:
    """It was believed: the position stood still with it, and the vehicle drove on along the surface, 100 m and more."""
    log = from_the_surface(tmp_path, 80.0, mission([(45.0, 6.0), (400.0, 8.0)]), *STANDS_STILL)
    t = log.columns["t"]
    fault = np.array([cycle.state.sensors.fix.fault for cycle in log.cycles])
    assert t[fault == SourceFault.CONTRADICTED][0] < 45.0
    assert faults_of(log, "dvl") == {SourceFault.NONE}
    assert log.truth["eta.z"][t > 60.0].min() > 4.0
    assert off(log)[t > 45.0].max() < 3.0


def test_a_receiver_that_walks_off_against_the_current_convicts_no_sound_dvl(tmp_path: Path) -> None:
    text = hold(0.0).replace("speed_m_s = 1.8", "speed_m_s = 1.5")
    log = from_the_surface(tmp_path, 95.0, text, "drift:fix.north=0.6@50", current=-0.6)
    t = log.columns["t"]
    assert faults_of(log, "dvl") == {SourceFault.NONE}
    assert SourceFault.CONTRADICTED in faults_of(log, "fix")
    assert abs(log.columns["state.eta.x"] - log.truth["eta.x"])[-1] < 6.0
    assert off(log)[t > 5.0].max() < 5.0
    assert off(log)[t > 75.0].max() < 3.0


def test_a_receiver_that_lies_keeps_no_blocked_pressure_from_being_named(tmp_path: Path) -> None:
    """Each of its fixes said that the vehicle floats: it dived to 16 m, disarmed itself, and said it had surfaced."""
    blocked = ("freeze:fix@8", "set:pressure=0@8", "noise:pressure=0.02@8.2")
    log = from_the_surface(tmp_path, 75.0, mission([(45.0, 6.0), (175.0, 28.0)]), *blocked)
    assert faults_of(log, "pressure") - {SourceFault.NONE}
    assert log.truth["eta.z"].max() < 4.0
    assert log.truth["eta.z"][-1] < 1.0
