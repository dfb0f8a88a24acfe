"""How far a run is, for whoever waits for it: a bar in a terminal, a line per tenth of the mission elsewhere."""

from __future__ import annotations

import math
import time
from types import TracebackType
from typing import NamedTuple

from rich.console import Console, RenderableType
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from firmware_py.records.cycle import Cycle
from firmware_py.records.event_text import texts
from firmware_py.run.sensor_watch import SensorWatch
from firmware_py.run.terminal import folded
from sternplane.plain_console import PlainConsole

_REDRAW_S = 0.125
_LOOK = 16
"""Cycles between two looks at the clock: a look costs as much as all the rest of an update."""
_LEAST_BAR, _MOST_BAR = 8, 24


class _Form(NamedTuple):
    """A way to say where a run is: always, and for a mission the waypoint; a bar goes before it where there is room."""

    words: str
    waypoint: str = ""


_FORMS = (
    _Form(
        "{t:5.1f} of {total:.0f} s  depth {z:z5.2f} m  heading {psi:5.1f}°{waypoint}  {mode:<8} {speed_up:4.1f}×",
        "  waypoint {next}/{last}",
    ),
    _Form(
        "{t:5.1f}/{total:.0f} s  depth {z:z5.2f} m  hdg {psi:5.1f}°{waypoint}  {mode:<8} {speed_up:4.1f}×",
        "  wp {next}/{last}",
    ),
    _Form("{t:.0f}/{total:.0f} s {z:z5.2f} m {psi:5.1f}°{waypoint} {mode:<8} {speed_up:4.1f}×", " wp {next}/{last}"),
    _Form("{t:.0f} s {z:z.1f} m {psi:.1f}°{waypoint} {mode}", " wp {next}"),
)
"""From the longest to the shortest, which is for where not even the words have room."""


class Progress:
    """Shows vehicle time, depth, heading, waypoint, mode and speed-up, and every event when it happens.

    A depth or heading that is only carried on, without its sensor, is shown as "?".

    Args:
        total_s: vehicle time that the run takes at most, s.
        waypoints: how many the mission has.
        console: where to.
    """

    def __init__(self, total_s: float, waypoints: int = 0, console: Console | None = None) -> None:
        self._total_s = total_s
        self._waypoints = waypoints
        self._console = console or PlainConsole(stderr=True)
        self._terminal = self._console.is_terminal
        self._live = Live(console=self._console, auto_refresh=False, transient=True)
        self._began = self._drawn = time.monotonic()
        self._cycles = 0
        self._tenth = 1
        self._hearing = SensorWatch()
        self._t = 0.0

    def update(self, cycle: Cycle) -> None:
        """Show a cycle; to be called with every one, and nearly all calls only count."""
        self._t = cycle.tick.t
        for text in texts(cycle.events) if cycle.events else ():
            self.tell(text)
        self._cycles += 1
        if self._cycles % _LOOK:
            return
        for change in self._hearing.changes(cycle):
            self.tell(change)
        if not self._terminal:
            if cycle.tick.t >= self._tenth * 0.1 * self._total_s:
                self._say(self._line(cycle, _FORMS[0]))
                self._tenth = int(10.0 * cycle.tick.t / self._total_s) + 1
        elif (now := time.monotonic()) - self._drawn >= _REDRAW_S:
            self._drawn = now
            self._live.update(self._bar(cycle, self._console.width), refresh=True)

    def tell(self, sentence: str) -> None:
        """Show a sentence with the time of the last cycle."""
        self._say(f"{self._t:9.2f} s  {sentence}")

    def __enter__(self) -> Progress:
        with self._console.capture():  # what rich loads for its first line takes as long as a cycle may
            self._say("-")
        if self._terminal:
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._terminal:
            self._live.stop()

    def _say(self, line: str) -> None:
        text = folded(line, self._console.width) if self._terminal else line
        self._console.print(text, highlight=False, markup=False, soft_wrap=True)

    def _bar(self, cycle: Cycle, width: int) -> RenderableType:
        """Return one line: the longest form that leaves room for a bar, or else the longest that fits without one."""
        lines = [self._line(cycle, form) for form in _FORMS]
        for line in lines[:-1]:
            if (left := width - len(line) - 1) >= _LEAST_BAR:
                row = Table.grid(padding=(0, 1, 0, 0))
                row.add_row(ProgressBar(self._total_s, cycle.tick.t, width=min(left, _MOST_BAR)), Text(line))
                return row
        return Text(next((line for line in lines if len(line) <= width), lines[-1]), no_wrap=True, overflow="ellipsis")

    def _line(self, cycle: Cycle, form: _Form) -> str:
        t, state = cycle.tick.t, cycle.state
        heading = round(math.degrees(state.eta.psi), 1) % 360.0  # rounded first: 359.97 is 0.0, not 360.0
        known = {
            "t": t,
            "total": self._total_s,
            "z": state.eta.z if state.depth_ok else math.nan,
            "psi": heading if state.attitude_ok else math.nan,
            "next": min(cycle.reference.waypoint + 1, self._waypoints),
            "last": self._waypoints,
            "mode": cycle.mode.mode.name.lower(),
            "speed_up": t / max(time.monotonic() - self._began, 1e-9),
        }
        waypoint = form.waypoint.format(**known) if self._waypoints else ""
        return form.words.format(waypoint=waypoint, **known).replace("nan", "  ?")
