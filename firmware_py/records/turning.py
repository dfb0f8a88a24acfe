"""How wide the circles are that are flown: a fin vehicle can neither stand nor turn on the spot."""

from __future__ import annotations

import math
from typing import NamedTuple

_ROOM = 1.25
"""A circle is so much wider than the tightest turn, so that the boat can come nearer to its centre."""


class Turning(NamedTuple):
    """Radius of a circle that gives none, m; tightest turn, m, fastest, rad/s; cruising speed and fastest, m/s."""

    loiter_radius: float
    turn_radius: float
    turn_rate_max: float
    cruise_speed: float
    speed_max: float

    def tightest(self, u: float) -> float:
        """Radius of the tightest circle at u, m/s, in m."""
        return _ROOM * max(self.turn_radius, u / self.turn_rate_max)

    def radius(self, asked: float, u: float) -> float:
        """Radius, m, of the circle that is flown at u, m/s, where one is asked for, of either sign; 0 gives none."""
        return max(abs(asked) or self.loiter_radius, self.tightest(u))

    def speed(self, asked: float) -> float:
        """The speed, m/s, that is flown where one is asked for; 0 asks for none."""
        return min(asked if asked > 0.0 else self.cruise_speed, self.speed_max)


AS_ASKED = Turning(0.0, 0.0, math.inf, 0.0, math.inf)
"""Of nobody in particular: every circle is as wide as it is asked for."""
