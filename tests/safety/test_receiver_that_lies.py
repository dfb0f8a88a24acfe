"""Whole flights with a receiver that tells of a place where the vehicle is not, judged by the plant."""

from __future__ import annotations

from pathlib import Path

from sternplane.logs.reading import Log, read
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.records.health import SourceFault
from firmware_py.records.order import Mode
from tests.straight_run import hold, under_way

STANDS_STILL = ("freeze:fix@2", "noise:fix.north=1@2.1", "noise:fix.east=1@2.1")
"""It tells of one place for ever, with noise on it."""


def from_the_surface(folder: Path, duration: float, orders: str, *faults: str, seed: int = 1000) -> Log:
    text = under_way(duration, 0.0, orders).replace("u_m_s = 1.8", "").replace("n_rpm = 500.0", "")
    place = folder / "course.toml"
    place.write_text(text)
    fly(prepare(FlightRequest(scenario=str(place), faults=faults, seed=seed), {}), folder / "log.mcap")
    return read(folder / "log.mcap")


def test_a_receiver_that_was_heard_under_water_tells_nobody_of_the_surface_once_the_pressure_is_lost(
    tmp_path: Path,
) -> None:
    """It was believed again at once: the position leapt back by as much as had been dived, and it came up slowly."""
    log = from_the_surface(tmp_path, 130.0, hold(8.0), *STANDS_STILL, "off:pressure@70")
    t, z, depth_lost = log.columns["t"], log.truth["eta.z"], 71.0
    fault = [cycle.state.sensors.fix.fault for cycle in log.cycles]
    told = [z_true for z_true, now, at in zip(z, fault, t, strict=True) if at > depth_lost and now is SourceFault.NONE]
    assert max(told) < 1.5
    disarmed = (log.columns["mode.mode"] == Mode.DISARMED) & (t > depth_lost)
    assert disarmed.any()
    assert z[disarmed].max() < 1.0
