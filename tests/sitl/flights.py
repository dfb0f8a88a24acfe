"""Flights in this process, each flown once for all tests that look at it."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from sternplane.logs.reading import Log, read
from sternplane.sitl.flight import SCENARIOS, Outcome, Wish, fly, prepare


@cache
def flown(scenario: str, seed: int = 1) -> tuple[Outcome, Log]:
    """A shipped scenario by its name, or one in a file of the test's own by its path."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "log.mcap"
        return fly(prepare(Wish(scenario=scenario, seed=seed), {}), path), read(path)


def demonstration() -> str:
    """The text of the demonstration without learning, which only looks on, and takes a fifth of the time."""
    return (SCENARIOS / "demo.toml").read_text() + "\n[autopilot.estimation.learning]\nenabled = false\n"
