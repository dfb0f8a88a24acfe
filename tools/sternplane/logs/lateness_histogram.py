"""How late the cycles of a real-time run began."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from sternplane.logs.reading import Piece
from sternplane.logs.run import Run

_EDGES = (0.0, *(round(step * 10.0**decade, 6) for decade in range(8) for step in (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)))
"""us, about equally wide on a logarithmic scale up to 70 s; what is later still has an edge made for it."""


class LatenessHistogram(NamedTuple):
    """A histogram with its figures, all in us; `counts[i]` cycles were in [edges_us[i], edges_us[i + 1])."""

    edges_us: list[float]
    counts: list[int]
    median_us: float
    p99_us: float
    p999_us: float
    max_us: float
    slips: int
    """Cycles that began more than one step after their deadline."""


class LatenessRecord:
    """The lateness of a run's cycles; it is shown the pieces of the log one after the other."""

    def __init__(self) -> None:
        self._late: list[npt.NDArray[np.int64]] = []
        self._dt_ns = 0
        self._prompt = 0

    def add(self, piece: Piece) -> None:
        """Take a piece in."""
        late, self._dt_ns = piece.columns["tick.late_ns"], int(piece.columns["tick.dt_ns"][0])
        if self._late or late.any():
            self._late.append(late.copy())
        else:
            self._prompt += len(late)  # a run that is not in real time has nothing else

    def histogram(self) -> LatenessHistogram | None:
        """Return the histogram; None if the run was not in real time, where none is ever late."""
        if not self._late:
            return None
        return of_cycles(np.concatenate((np.zeros(self._prompt, np.int64), *self._late)), self._dt_ns)


def of_log(log: Run) -> LatenessHistogram | None:
    """The lateness of a run's cycles; None if it was not in real time."""
    record = LatenessRecord()
    for piece in log.pieces():
        record.add(piece)
    return record.histogram()


def of_cycles(late_ns: npt.ArrayLike, dt_ns: int) -> LatenessHistogram:
    """Histogram and figures of at least one cycle's lateness.

    Every figure is one that was measured: p99 is the least lateness that 99 % of the cycles did not exceed.

    Args:
        late_ns: (cycles,), ns.
        dt_ns: the step, ns.
    """
    late = np.sort(np.asarray(late_ns, dtype=np.int64))
    us = late / 1e3
    latest = float(us[-1])
    first = int(np.searchsorted(_EDGES, us[0], side="right")) - 1
    last = int(np.searchsorted(_EDGES, latest, side="right"))
    edges = [*_EDGES[first : last + 1]] if last < len(_EDGES) else [*_EDGES[first:], latest + 1.0]
    counts = np.histogram(us, edges)[0].tolist()
    median, p99, p999 = (float(us[-(-len(us) * permille // 1000) - 1]) for permille in (500, 990, 999))
    return LatenessHistogram(edges, counts, median, p99, p999, latest, int(np.sum(late > dt_ns)))


def with_unit(us: float) -> str:
    """A lateness for people, in the unit that fits: "58 µs", "1.25 ms", "2 s"."""
    for factor, unit in ((1e-6, "s"), (1e-3, "ms")):
        if us * factor >= 1.0:
            return f"{us * factor:.3g} {unit}"
    return f"{us:.3g} µs"
