"""A quantity as it was reported from time to time, and its mean over any stretch between."""

from __future__ import annotations

import itertools
from bisect import bisect_right
from collections.abc import Sequence
from typing import NamedTuple

Values = tuple[float, ...]


class TraceMemory(NamedTuple):
    """All reports that are kept."""

    times: tuple[float, ...]
    values: tuple[Values, ...]


class Trace:
    """Reports in order of time; between two it is a straight line, before the first and after the last it stands."""

    def __init__(self) -> None:
        self._times: list[float] = []
        self._values: list[Values] = []

    def __len__(self) -> int:
        return len(self._times)

    def add(self, t: float, values: Values) -> None:
        """A report that is valid at t, s; one that is not newer than the last is left out."""
        if not self._times or t > self._times[-1]:
            self._times.append(t)
            self._values.append(values)

    def forget(self, t: float) -> None:
        """Drops what no mean from t (s) on will need."""
        first = bisect_right(self._times, t) - 1
        if first > 0:
            del self._times[:first], self._values[:first]

    def mean(self, a: float, b: float) -> Values:
        """The mean over [a, b], b > a, s; there must have been a report."""
        times = self._times
        inside = range(bisect_right(times, a), bisect_right(times, b))
        knots = [(a, self._at(a)), *((times[k], self._values[k]) for k in inside), (b, self._at(b))]
        sums = [0.0] * len(knots[0][1])
        for (t_0, v_0), (t_1, v_1) in itertools.pairwise(knots):
            for i, (left, right) in enumerate(zip(v_0, v_1, strict=True)):
                sums[i] += 0.5 * (left + right) * (t_1 - t_0)
        return tuple([value / (b - a) for value in sums])

    def _at(self, t: float) -> Values:
        times, values = self._times, self._values
        k = bisect_right(times, t)
        if k == 0:
            return values[0]
        if k == len(times):
            return values[-1]
        part = (t - times[k - 1]) / (times[k] - times[k - 1])
        return _between(values[k - 1], values[k], part)

    def freeze(self) -> TraceMemory:
        """All it remembers."""
        return TraceMemory(tuple(self._times), tuple(self._values))

    def thaw(self, memory: TraceMemory) -> None:
        """Takes up again what `freeze` gave."""
        self._times, self._values = list(memory.times), list(memory.values)


def _between(a: Sequence[float], b: Sequence[float], part: float) -> Values:
    return tuple([x + part * (y - x) for x, y in zip(a, b, strict=True)])
