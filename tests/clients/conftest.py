"""What the vehicles of these tests find on their disk."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.command import called

SCENARIO = """
description = "A short flight, of which there is a log."
duration_s = 3.0
completes = "time"
[autopilot.estimation.learning]
enabled = false
"""
FLOWN = 1_700_000_000
"""When, s since 1970."""


@pytest.fixture(scope="session")
def earlier(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The log of a short flight."""
    folder = tmp_path_factory.mktemp("earlier")
    (folder / "short.toml").write_text(SCENARIO)
    flown = called("sitl", "--scenario", "short.toml", "--out", "run", cwd=folder)
    assert flown.returncode == 1, flown.stderr  # nobody armed it
    return (folder / "run" / "log.mcap").read_bytes()


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory, earlier: bytes) -> Path:
    """A folder in which a vehicle has flown before."""
    place = tmp_path_factory.mktemp("vehicle")
    log = place / "runs" / "earlier" / "log.mcap"
    log.parent.mkdir(parents=True)
    log.write_bytes(earlier)
    os.utime(log, (FLOWN, FLOWN))
    return place
