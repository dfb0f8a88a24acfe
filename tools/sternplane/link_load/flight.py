"""One flight in real time, in a process of its own, and how late its cycles began."""

from __future__ import annotations

import contextlib
import json
import resource
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sternplane.link_load.flood import Flood
from sternplane.link_load.stations import Files, LoadStation, Missions, Parameters
from sternplane.logs import lateness_histogram
from sternplane.logs.reading import read
from sternplane.sitl.flight import CONFIG

_SPARE_S = 2.0
"""So long before the end of a flight stations have done."""
_STARTING_S = 60.0
"""What a flight may take to begin."""
_ENDING_S = 300.0
"""What it may take to write its report."""
_SCENARIO = """
description = "Holds depth and heading while stations keep the vehicle busy."
completes = "time"
duration_s = {seconds:.1f}

[[orders]]
t_s = 1.0
arming = "arm"

[[orders]]
t_s = 2.0
mode = "hold"
depth_m = 8.0
heading_deg = 0.0
speed_m_s = 1.5
"""
AS_AT_SEA = """
[realtime]
fifo_priority = 50
lock_memory = true
"""
"""As in io_sea.toml; what this machine does not permit is left out."""


class Problem(Exception):
    """A flight that did not go as it should; the text says how."""


def measure(seconds: float, folder: Path, items: int, flood: float) -> dict[str, Any]:
    """Fly without stations, with three, and under a flood; return lateness and cost of each, and the stations' work.

    Args:
        seconds: vehicle time of each flight.
        folder: for logs.
        items: of each mission.
        flood: datagrams a second.

    Raises:
        Problem: a flight failed, or a station.
    """
    alone = _flown(seconds, folder / "alone", ())
    working = busy(seconds, folder, items)
    drowned = measure_flooded(seconds, folder, flood)
    did = working["did"] | drowned["did"]
    return {"seconds": seconds, "alone": alone, **working, **drowned, "did": did}


def measure_flooded(seconds: float, folder: Path, rate: float) -> dict[str, Any]:
    """Fly while one link receives `rate` meaningless datagrams a second; see `measure`."""
    flood = Flood(seconds - _SPARE_S, rate)
    flown = _flown(seconds, folder / "flood", (flood,))
    if flood.problems:
        raise Problem("; ".join(flood.problems))
    losses = read(folder / "flood" / "log.mcap").end.get("losses", {})
    lost = {f"lost, {name.removeprefix('gcs_1_')}": n for name, n in losses.items() if name.startswith("gcs_1_") and n}
    return {"flood": flown, "did": {"flood": {**flood.counts, **lost}}}


def busy(seconds: float, folder: Path, items: int) -> dict[str, Any]:
    """Fly with three stations; see `measure`."""
    work = seconds - _SPARE_S
    files = Files(252, work, folder)
    stations = (Parameters(251, work), files, Missions(253, work, items))
    flown = _flown(seconds, folder / "stations", stations)
    whole = (folder / "stations" / "log.mcap").read_bytes()
    for path in files.fetched:
        files.counts["logs fetched equal"] += whole.startswith(path.read_bytes())
    problems = [problem for station in stations for problem in station.problems]
    if problems:
        raise Problem("; ".join(problems))
    did = {type(station).__name__.lower(): dict(sorted(station.counts.items())) for station in stations}
    return {"stations": flown, "did": did}


def _flown(seconds: float, folder: Path, stations: Sequence[LoadStation | Flood]) -> dict[str, Any]:
    """Return the lateness of one flight, and what its cycles cost."""
    folder.mkdir(parents=True)
    scenario = folder / "load.toml"
    scenario.write_text(_SCENARIO.format(seconds=seconds))
    io = folder / "io.toml"
    io.write_text((CONFIG / "io_sitl.toml").read_text(encoding="utf-8") + AS_AT_SEA, encoding="utf-8")
    links = [word for station in stations for word in ("--gcs", f"udpout:127.0.0.1:{station.port}")]
    cost = folder / "cost.json"
    command = [sys.executable, "-m", "sternplane.link_load.vehicle", str(cost), "sitl"]
    command += ["--scenario", str(scenario), "--io", str(io), "--pace", "realtime"]
    before = _cpu_s()
    with (folder / "output").open("w+") as output, contextlib.ExitStack() as stack:
        process = subprocess.Popen([*command, "--out", str(folder), *links], stdout=output, stderr=output)
        stack.callback(process.kill)
        for station in stations:
            station.start()
        try:
            process.wait(timeout=_STARTING_S + seconds + _ENDING_S)
        except subprocess.TimeoutExpired:
            raise Problem(f"{folder.name}: the flight does not end") from None
        for station in stations:
            station.join(timeout=_ENDING_S)
            station.end()
        output.seek(0)
        words = output.read().strip()
    log = read(folder / "log.mcap")
    late = lateness_histogram.of_log(log)
    if process.returncode not in (0, 1) or late is None or "reason" not in log.end:
        raise Problem(f"{folder.name}: the flight broke off: {words[-2000:]}")
    cycles = sum(late.counts)
    figures = {name: round(getattr(late, name), 1) for name in ("median_us", "p99_us", "p999_us", "max_us")}
    return {
        "cycles": cycles,
        **figures,
        "late": late.slips,
        "late_pct": round(100.0 * late.slips / cycles, 4),
        "cpu_s": round(_cpu_s() - before, 1),
        "changes": sum(map(len, log.changes.values())),
        "outcome": log.end.get("reason", ""),
        "cost_ms": json.loads(cost.read_text()),
    }


def _cpu_s() -> float:
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime
