"""`sitl` is killed; the next one resumes what it kept."""

from __future__ import annotations

import random
import time
from pathlib import Path
from typing import Any

from sternplane.kill.judgement import distance, last_time, left_down, no_start, read_log, wrong
from sternplane.kill.processes import CURRENT, Process, Station, ended, scenario

_FLOWN_S = 300.0
"""The next flight has ended by then, in wall time, on the busiest machine."""
_LEFT = """
description = "A vehicle whose program was killed."
duration_s = 90.0
completes = "time"
[start]
depth_m = {depth}
[environment]
bottom_depth_m = 40.0
[autopilot.estimation.learning]
enabled = false
"""
"""Nothing of what is judged is learned, and the vehicle that was killed did not learn either."""


def trial(
    folder: Path, _bus: str, rng: random.Random, longest: float = 8.0, depth: float | None = None
) -> dict[str, Any]:
    """Kill one flight, start another; return the figures, and in "wrong" what is not as it should be.

    It is killed at a random time, at most `longest` (s) after it is heard. It began at `depth` (m), or at random either
    at the surface or under water. The next flight begins anew where its
    scenario says: at the depth at which the vehicle was killed, and without orders; from under water it has to come up.
    The place that it resumes is held against that of the vehicle when it was killed, carried on by the current for the
    time between.
    """
    state = folder / "state"
    pace, seconds = rng.choice(("max", "realtime")), rng.uniform(0.2, longest)
    begun = rng.choice((0.0, 6.0)) if depth is None else depth
    written = scenario(folder, begun)
    words = ("sitl", "--no-report", "--state", state, "--seed", str(rng.randrange(1000, 2000)))
    station, other = Station(commands=False), Station(commands=False)
    processes: list[Process] = []
    with ended(processes, station, other):
        station.start()
        other.start()
        first = Process(
            folder / "1",
            *words,
            *("--scenario", written, "--pace", pace, "--out", folder / "1", "--gcs", station.address),
        )
        processes.append(first)
        station.until_heard()
        time.sleep(seconds)
        killed = first.kill()
        heard = station.t
        log = read_log(folder / "1")
        z, armed = float(log.truth["eta.z"][-1]), bool(log.columns["applied.armed"][-1])
        left = folder / "left.toml"
        left.write_text(_LEFT.format(depth=max(z, 0.0)), encoding="utf-8")
        second = Process(folder / "2", *words, "--scenario", left, "--out", folder / "2", "--gcs", other.address)
        processes.append(second)
        try:
            other.until_heard(0.5)
        except TimeoutError:
            return no_start(second)
        gap = time.time() - killed
        second.wait(_FLOWN_S)
    after, t = read_log(folder / "2"), last_time(log)
    resumed, depths = after.header["configuration"]["kept"], after.truth["eta.z"]
    moved = bool(after.columns["applied.armed"].any())
    off = distance(log.truth, t, resumed["x"] - CURRENT[0] * gap, resumed["y"] - CURRENT[1] * gap)
    sigmas, lost = off / resumed["position_std"], max(heard - t, 0.0)
    return {
        "pace": pace,
        "begun_m": begun,
        "killed_at_s": round(t, 2),
        "log_lost_s": round(lost, 2),
        "error_m": round(off, 2),
        "sigma_m": round(resumed["position_std"], 2),
        "sigmas": round(sigmas, 3),
        "depth_m": round(z, 1),
        "came_up": moved,
        "depth_at_end_m": round(float(depths[-1]), 1),
        "wrong": wrong(log, after, lost=lost, sigmas=sigmas) + left_down(armed, after.truth["t"], depths, moved),
    }
