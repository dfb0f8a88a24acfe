"""Differential evolution (Storn and Price 1997): a search that needs no slopes and gives the same answer every time."""

from __future__ import annotations

import math

import numpy as np

from sternplane.logs.tracking import Array

_CROSSED = 0.8
"""Probability that a trial takes an entry of the mutant."""
_WEIGHTS = 0.4, 0.9
"""Range of the weight of a difference, drawn anew for each trial."""


class DifferentialEvolution:
    """A population in a box; ask for a trial of each member and tell what it costs.

    The trial of a member is drawn from the way to the best one and a difference of two others (current-to-best/1/bin),
    so that two searches of independent quantities may share their evaluations. All is done in the logarithms of the
    entries, which are positive.

    Attributes:
        best: the best point, shape (entries,).
        cost: what it costs.
    """

    def __init__(self, low: Array, high: Array, size: int, seed: int, start: Array | None = None) -> None:
        """Fill the box from `low` to `high`, shapes (entries,), > 0, with `size` points, `start` first."""
        self._low, self._high = np.log(low), np.log(high)
        self._random = np.random.default_rng(seed)
        strata = self._random.permuted(np.tile(np.arange(size), (len(low), 1)), axis=1).T  # a Latin hypercube
        share = (strata + self._random.random((size, len(low)))) / size
        self._trials = self._low + share * (self._high - self._low)
        if start is not None:
            self._trials[0] = np.clip(np.log(start), self._low, self._high)
        self._points = self._trials.copy()
        self._costs = np.full(size, math.inf)

    @property
    def best(self) -> Array:
        """Return the best point."""
        point: Array = np.exp(self._points[int(np.argmin(self._costs))])
        return point

    @property
    def cost(self) -> float:
        """Return what it costs."""
        return float(np.min(self._costs))

    def ask(self, i: int) -> Array:
        """Return the trial of member i."""
        trial: Array = np.exp(self._trials[i])
        return trial

    def tell(self, i: int, cost: float) -> None:
        """Take what the trial of member i costs; it takes the member's place if that is less."""
        if cost < self._costs[i]:
            self._points[i], self._costs[i] = self._trials[i], cost

    def correct(self, cost: float) -> None:
        """Take what the best point costs after all."""
        self._costs[int(np.argmin(self._costs))] = cost

    def breed(self) -> None:
        """Draw new trials; all the last ones must have been told."""
        size, entries = self._points.shape
        best = self._points[int(np.argmin(self._costs))]
        for i in range(size):
            a, b = self._random.choice(np.delete(np.arange(size), i), 2, replace=False)
            weight = self._random.uniform(*_WEIGHTS)
            own = self._points[i]
            mutant = own + weight * (best - own) + weight * (self._points[a] - self._points[b])
            outside = (mutant < self._low) | (mutant > self._high)
            mutant = np.where(outside, self._random.uniform(self._low, self._high), mutant)
            taken = self._random.random(entries) < _CROSSED
            taken[self._random.integers(entries)] = True
            self._trials[i] = np.where(taken, mutant, own)
