"""Mean, root mean square, greatest and last of numbers that come in parts."""

from __future__ import annotations

import math

import numpy as np

from sternplane.logs.tracking import Array


class Mean:
    """Mean, root mean square, greatest and last of numbers that come in parts; None where there was none."""

    def __init__(self) -> None:
        self.count, self._sum, self._squares = 0, 0.0, 0.0
        self.greatest: float | None = None
        self.last: float | None = None

    def add(self, values: Array) -> None:
        """Take some in."""
        if not values.size:
            return
        self.count += values.size
        self._sum += float(np.sum(values))
        self._squares += float(np.sum(values**2))
        greatest = float(np.max(values))
        self.greatest = greatest if self.greatest is None else float(np.maximum(self.greatest, greatest))
        self.last = float(values[-1])

    @property
    def mean(self) -> float | None:
        """The mean."""
        return self._sum / self.count if self.count else None

    @property
    def rms(self) -> float | None:
        """The root mean square."""
        return math.sqrt(self._squares / self.count) if self.count else None
