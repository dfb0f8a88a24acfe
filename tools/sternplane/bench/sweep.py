"""A sweep of 1,000 flights of 60 s, measured: `python -m sternplane.bench.sweep`; see `--help`.

Flights a second with one worker and with all, in turns on the same flights; the memory of the command and of its
workers over the flights; and the table of a sweep that is killed twice and gone on with, beside an undisturbed one.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import resource
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

SCENARIO = """
description = "A minute of a dive with two turns, in a current; what is learned is learned."
duration_s = 60.0
completes = "time"
[environment]
current_ned_m_s = [0.06, 0.08, 0.0]
bottom_depth_m = 40.0
[start]
depth_m = 3.0
u_m_s = 1.8
n_rpm = 500.0
[[orders]]
t_s = 0.5
arming = "arm"
[[orders]]
t_s = 1.0
mode = "hold"
depth_m = 8.0
heading_deg = 20.0
speed_m_s = 1.8
[[orders]]
t_s = 30.0
depth_m = 5.0
heading_deg = 340.0
"""
_VARIED = ("--vary", "vehicle.M_q=±20%", "--vary", "truth.current=0..0.3", "--no-report", "--worst", "0")
_LOOK_S = 2.0


def main() -> int:
    """Measure, and print JSON; return 0 if the tables are equal."""
    parser = argparse.ArgumentParser(prog="python -m sternplane.bench.sweep", description=__doc__)
    parser.add_argument("--n", type=int, default=1000, help="flights of the sweeps that are compared [1000]")
    parser.add_argument("--seconds", type=float, default=60.0, help="of each flight [60]")
    parser.add_argument("--paired", type=int, default=20, help="flights of each turn with one worker and with all [20]")
    parser.add_argument("--turns", type=int, default=3, help="how often in turns [3]")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), help="workers [all processors]")
    options = parser.parse_args()
    with TemporaryDirectory(prefix="sternplane-sweep-") as name:
        folder = Path(name)
        text = SCENARIO.replace("duration_s = 60.0", f"duration_s = {options.seconds!r}")
        (folder / "minute.toml").write_text(text.replace("t_s = 30.0", f"t_s = {0.5 * options.seconds!r}"))
        found: dict[str, Any] = {"flight_s": options.seconds}
        found["workers"] = _paired(folder, options)
        whole = _Sweep(folder, "whole", options.n, options.jobs)
        found["undisturbed"] = whole.run()
        killed = _Sweep(folder, "killed", options.n, options.jobs)
        for share in (1.0 / 3.0, 2.0 / 3.0):
            killed.run(kill_at=round(share * options.n))
        killed.run()
        found["killed twice, the same table"] = equal = whole.table == killed.table
    print(json.dumps(found, indent=1))
    return 0 if equal else 1


def _paired(folder: Path, options: argparse.Namespace) -> dict[str, Any]:
    """Fly the same flights with one worker and with all, in turns; the first flight of each worker does not count."""
    rates: dict[int, list[float]] = {1: [], options.jobs: []}
    costs: dict[int, list[float]] = {1: [], options.jobs: []}
    for turn in range(options.turns):
        for jobs in list(rates)[:: 1 if turn % 2 else -1]:
            run = _Sweep(folder, f"turn{turn}.{jobs}", options.paired, jobs)
            measured = run.run()
            rates[jobs].append(measured["flights_s"])
            costs[jobs].append(measured["cpu_s_of_a_flight"])
    ratios = [many / one for many, one in zip(rates[options.jobs], rates[1], strict=True)]
    cost = {"cpu_s_of_a_flight": costs}
    return {"flights_s": rates, "ratio": ratios, "median ratio": statistics.median(ratios), **cost}


class _Sweep:
    """One sweep in a folder of its own, as a process."""

    def __init__(self, folder: Path, name: str, n: int, jobs: int) -> None:
        self._folder, self._out, self._n, self._jobs = folder, folder / name, n, jobs

    @property
    def table(self) -> str:
        """The hash of its table."""
        return hashlib.sha256((self._out / "flights.parquet").read_bytes()).hexdigest()

    def run(self, kill_at: int | None = None) -> dict[str, Any]:
        """Fly what is missing, or until so many flights are there and it is killed; return speed and memory."""
        command = [sys.executable, "-m", "sternplane.cli.main", "sweep", "--scenario", "minute.toml", *_VARIED]
        command += ["--n", str(self._n), "--jobs", str(self._jobs), "--out", str(self._out)]
        times: list[tuple[int, float]] = []
        memory: list[tuple[int, float, float]] = []
        before, there = _processor_s(), self._done()
        with subprocess.Popen(command, cwd=self._folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as child:
            last = 0.0
            while child.poll() is None:
                done, now = self._done(), time.monotonic()
                if not times or done > times[-1][0]:
                    times.append((done, now))
                if now - last >= _LOOK_S:
                    last = now
                    memory.append((done, _resident(child.pid), max(map(_resident, _children(child.pid)), default=0.0)))
                if kill_at is not None and done >= kill_at:
                    child.send_signal(signal.SIGKILL)
                time.sleep(0.05)
            assert child.stderr is not None
            said = child.stderr.read().decode()
        if child.returncode not in (0, -signal.SIGKILL):
            raise SystemExit(f"the sweep ended with {child.returncode}: {said[-2000:]}")
        begun = [one for one in times if one[0] >= self._jobs] or times
        (first, since), (last_done, until) = begun[0], begun[-1]
        return {
            "jobs": self._jobs,
            "cpu_s_of_a_flight": (_processor_s() - before) / max(self._done() - there, 1),
            "flights_s": (last_done - first) / (until - since) if until > since else 0.0,
            "memory_mb": {"flights, command, greatest worker": _quarters(memory)},
        }

    def _done(self) -> int:
        path = self._out / "flights.jsonl"
        return path.read_bytes().count(b"\n") if path.exists() else 0


def _quarters(memory: list[tuple[int, float, float]]) -> list[tuple[int, float, float]]:
    """Return the memory at five moments, evenly from the first to the last."""
    return [memory[round(i * (len(memory) - 1) / 4.0)] for i in range(5)] if memory else []


def _processor_s() -> float:
    """Return the processor time of all processes that have ended, with what they started, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _children(pid: int) -> Iterator[int]:
    for path in Path("/proc").glob(f"{pid}/task/*/children"):
        yield from map(int, path.read_text().split())


def _resident(pid: int) -> float:
    """Return what a process has in memory, MB; 0 if it has ended."""
    try:
        pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    except (OSError, IndexError):
        return 0.0
    return round(pages * os.sysconf("SC_PAGE_SIZE") / 1e6, 1)


if __name__ == "__main__":
    sys.exit(main())
