"""How late a tick begins: our loop, empty and with the autopilot in it, beside the least loop that C can be.

All wait for absolute deadlines of the same clock and take turns of a second, so that whatever else the machine does
troubles them alike. What they share is the kernel's timer; the ratios are what Python adds.
"""

from __future__ import annotations

import itertools
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from firmware_py import app, loop
from firmware_py.adapters import linux_realtime
from firmware_py.adapters.realtime_schedule import RealTimeSchedule
from firmware_py.records.cycle import Cycle
from firmware_py.tick import step_ns
from sternplane.logs import lateness_histogram
from sternplane.logs.reading import Log

SOURCE = Path(__file__).with_name("lateness.c")
RATES = (100, 1000)
FIGURES = ("median_us", "p99_us", "max_us")
SETTLED = 1000
"""Cycles of the flight that the autopilot has behind it when it is first timed."""

EMPTY = SimpleNamespace(step=lambda *_: SimpleNamespace(applied=None))
"""An autopilot that does nothing."""

Turn = Callable[[int, int], list[int]]
"""(rate, Hz; ticks) -> lateness of each tick but the first, which waits for nothing, ns."""


class NoCompiler(Exception):
    """There is no bare C loop to compare with; the text says why."""


def measure(log: Log, rounds: int = 4, seconds: float = 1.0) -> dict[str, Any]:
    """Median, 99 % and greatest lateness at each rate, and how they compare to C's, as JSON.

    Args:
        log: a flight at 100 Hz, whose inputs the autopilot is given; `rounds` turns and 10 s of it are needed.
        rounds: turns of each loop.
        seconds: of a turn.
    """
    autopilot = Replayed(log)
    turns: dict[tuple[int, str], Turn] = {(rate, "loop"): ours(EMPTY) for rate in RATES}
    turns[100, "autopilot"] = ours(autopilot)
    with tempfile.TemporaryDirectory() as folder:
        missing = ""
        try:
            bare = compile_loop(Path(folder))
            turns |= {(rate, "c"): bare for rate in RATES}
        except NoCompiler as error:
            missing = str(error)
        late: dict[tuple[int, str], list[int]] = {key: [] for key in turns}
        for _, (key, turn) in itertools.product(range(rounds), turns.items()):
            late[key] += turn(key[0], round(seconds * key[0]))
    found: dict[str, Any] = {}
    for (rate, name), values in late.items():
        measured = lateness_histogram.of_cycles(values, step_ns(rate))._asdict()
        found.setdefault(f"{rate} Hz", {})[name] = {figure: measured[figure] for figure in FIGURES}
    return {name: with_ratios(table, missing) for name, table in found.items()}


def with_ratios(table: dict[str, dict[str, float]], missing: str) -> dict[str, Any]:
    """A rate's loops, and each of ours over C's; or why there is no C."""
    if missing:
        return {**table, "c": f"not measured: {missing}"}
    bare = table["c"]
    return table | {
        f"{name} over c": {key.removesuffix("_us"): round(us / bare[key], 2) for key, us in figures.items()}
        for name, figures in table.items()
        if name != "c"
    }


def ours(autopilot: Any) -> Turn:
    """`firmware_py.loop.run` in real time, as it flies: without the garbage collector."""

    def turn(rate: int, ticks: int) -> list[int]:
        late: list[int] = []
        ear: Any = SimpleNamespace(read=lambda tick: late.append(tick.late_ns), write=_ignore)
        mute: Any = SimpleNamespace(read=_ignore, write=_ignore)
        with linux_realtime.apply_while(linux_realtime.RealtimeParams(freeze_garbage=True)):
            loop.run(autopilot, ear, mute, mute, RealTimeSchedule(step_ns(rate), lambda k: k <= ticks))
        return late[1:]

    return turn


def compile_loop(folder: Path) -> Turn:
    """The bare C loop, compiled into a folder.

    Raises:
        NoCompiler: there is no cc, or it does not compile this.
    """
    cc, program = shutil.which("cc"), folder / "lateness"
    if cc is None:
        raise NoCompiler("no C compiler (cc) on this machine")
    built = subprocess.run([cc, "-O2", "-o", program, SOURCE], capture_output=True, text=True, check=False)
    if built.returncode:
        raise NoCompiler(f"cc cannot compile {SOURCE.name}: {built.stderr.strip().partition(chr(10))[0]}")

    def turn(rate: int, ticks: int) -> list[int]:
        command = [str(program), str(step_ns(rate)), str(ticks)]
        return [int(line) for line in subprocess.run(command, capture_output=True, check=True).stdout.split()]

    return turn


class Replayed:
    """The real autopilot on a flight's inputs, one after the other, from turn to turn."""

    def __init__(self, log: Log) -> None:
        self._autopilot = app.build(log.header["configuration"])
        self._cycles: Iterator[Cycle] = iter([*itertools.islice(log.cycles, 3 * SETTLED)])
        for _ in range(SETTLED):
            self.step()

    def step(self, *_now: object) -> Cycle:
        """The next cycle of the flight, whatever tick it is now."""
        was = next(self._cycles)
        return self._autopilot.step(was.tick, was.frame, was.order)


def _ignore(*_arguments: object) -> None:
    pass
