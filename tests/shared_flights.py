"""Flights in one process, each flown once in a run of the tests, whichever worker asks for it first."""

from __future__ import annotations

import fcntl
import hashlib
import json
from functools import lru_cache
from pathlib import Path

from sternplane.logs.reading import Log, read
from sternplane.sitl.flight import SCENARIOS, FlightRequest, Outcome, fly, prepare
from sternplane.study.adaptation.courses import without_factors

from firmware_py.adapters.installation import configs

KNOWN_DEMONSTRATION = without_factors((SCENARIOS / "demo.toml").read_text())
LEARNING_OFF = "\n[autopilot.estimation.learning]\nenabled = false\n"
"""At the end of a scenario. What does not use what is learned stays as it is (test_learning.py), at half the time."""

BRIEF = """
description = "A second at the surface."
duration_s = 1.0
completes = "time"
[[orders]]
t_s = 0.2
arming = "arm"
"""


class Flights:
    """The flights of a run of the tests, as logs in a folder that its workers share."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        folder.mkdir(exist_ok=True)
        self._read = lru_cache(maxsize=4)(self._flown)

    def __call__(self, scenario: str, seed: int = 1, vehicle: str = "npsauv2") -> tuple[Outcome, Log]:
        """Return outcome and log of a scenario, given by the name under which it is shipped or by its text."""
        return self._read(scenario, seed, vehicle)

    def _flown(self, scenario: str, seed: int, vehicle: str) -> tuple[Outcome, Log]:
        name = hashlib.sha256(f"{seed} {vehicle} {scenario}".encode()).hexdigest()[:16]
        place, log = self._folder / f"{name}.toml", self._folder / f"{name}.mcap"
        outcome = log.with_suffix(".json")
        with log.with_suffix(".lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)  # until it is closed, by whatever end of this process
            if not outcome.exists():
                if "\n" in scenario:
                    place.write_text(scenario)
                named = str(place) if "\n" in scenario else scenario
                wish = FlightRequest(scenario=named, config=configs() / vehicle, seed=seed)
                outcome.write_text(json.dumps(fly(prepare(wish, {}), log)))
        return Outcome(*json.loads(outcome.read_text())), read(log)


def demonstration(waypoints: int = 5) -> str:
    """Return the text of the demonstration, which ends after so many of its waypoints, with learning off.

    Its vehicle file is right, as nothing would mend it.
    """
    before, *places = KNOWN_DEMONSTRATION.split("[[waypoints]]")
    return "[[waypoints]]".join((before, *places[:waypoints])) + LEARNING_OFF


def without_learning(name: str) -> str:
    """Return the text of a shipped scenario, with learning off."""
    return without_factors((SCENARIOS / f"{name}.toml").read_text()) + LEARNING_OFF
