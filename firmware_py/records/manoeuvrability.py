"""What the vehicle can still do: how tightly it turns, how soon it pulls up, how slowly it can be steered."""

from __future__ import annotations

import math
from typing import NamedTuple

RESERVE = 0.7
"""Share of the tightest turn that is flown, so that the laws can correct; the hull brakes in turns, too."""
_PULL_UP = 3.0
"""No dive is so steep that more depth than this, m, is lost until it is level."""
_MOST = 10.0
"""More depth, m, than a vehicle that hardly pulls up counts as losing beside a sound one."""


class Manoeuvrability(NamedTuple):
    """What fins do by the coefficients in force, and by what is known of each.

    Attributes:
        turn: curvature of the tightest turn to the side to which it turns less, 1/m; infinite: nothing limits it.
        turn_left: the same, as share of what the vehicle would do with sound fins, in [0, 1].
        up: greatest steady rate of pitch, bow up, by the speed, 1/m.
        up_left: as share of what sound fins would do.
        dive_left: the same to the side, up or down, to which less is left.
        pitch_way: way in which a rate of pitch builds up, m.
        speed: least speed at which the planes hold the vehicle's trim, m/s.
    """

    turn: float = math.inf
    turn_left: float = 1.0
    up: float = math.inf
    up_left: float = 1.0
    dive_left: float = 1.0
    pitch_way: float = 0.0
    speed: float = 0.0

    @property
    def turn_radius(self) -> float:
        """Return the radius of the tightest turn that is flown, m; infinite if it cannot turn to one side."""
        return 1.0 / (RESERVE * self.turn) if self.turn > 0.0 else math.inf

    def pull_up(self, slope: float) -> float:
        """Return how much deeper it gets, m, until it is level, from a dive of `slope`, rad; 0 when it climbs."""
        if not slope > 0.0:
            return 0.0
        return slope * self.pitch_way + (0.5 * slope * slope / self.up if self.up > 0.0 else math.inf)

    def lost_height(self, slope: float) -> float:
        """Return how much more depth than a sound vehicle it needs for that, m; at most 10."""
        if not slope > 0.0 or self.up_left >= 1.0:
            return 0.0
        return min(0.5 * slope * slope * (1.0 - self.up_left) / self.up, _MOST) if self.up > 0.0 else _MOST

    @property
    def slope(self) -> float:
        """Return the steepest dive that is flown, rad, with its way to pull up within 3 m."""
        if not self.up > 0.0:
            return 0.0
        return self.up * (math.hypot(self.pitch_way, math.sqrt(2.0 * _PULL_UP / self.up)) - self.pitch_way)


UNLIMITED = Manoeuvrability()
"""Of a vehicle of which nothing is known: nothing limits it."""
