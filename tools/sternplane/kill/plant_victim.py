"""`plant` is killed; the next one is heard by the same `fly`, its DVL too."""

from __future__ import annotations

import random
import time
from pathlib import Path
from typing import Any

from sternplane.kill.processes import (
    LOST_MAX,
    PLANT,
    Clock,
    Process,
    Station,
    configuration,
    ended,
    read_log,
    replays,
    scenario,
)
from sternplane.logs.reading import TRUTH_FILE, read

_HEARS_S = 5.0
"""The next plant must be heard within this time, with all its sensors."""


def trial(folder: Path, bus: str, rng: random.Random, longest: float = 10.0) -> dict[str, Any]:
    """Kill one plant, start another; return the figures, and in "wrong" what is not as it should be.

    It is killed at a random time, at most `longest` (s) after the vehicle is heard. The next plant begins
    anew where its scenario says, as if the vehicle had been carried; so position is not judged.
    """
    written, config = scenario(folder), configuration(folder)
    seconds, wrong = rng.uniform(0.5, longest), []
    on_bus = ("--bus", bus, "--dvl", folder / "dvl")
    plant = ("plant", *on_bus, "--scenario", written, "--pace", "realtime", "--seed", str(rng.randrange(1000, 2000)))
    clock, station = Clock(bus), Station(commands=True)
    processes: list[Process] = []
    with ended(processes, station, clock):
        clock.start()
        station.start()
        first = Process(folder / "plant-1", *plant, "--out", folder / "plant-1")
        processes.append(first)
        zero = clock.zero(PLANT)
        fly = ("fly", *on_bus, "--config", config, "--state", config / "state", "--out", folder / "fly")
        vehicle = Process(folder / "fly", *fly, "--gcs", station.address)
        processes.append(vehicle)
        station.until_heard()
        time.sleep(seconds)
        killed = first.kill()
        clock.forget(PLANT)
        second = Process(folder / "plant-2", *plant, "--out", folder / "plant-2")
        processes.append(second)
        try:
            clock.zero(PLANT)
        except TimeoutError:
            return {"wrong": ["the next start does not work"], "said": second.said}
        begun = station.t
        time.sleep(_HEARS_S)
        if not vehicle.runs:
            wrong.append("the vehicle has ended")
    log, truth = read_log(folder / "fly"), read(folder / "plant-1" / TRUTH_FILE)
    columns = log.columns
    lost = killed - zero - truth.topics["/truth"].times[-1] * 1e-9
    if lost > LOST_MAX:
        wrong.append("more of the truth is lost")
    known = {name: columns[f"state.{name}_ok"] for name in ("attitude", "depth", "velocity")}
    heard = {}
    for name, ok in known.items():
        again = columns["t"][(columns["t"] > begun) & ok]
        heard[name] = round(float(again[0]) - begun, 2) if again.size else None
        if not again.size:
            wrong.append(f"{name} is not heard again")
    if said := replays(log):
        wrong.append(said)
    return {
        "killed_at_s": round(killed - zero, 2),
        "log_lost_s": round(lost, 2),
        "heard_after_s": heard,
        "wrong": wrong,
    }
