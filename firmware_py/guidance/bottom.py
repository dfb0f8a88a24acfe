"""Depth of the bottom as last measured, and depths above it."""

from __future__ import annotations

import math

from firmware_py.records.mission import Loiter, Waypoint


class Bottom:
    """The last known depth of the bottom, m; NaN until it is known."""

    def __init__(self, deepest: float, lowest: float) -> None:
        """`deepest` (depth) and `lowest` (altitude), m, bound every depth that `above` returns."""
        self._deepest, self._lowest = deepest, lowest
        self.z = math.nan

    def see(self, z: float, altitude: float) -> None:
        """Take an altitude measured at depth z, both m; NaN is ignored."""
        if math.isfinite(altitude):
            self.z = z + altitude

    def depth_of(self, item: Waypoint | Loiter, otherwise: float) -> float:
        """Return the depth of an item, m; `otherwise` for one above a bottom that is unknown."""
        return self.above(item.z, otherwise) if item.above else item.z

    def above(self, altitude: float, otherwise: float) -> float:
        """Return the depth, m, at an altitude, m; `otherwise` while the bottom is unknown."""
        if math.isnan(self.z):
            return otherwise
        return min(self.z - max(altitude, self._lowest), self._deepest)
