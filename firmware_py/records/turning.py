"""Radius and speed of circles: a fin vehicle can neither stand still nor turn on the spot."""

from __future__ import annotations

import math
from typing import NamedTuple

_ROOM = 1.25
"""Ratio of the smallest circle to the tightest turn, so that the vehicle can correct inwards."""

_WIDEST = 1000.0
"""m; a vehicle that cannot turn to one side is not asked for circles wider than this."""


class Turning(NamedTuple):
    """Radius of a circle that gives none, m; tightest turn, m, fastest, rad/s; cruising speed and fastest, m/s."""

    loiter_radius: float
    turn_radius: float
    turn_rate_max: float
    cruise_speed: float
    speed_max: float

    def widened(self, radius: float) -> Turning:
        """Return the same for a vehicle that turns no tighter than this, m."""
        return self._replace(turn_radius=min(max(self.turn_radius, radius), _WIDEST))

    def tightest(self, u: float) -> float:
        """Return the radius of the smallest circle at u, m/s, in m."""
        return _ROOM * max(self.turn_radius, u / self.turn_rate_max)

    def radius(self, asked: float, u: float) -> float:
        """Return the radius, m, at u, m/s, for a requested one of either sign; 0 requests none."""
        return max(abs(asked) or self.loiter_radius, self.tightest(u))

    def speed(self, asked: float) -> float:
        """Return the speed, m/s, for a requested one; 0 requests none."""
        return min(asked if asked > 0.0 else self.cruise_speed, self.speed_max)


AS_ASKED = Turning(0.0, 0.0, math.inf, 0.0, math.inf)
"""No limits: every circle has the requested radius."""
