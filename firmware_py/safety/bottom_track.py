"""How fast the bottom rises under the vehicle: a level course over a slope ends on it."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.tick import Rate

_DT = 1.0 / Rate.HZ_10
_FADE = math.exp(-_DT / 2.0)
"""What is left after a step of what differs from the line, which is followed within some 2 s."""
_JUMP = 2.0
"""A step of the bottom by more than this, m, is an edge, or another echo, and no slope."""


class BottomTrack(NamedTuple):
    """A line through the bottom as it is passed, 10 times a second: a critically damped alpha-beta filter.

    Source: Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001, 6.5.

    Attributes:
        z: its depth, m; NaN while it is not heard.
        rise: how fast it comes up, m/s; negative where it falls.
    """

    z: float = math.nan
    rise: float = 0.0

    def after_a_step(self, z: float) -> BottomTrack:
        """Return the line after another measurement of the bottom's depth, m; NaN where it is not heard."""
        expected = self.z - self.rise * _DT
        off = z - expected
        if not abs(off) <= _JUMP:  # so it is where one of the two is not known
            return BottomTrack(z)
        rise = self.rise - (1.0 - _FADE) ** 2 * off / _DT
        return BottomTrack(expected + (1.0 - _FADE**2) * off, rise)
