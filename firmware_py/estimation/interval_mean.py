"""Quantities as they were reported from time to time, and their mean over one stretch after the other, compiled."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from firmware_py.compiled import Indices, Matrix, Vector, kernel, unchecked
from firmware_py.estimation.model.jacobians import Array

ROOM = 1024
"""Reports of each quantity that can wait to be averaged; more are left out."""


class Reports(NamedTuple):
    """All that is remembered of one quantity, in order of time."""

    times: tuple[float, ...]
    values: tuple[float, ...]


class IntervalMeans:
    """Reports of several quantities; between two it is a straight line, before the first and after the last it stands.

    Each quantity has its own times. What is asked for are weighted sums of the means.
    """

    def __init__(self, weights: Sequence[Sequence[float]]) -> None:
        """Makes room for as many quantities as the rows of `weights` are long; there is one row for every sum."""
        self._weights = np.array(weights, dtype=np.float64)
        count = self._weights.shape[1]
        self._times, self._values = np.zeros((count, ROOM)), np.zeros((count, ROOM))
        self._held = np.zeros(count, dtype=np.int64)
        self._newest = [-math.inf] * count

    def add(self, i: int, t: float, value: float) -> None:
        """A report of quantity i that is true for t, s; one that is not newer than the last is left out."""
        if t > self._newest[i] and self._held[i] < ROOM:
            k, self._newest[i] = self._held[i], t
            self._times[i, k], self._values[i, k] = t, value
            self._held[i] = k + 1

    def mean(self, a: float, b: float, sums: Array) -> None:
        """Fills `sums`, (rows,), with what they are in the mean over [a, b], b > a, s; forgets what lies before a.

        A quantity that was never reported counts as 0.
        """
        _mean(self._times, self._values, self._held, self._weights, a, b, sums)

    def freeze(self) -> tuple[Reports, ...]:
        """All it remembers."""
        rows = zip(self._times, self._values, self._held.tolist(), strict=True)
        return tuple(Reports(tuple(t[:k].tolist()), tuple(v[:k].tolist())) for t, v, k in rows)

    def thaw(self, memory: tuple[Reports, ...]) -> None:
        """Takes up again what `freeze` gave."""
        for i, (times, values) in enumerate(memory):
            k = self._held[i] = len(times)
            self._times[i, :k], self._values[i, :k] = times, values
            self._newest[i] = times[-1] if times else -math.inf


@kernel()
def mean(times: Matrix, values: Matrix, held: Indices, weights: Matrix, a: float, b: float, sums: Vector) -> None:
    """See `IntervalMeans.mean`; the first `held` reports of each row of times and values, (count, ROOM), count."""
    for row in range(len(sums)):
        sums[row] = 0.0
    for i in range(len(held)):
        past = 0
        while past + 1 < held[i] and times[i, past + 1] <= a:
            past += 1
        if past > 0:
            held[i] -= past
            for k in range(held[i]):
                times[i, k], values[i, k] = times[i, k + past], values[i, k + past]

        low = min(max(a, times[i, 0]), b)
        area = (low - a) * values[i, 0]
        last = 0
        for k in range(1, held[i]):
            if low == b:
                break
            high = min(times[i, k], b)
            slope = (values[i, k] - values[i, k - 1]) / (times[i, k] - times[i, k - 1])
            area += (high - low) * (values[i, k - 1] + (0.5 * (low + high) - times[i, k - 1]) * slope)
            low, last = high, k
        area += (b - low) * values[i, last]
        for row in range(len(sums)):
            sums[row] += weights[row, i] * area / (b - a)


_mean = unchecked(mean)
