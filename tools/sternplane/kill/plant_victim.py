"""`plant` is killed; the next one is heard by the same `fly`, its DVL too."""

from __future__ import annotations

import random
import time
from pathlib import Path
from typing import Any

from sternplane.kill.judgement import no_start, read_log, wrong
from sternplane.kill.processes import PLANT, OnBus, Station, ended
from sternplane.logs.reading import read
from sternplane.logs.truth_beside import TRUTH_FILE

_HEARS_S = 5.0
"""The next plant must be heard within this time, with all its sensors."""


def trial(folder: Path, bus: str, rng: random.Random, longest: float = 10.0) -> dict[str, Any]:
    """Kill one plant, start another; return the figures, and in "wrong" what is not as it should be.

    It is killed at a random time, at most `longest` (s) after the vehicle is heard. The next plant begins
    anew where its scenario says, as if the vehicle had been carried; so position is not judged.
    """
    seconds, found = rng.uniform(0.5, longest), []
    met = OnBus(folder, bus, rng.randrange(1000, 2000))
    clock, station = met.clock, Station(commands=True)
    with ended(met.processes, station, clock):
        clock.start()
        station.start()
        first = met.plant("plant-1")
        zero = clock.zero(PLANT)
        vehicle = met.fly("fly", station)
        station.until_heard()
        time.sleep(seconds)
        killed = first.kill()
        clock.forget(PLANT)
        second = met.plant("plant-2")
        try:
            clock.zero(PLANT)
        except TimeoutError:
            return no_start(second)
        begun = station.t
        time.sleep(_HEARS_S)
        if not vehicle.runs:
            found.append("the vehicle has ended")
    log, truth = read_log(folder / "fly"), read(folder / "plant-1" / TRUTH_FILE)
    columns = log.columns
    lost = killed - zero - truth.topics["/truth"].times[-1] * 1e-9
    known = {name: columns[f"state.{name}_ok"] for name in ("attitude", "depth", "velocity")}
    heard = {}
    for name, ok in known.items():
        again = columns["t"][(columns["t"] > begun) & ok]
        heard[name] = round(float(again[0]) - begun, 2) if again.size else None
        if not again.size:
            found.append(f"{name} is not heard again")
    return {
        "killed_at_s": round(killed - zero, 2),
        "log_lost_s": round(lost, 2),
        "heard_after_s": heard,
        "wrong": found + wrong(log, lost=lost),
    }
