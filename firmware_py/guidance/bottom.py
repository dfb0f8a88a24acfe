"""The bottom as it was last seen, and depths above it."""

from __future__ import annotations

import math


class Bottom:
    """Remembers its depth, m; NaN until it was seen."""

    def __init__(self, deepest: float, lowest: float) -> None:
        """What is flown above the bottom is never deeper nor lower, m."""
        self._deepest, self._lowest = deepest, lowest
        self.z = math.nan

    def see(self, z: float, altitude: float) -> None:
        """From a depth, m, it is so far down, m; NaN says nothing."""
        if math.isfinite(altitude):
            self.z = z + altitude

    def above(self, altitude: float, otherwise: float) -> float:
        """The depth, m, so high above it, m; another one while it was never seen."""
        if math.isnan(self.z):
            return otherwise
        return min(self.z - max(altitude, self._lowest), self._deepest)
