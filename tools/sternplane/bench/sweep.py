"""A sweep of 1,000 flights of 60 s, measured: `python -m sternplane.bench.sweep`; see `--help`.

Flights a second with one worker and with all, in turns on the same flights; the memory of the command and of its
workers over the flights; and beside the table of an undisturbed sweep those of one that is killed twice and gone on
with, and of one over a Dask cluster on this computer that loses a worker in the middle.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import os
import resource
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
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
_LOOK_S, _STARTS_S = 2.0, 60.0


def main() -> int:
    """Measure, and print JSON; progress goes to stderr. Return 0 if the tables are equal."""
    parser = argparse.ArgumentParser(prog="python -m sternplane.bench.sweep", description=__doc__)
    parser.add_argument("--n", type=int, default=1000, help="flights of the sweeps that are compared [1000]")
    parser.add_argument("--seconds", type=float, default=60.0, help="of each flight [60]")
    parser.add_argument("--paired", type=int, default=20, help="flights of each turn with one worker and with all [20]")
    parser.add_argument("--turns", type=int, default=3, help="how often in turns [3]")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as for sweep; may be repeated")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), help="workers [all processors]")
    options = parser.parse_args()
    with TemporaryDirectory(prefix="sternplane-sweep-") as name:
        folder = Path(name)
        text = SCENARIO.replace("duration_s = 60.0", f"duration_s = {options.seconds!r}")
        (folder / "minute.toml").write_text(text.replace("t_s = 30.0", f"t_s = {0.5 * options.seconds!r}"))
        found: dict[str, Any] = {"flight_s": options.seconds}
        found["workers"] = _paired(folder, options)
        whole = _Sweep(folder, "whole", options.n, options.jobs, options.set)
        found["undisturbed"] = whole.run()
        killed = _Sweep(folder, "killed", options.n, options.jobs, options.set)
        for share in (1.0 / 3.0, 2.0 / 3.0):
            killed.run(kill_at=round(share * options.n))
        killed.run()
        spread = _Sweep(folder, "cluster", options.n, options.jobs, options.set)
        with _Cluster(folder, options.jobs) as cluster:
            spread.run(cluster, lose_at=options.n // 2)
        found["same table"] = equal = {
            "killed twice": whole.table == killed.table,
            "over Dask, a worker killed": whole.table == spread.table,
        }
    print(json.dumps(found, indent=1))
    return 0 if all(equal.values()) else 1


class _Cluster:
    """A Dask scheduler and workers of one thread each on this computer, as processes."""

    def __init__(self, folder: Path, size: int) -> None:
        self._folder, self._size = folder, size
        self._stack = contextlib.ExitStack()
        self._workers: list[subprocess.Popen[bytes]] = []
        self.address = ""

    def __enter__(self) -> _Cluster:
        """Start it.

        Raises:
            SystemExit: the scheduler does not start.
        """
        file = self._folder / "scheduler.json"
        self._start("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file))
        end = time.monotonic() + _STARTS_S
        while not (file.exists() and file.stat().st_size):
            if time.monotonic() > end:
                raise SystemExit("no Dask scheduler starts here; is the extra `cluster` installed?")
            time.sleep(0.1)
        self.address = json.loads(file.read_text())["address"]
        for _ in range(self._size):
            self._add()
        return self

    def __exit__(self, *_: object) -> None:
        """End all that runs."""
        self._stack.close()

    def lose_one(self) -> None:
        """Kill a worker, and start another."""
        self._workers[0].kill()
        self._add()

    def _add(self) -> None:
        self._workers.append(self._start("worker", self.address, "--no-nanny", "--nthreads", "1"))

    def _start(self, part: str, *words: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.dask_{part}", *words, "--no-dashboard"]
        process = subprocess.Popen(command, cwd=self._folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self._stack.callback(process.wait)
        self._stack.callback(process.kill)
        return process


def _paired(folder: Path, options: argparse.Namespace) -> dict[str, Any]:
    """Fly the same flights with one worker and with all, in turns; the first flight of each worker does not count."""
    rates: dict[int, list[float]] = {1: [], options.jobs: []}
    costs: dict[int, list[float]] = {1: [], options.jobs: []}
    for turn in range(options.turns):
        for jobs in list(rates)[:: 1 if turn % 2 else -1]:
            run = _Sweep(folder, f"turn{turn}.{jobs}", options.paired, jobs, options.set)
            measured = run.run()
            rates[jobs].append(measured["flights_s"])
            costs[jobs].append(measured["cpu_s_of_a_flight"])
    ratios = [many / one for many, one in zip(rates[options.jobs], rates[1], strict=True)]
    cost = {"cpu_s_of_a_flight": costs}
    return {"flights_s": rates, "ratio": ratios, "median ratio": statistics.median(ratios), **cost}


class _Sweep:
    """One sweep in a folder of its own, as a process."""

    def __init__(self, folder: Path, name: str, n: int, jobs: int, settings: Sequence[str]) -> None:
        self._folder, self._out, self._n, self._jobs = folder, folder / name, n, jobs
        self._words = [*_VARIED, *(word for setting in settings for word in ("--set", setting))]

    @property
    def table(self) -> str:
        """The hash of its table."""
        return hashlib.sha256((self._out / "flights.parquet").read_bytes()).hexdigest()

    def run(
        self, cluster: _Cluster | None = None, *, kill_at: int | None = None, lose_at: int | None = None
    ) -> dict[str, Any]:
        """Fly what is missing; return speed and memory.

        Args:
            cluster: who flies; None: processes of its own.
            kill_at: so many flights are there when it is killed.
            lose_at: so many are there when the cluster loses a worker.
        """
        command = [sys.executable, "-m", "sternplane.cli.main", "sweep", "--scenario", "minute.toml", *self._words]
        command += ["--n", str(self._n), "--out", str(self._out)]
        command += ["--dask", cluster.address] if cluster else ["--jobs", str(self._jobs)]
        times: list[tuple[int, float]] = []
        memory: list[tuple[int, float, float]] = []
        before, there = _processor_s(), self._done()
        print(f"{self._out.name}: {self._n} flights, {self._jobs} at once, {there} are there", file=sys.stderr)
        with subprocess.Popen(command, cwd=self._folder, stdout=subprocess.DEVNULL) as child:
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
                if cluster and lose_at is not None and done >= lose_at:
                    cluster.lose_one()
                    lose_at = None
                time.sleep(0.05)
        if child.returncode not in (0, -signal.SIGKILL):
            raise SystemExit(f"the sweep ended with {child.returncode}")
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
