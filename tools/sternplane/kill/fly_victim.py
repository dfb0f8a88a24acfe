"""`fly` is killed under way; the plant goes on, and the next `fly` takes over the same vehicle."""

from __future__ import annotations

import random
import time
from pathlib import Path
from typing import Any

from sternplane.kill.judgement import Off, distance, last_time, left_down, no_start, read_log, worst_of, wrong
from sternplane.kill.processes import PLANT, VEHICLE, OnBus, Station, ended
from sternplane.logs.reading import read
from sternplane.logs.truth_beside import TRUTH_FILE

_CHECKED_S = 1.0
"""The estimate of the next flight is held against the truth for its first second."""
_DECIDED_S, _COMES_UP_S = 7.0, 240.0
"""When the next flight has decided whether it has to come up; how long that may take, of wall time."""
_ARMS_S = 60.0
"""How long the first one may take to be armed, of wall time: on a busy machine many cycles are late."""


def trial(
    folder: Path, bus: str, rng: random.Random, longest: float = 30.0, depth: float | None = None
) -> dict[str, Any]:
    """Kill one flight, start another; return the figures, and in "wrong" what is not as it should be.

    It is killed at a random time, at most `longest` (s) after it is armed. It began at `depth` (m), or at random either
    at the surface or under water. From under water the next flight has to bring it up, without any order.
    """
    seconds, pause = rng.uniform(0.5, longest), rng.uniform(0.0, 5.0)
    seed, begun = rng.randrange(1000, 2000), rng.choice((0.0, 6.0)) if depth is None else depth
    met = OnBus(folder, bus, seed, begun)
    clock, station, other = met.clock, Station(commands=True), Station(commands=False)
    with ended(met.processes, station, other, clock):
        for thread in (clock, station, other):
            thread.start()
        met.plant("plant")
        plant_zero = clock.zero(PLANT)
        first = met.fly("1", station)
        station.until_heard()
        end = time.monotonic() + _ARMS_S
        while not station.armed and time.monotonic() < end:
            time.sleep(0.05)
        time.sleep(seconds)
        killed, armed = first.kill(), station.armed
        time.sleep(0.2)  # until what it sent last is heard
        commanded = clock.commanded(VEHICLE)
        clock.forget(VEHICLE)
        time.sleep(pause)
        second = met.fly("2", other)
        try:
            other.until_heard(_DECIDED_S)
            next_zero = clock.zero(VEHICLE)
        except TimeoutError:
            return no_start(second)
        end = time.monotonic() + _COMES_UP_S
        while other.armed and time.monotonic() < end:
            time.sleep(0.1)
    log, after, truth = read_log(folder / "1"), read_log(folder / "2"), read(folder / "plant" / TRUTH_FILE)
    t, columns = last_time(log), after.columns
    lost, found = max(commanded - t, 0.0), []
    for k in range(min(len(columns["t"]), round(_CHECKED_S * 100))):
        x, y = float(columns["state.eta.x"][k]), float(columns["state.eta.y"][k])
        off = distance(truth.truth, next_zero + columns["t"][k] - plant_zero, x, y)
        sigma = float(columns["state.position_std"][k])
        found.append(Off(off / sigma, off, sigma))
    worst = worst_of(found)
    since = truth.truth["t"] - (next_zero - plant_zero)
    under = (since >= 0.0) & (since <= columns["t"][-1])
    depths, moved = truth.truth["eta.z"][under], bool(columns["applied.armed"].any())
    return {
        "begun_m": begun,
        "armed": armed,
        "killed_at_s": round(t, 2),
        "gap_s": round(next_zero - killed, 1),
        "speed_m_s": round(float(log.columns["state.nu.u"][-1]), 2),
        "log_lost_s": round(lost, 2),
        "error_m": round(worst.error, 2),
        "sigma_m": round(worst.sigma, 2),
        "sigmas": round(worst.sigmas, 3),
        "depth_m": round(float(depths[0]), 1),
        "came_up": moved,
        "depth_at_end_m": round(float(depths[-1]), 1),
        "wrong": wrong(log, after, lost=lost, sigmas=worst.sigmas) + left_down(armed, since[under], depths, moved),
    }
