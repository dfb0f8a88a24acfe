"""A short straight flight with an io file of the fins' own, which tests of servos and drives judge."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from sternplane.logs.reading import Log, read
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.records.cycle import Cycle
from tests.straight_run import hold, under_way


def flown_with(folder: Path, io: Path, duration: float, *faults: str) -> Log:
    """The log of a change of depth with these devices, which `folder`, a new one, keeps; duration in s."""
    folder.mkdir()
    scenario = folder / "dive.toml"
    scenario.write_text(under_way(duration, 10.0, hold(14.0, 60.0)))
    fly(prepare(FlightRequest(str(scenario), io=io, faults=faults), {}), folder / "log.mcap")
    return read(folder / "log.mcap")


def lags(cycles: Sequence[Cycle]) -> list[float]:
    """How far each fin still is, after 0.15 s, from where it was told to go, rad; where it was hardly told anew."""
    return [
        abs(heard.value - told)
        for before, now in zip(cycles[200:], cycles[215:], strict=False)
        for heard, told, newly in zip(now.frame.fins, before.applied.fins, now.applied.fins, strict=True)
        if abs(told - newly) < 0.005
    ]
