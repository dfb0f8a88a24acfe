"""How far the experiments are: one bar in a terminal, a line for each elsewhere."""

from __future__ import annotations

import time
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from firmware_py.records.cycle import Cycle

_REDRAW = 100
"""Cycles between two looks of the bar."""


class ExperimentProgress:
    """Counts work in seconds of vehicle time; whatever does not fly counts as `ExperimentProgress.REST`."""

    REST = 10.0

    def __init__(self, total: float, console: Console) -> None:
        """`total`: of all that will be done."""
        self._console = console
        columns = (TextColumn("{task.description:<28}"), BarColumn(), TextColumn("{task.percentage:>3.0f} %"))
        self._bar = Progress(*columns, TimeElapsedColumn(), TimeRemainingColumn(), console=console, transient=True)
        self._task: TaskID = self._bar.add_task("the motions", total=total)
        self._begun = time.monotonic()
        self._whole = self._t = 0.0

    def begin(self, words: str) -> None:
        """What comes next."""
        self._bar.update(self._task, description=words)

    def watch(self, cycle: Cycle) -> None:
        """To be called with every cycle of a flight."""
        self._t = cycle.tick.t
        if cycle.tick.k % _REDRAW == 0:
            self._bar.update(self._task, completed=self._whole + self._t)

    def done(self, words: str, worth: float = REST) -> None:
        """Something is done."""
        self._whole += worth
        self._bar.update(self._task, completed=self._whole)
        if not self._console.is_terminal:
            seconds = time.monotonic() - self._begun
            self._console.print(f"{seconds:6.1f} s  {words}", highlight=False, soft_wrap=True)

    def __enter__(self) -> ExperimentProgress:
        if self._console.is_terminal:
            self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()
