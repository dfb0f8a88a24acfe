"""A flight is over before garbage is collected again: whatever waits for that is memory that grows in flight."""

from __future__ import annotations

import gc
from pathlib import Path

import pytest

from tests.command import called
from tests.shared_flights import LEARNING_OFF

OBJECTS_AT_START = 50
"""The codecs of the log leave ten; a thing that is left twice a second makes it 24 more at least."""


def test_a_flight_that_saves_its_navigation_leaves_nothing_for_the_collector(
    dive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    left, unfreeze = list[int](), gc.unfreeze

    def count() -> None:
        left.append(gc.collect())
        unfreeze()

    monkeypatch.setattr(gc, "unfreeze", count)  # the end of the flight's own time; the collector is still off
    dive.write_text(dive.read_text() + LEARNING_OFF)
    often = "io.state.interval_s=0.5"
    flight = called("sitl", "--scenario", dive, "--set", often, "--out", "run", "--no-report", cwd=tmp_path)
    assert flight.returncode == 0, flight.stderr
    assert (tmp_path / "run" / "state" / "navigation.json").exists()
    (objects,) = left
    assert objects < OBJECTS_AT_START
