"""Rows of a study, each a figure with its target, and what a case is made of."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from sternplane.logs.tracking import Array
from sternplane.report.drawing import Plot

RunArrays = Mapping[str, Array]
"""Arrays by name: the result of one run of a case."""
Target = float | tuple[float, float] | None
"""At most so much, or within a band; None for a figure that is information only."""


FEW = 3
"""The median of fewer flights is one flight: the target of the worst holds for it."""


class Row(NamedTuple):
    """One figure of one case.

    Attributes:
        case: its name.
        figure: what it is, with its unit.
        value: the figure.
        target: see `Target`.
        n: over how many seeds, for a figure that chance moves; 0 for one that is the same in every run.
    """

    case: str
    figure: str
    value: float
    target: Target = None
    n: int = 0

    @property
    def ok(self) -> bool | None:
        """Whether the target is met; None without one. NaN meets none."""
        if self.target is None:
            return None
        if isinstance(self.target, tuple):
            return self.target[0] <= self.value <= self.target[1]
        return self.value <= self.target

    @property
    def margin(self) -> float | None:
        """What is left to the target, as a part of it (of half a band): 0 at the target, negative beyond.

        None without a target, and where one is met that leaves no room: no flight may fail, and none does.
        """
        if self.target is None:
            return None
        low, high = self.target if isinstance(self.target, tuple) else (0.0, self.target)
        if low == high:
            return None if self.ok else -math.inf
        if isinstance(self.target, tuple):
            return 2.0 * min(self.value - low, high - self.value) / (high - low)
        return 1.0 - self.value / high

    def plain(self) -> dict[str, Any]:
        """Return the row as it stands in results.json; a number that is not finite is null."""
        target = [*map(_finite, self.target)] if isinstance(self.target, tuple) else _finite(self.target)
        return {
            "case": self.case,
            "figure": self.figure,
            "value": _finite(self.value),
            "target": target,
            "n": self.n,
            "margin": _finite(self.margin),
            "ok": self.ok,
        }


class Results(NamedTuple):
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
    run: Callable[[int, int], RunArrays]
    """run(seed, k): the case's k-th run, k = 0, 1, ..."""
    evaluate: Callable[[Sequence[RunArrays]], Results]
    runs: int
    short: int
    """How many runs, and how many in the form for CI: 0 for a case that is left out of it."""
    judged: Callable[[int, int], RunArrays] | None = None
    """`run` for the form for CI, where no target there judges some of its flights: it leaves these out."""
    files: str = ""
    """What the names of its files begin with; "" for its name."""

    def in_form(self, short: bool) -> Case:
        """Return the case as one of the forms runs it; runs that leave flights out have files of their own."""
        if not short or self.judged is None:
            return self
        return self._replace(run=self.judged, files=f"{self.name}, judged flights")


class Study(NamedTuple):
    """Cases that are flown and shown together; `title` and `description` are those of the report."""

    title: str
    description: str
    cases: Sequence[Case]
    chance: bool = False
    """Whether its bands are such as chance alone hardly leaves; the page then says how hardly."""

    def in_form(self, short: bool) -> Study:
        """Return the study with the cases that are flown in its short or its full form."""
        return self._replace(cases=[case.in_form(short) for case in self.cases if case.short or not short])


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
