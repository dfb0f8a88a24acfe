"""A short straight flight with an io file of the fins' own, which tests of servos and drives judge."""

from __future__ import annotations

from pathlib import Path

from sternplane.logs.reading import Log, read
from sternplane.sitl.flight import FlightRequest, fly, prepare

from tests.straight_run import hold, under_way


def flown_with(folder: Path, io: Path, duration: float, *faults: str) -> Log:
    """The log of a change of depth with these devices, which `folder`, a new one, keeps; duration in s."""
    folder.mkdir()
    scenario = folder / "dive.toml"
    scenario.write_text(under_way(duration, 10.0, hold(14.0, 60.0)))
    fly(prepare(FlightRequest(str(scenario), io=io, faults=faults), {}), folder / "log.mcap")
    return read(folder / "log.mcap")
