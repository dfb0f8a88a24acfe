"""How far a run is, for whoever waits for it: a bar in a terminal, a line per tenth of the mission elsewhere."""

from __future__ import annotations

import math
import time
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, TextColumn
from rich.progress import Progress as Bar
from rich.table import Column

from firmware_py.records.cycle import Cycle

_REDRAW_S = 0.125
_LOOK = 16
"""Cycles between two looks at the clock: a look costs as much as all the rest of an update."""
_TEXT = 80
"""Columns that the words take; a bar has what is left."""


class Progress:
    """Shows vehicle time, depth, heading, waypoint, mode and speed-up.

    Args:
        total_s: vehicle time that the run takes at most, s.
        waypoints: how many the mission has.
        console: where to.
    """

    def __init__(self, total_s: float, waypoints: int = 0, console: Console | None = None) -> None:
        self._total_s = total_s
        self._waypoints = waypoints
        self._console = console or Console(stderr=True)
        words = TextColumn("{task.description}", table_column=Column(no_wrap=True, overflow="ellipsis"))
        width = min(24, self._console.width - _TEXT)
        columns = (BarColumn(width), words) if width > 0 else (words,)
        self._bar = Bar(*columns, console=self._console, auto_refresh=False, transient=True)
        self._terminal = self._console.is_terminal
        self._task = self._bar.add_task("", total=total_s) if self._terminal else None
        self._began = self._drawn = time.monotonic()
        self._cycles = 0
        self._tenth = 1

    def update(self, cycle: Cycle) -> None:
        """To be called with every cycle; nearly all calls only count."""
        self._cycles += 1
        if self._cycles % _LOOK:
            return
        if self._task is None:
            if cycle.tick.t >= self._tenth * 0.1 * self._total_s:
                self._console.print(self._line(cycle), highlight=False, soft_wrap=True)
                self._tenth = int(10.0 * cycle.tick.t / self._total_s) + 1
        elif (now := time.monotonic()) - self._drawn >= _REDRAW_S:
            self._drawn = now
            self._bar.update(self._task, completed=cycle.tick.t, description=self._line(cycle), refresh=True)

    def __enter__(self) -> Progress:
        if self._task is not None:
            self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._task is not None:
            self._bar.stop()

    def _line(self, cycle: Cycle) -> str:
        t, eta, leg = cycle.tick.t, cycle.state.eta, cycle.reference.waypoint
        heading = math.degrees(eta.psi) % 360.0
        waypoint = f"  waypoint {min(leg + 1, self._waypoints)}/{self._waypoints}" if self._waypoints else ""
        speed_up = t / max(time.monotonic() - self._began, 1e-9)
        return (
            f"{t:5.1f} of {self._total_s:.0f} s  depth {eta.z:5.2f} m  heading {heading:5.1f}°{waypoint}"
            f"  {cycle.mode.mode.name.lower():<8} {speed_up:4.1f}×"
        )
