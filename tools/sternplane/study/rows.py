"""What a study comes to: rows with a target each, and what is drawn of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from sternplane.logs.tracking import Array
from sternplane.report.drawing import Plot

Numbers = Mapping[str, Array]
"""What one run of a case leaves: arrays by name."""


class Row(NamedTuple):
    """One figure of one case."""

    case: str
    figure: str
    value: float
    target: float | tuple[float, float] | None = None
    """At most so much, or within a band; None is told for information."""

    @property
    def ok(self) -> bool | None:
        """Whether the target is met; None without one. NaN meets none."""
        if self.target is None:
            return None
        if isinstance(self.target, tuple):
            return self.target[0] <= self.value <= self.target[1]
        return self.value <= self.target

    def plain(self) -> dict[str, Any]:
        """As it stands in results.json; a value that is not a number is null."""
        target = list(self.target) if isinstance(self.target, tuple) else self.target
        value = self.value if math.isfinite(self.value) else None
        return {"case": self.case, "figure": self.figure, "value": value, "target": target, "ok": self.ok}


class Findings(NamedTuple):
    """What the runs of one case show."""

    rows: Sequence[Row]
    plots: Sequence[Plot] = ()
    notes: Sequence[str] = ()
    """Sentences for the report."""


class Case(NamedTuple):
    """One question. `run` is called in another process: a function at the top of its module."""

    name: str
    about: str
    """A sentence or two: what is flown, with which sensors, against what."""
    run: Callable[[int, int], Numbers]
    """run(seed, k): the case's k-th run, k = 0, 1, ..."""
    judge: Callable[[Sequence[Numbers]], Findings]
    runs: int
    short: int
    """How many runs, and how many in the form for CI."""
