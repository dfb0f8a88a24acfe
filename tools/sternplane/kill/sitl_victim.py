"""`sitl` is killed; the next one resumes what it kept."""

from __future__ import annotations

import random
import time
from pathlib import Path
from typing import Any

from sternplane.kill.judgement import distance, last_time, no_start, read_log, wrong
from sternplane.kill.processes import CURRENT, Process, Station, ended, scenario


def trial(folder: Path, _bus: str, rng: random.Random, longest: float = 8.0) -> dict[str, Any]:
    """Kill one flight, start another; return the figures, and in "wrong" what is not as it should be.

    It is killed at a random time, at most `longest` (s) after it is heard. The next flight begins anew where its
    scenario says. So what it resumes is held against the place of the vehicle when it was killed, carried on by the
    current for the time between.
    """
    written, state = scenario(folder), folder / "state"
    pace, seconds = rng.choice(("max", "realtime")), rng.uniform(0.2, longest)
    words = ("sitl", "--scenario", written, "--state", state, "--pace", pace, "--seed", str(rng.randrange(1000, 2000)))
    station, other = Station(commands=False), Station(commands=False)
    processes: list[Process] = []
    with ended(processes, station, other):
        station.start()
        other.start()
        first = Process(folder / "1", *words, "--out", folder / "1", "--gcs", station.address)
        processes.append(first)
        station.until_heard()
        time.sleep(seconds)
        killed = first.kill()
        heard = station.t
        second = Process(folder / "2", *words, "--out", folder / "2", "--gcs", other.address)
        processes.append(second)
        try:
            other.until_heard(0.5)
        except TimeoutError:
            return no_start(second)
        gap = time.time() - killed
    log, resumed = read_log(folder / "1"), read_log(folder / "2").header["configuration"]["kept"]
    t = last_time(log)
    off = distance(log.truth, t, resumed["x"] - CURRENT[0] * gap, resumed["y"] - CURRENT[1] * gap)
    sigmas, lost = off / resumed["position_std"], max(heard - t, 0.0)
    return {
        "pace": pace,
        "killed_at_s": round(t, 2),
        "log_lost_s": round(lost, 2),
        "error_m": round(off, 2),
        "sigma_m": round(resumed["position_std"], 2),
        "sigmas": round(sigmas, 3),
        "wrong": wrong(log, lost=lost, sigmas=sigmas),
    }
