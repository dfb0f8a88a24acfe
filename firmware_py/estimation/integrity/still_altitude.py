"""An altitude that stays while the vehicle dives, and no other sensor sees the bottom: a bottom that falls, or a lie.

It dives if both the depth that is believed and the carried one say so: without DVL eddies carry a hull by metres that
pitch and speed do not see, and the pressure may drift.

A vehicle that follows a slope keeps its altitude as well. But there the bottom falls first, and goes on as it fell
before; where the slope changes, the altitude changes until the vehicle has followed. What is stuck begins to fall just
when, and just as fast as, the vehicle dives: it leaves the course that the bottom had when the altitude began to stay.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

LENGTH = 26
"""Entries of a track, one a second: the course before, and"""
_LONGEST = 20
"""so many entries over which an altitude may be found to stay."""
_COURSE = 5
"""Entries over which the course of the bottom is measured before: the median, for a jump is none."""
_STAYS = 0.2
"""An altitude stays while it is within so much, m: what noise of 0.08 m makes in the mean, and less than it changes by
where a slope of more than 0.08 m/s begins, which a vehicle follows 4 s late."""
_FALLS = 2.0
"""So much deeper than its course, m, the bottom is in doubt: such a slope makes 1.6 m in 20 s."""
REACTS = 0.5
"""The altitude is not stuck if it has changed by so much since, m."""


class Sounding(NamedTuple):
    """The depth of the bottom and the depth that is carried on at one time, m.

    Where the bottom has jumped since by `leapt`, m, this is in `bottom`: so the course goes on. The carried depth was
    deeper than the one that is believed, as far as one was, by `off`, m.
    """

    bottom: float
    carried: float
    off: float = 0.0
    leapt: float = 0.0

    def leap(self, by: float) -> Sounding:
        """Return it after the bottom has jumped, m."""
        return self._replace(bottom=self.bottom + by, leapt=self.leapt + by)

    @property
    def altitude(self) -> float:
        """Return the altitude, m."""
        return self.bottom - self.carried


def bottom_before(track: Sequence[Sounding]) -> float:
    """Return the nearest bottom, m, since just before the altitude began to stay; NaN if nothing is in doubt.

    Args:
        track: a sounding a second, the newest last.
    """
    if not track:
        return math.nan
    now, doubted = track[-1], False
    low = high = now.altitude
    nearest = now.bottom
    for age in range(1, min(_LONGEST, len(track) - 1 - _COURSE) + 1):
        then, before = track[-1 - age], track[-1 - age - _COURSE]
        low, high = min(low, then.altitude), max(high, then.altitude)
        if high - low > _STAYS:
            break
        falls = now.bottom - then.bottom - max(0.0, now.off - then.off)
        if not doubted and falls > _FALLS:
            doubted = falls > _FALLS + _course(track[-1 - age - _COURSE : len(track) - age]) * age
        nearest = min(nearest, then.bottom - then.leapt, before.bottom - before.leapt)
    return nearest if doubted else math.nan


def _course(track: Sequence[Sounding]) -> float:
    """Return by how much the bottom falls from entry to entry, m; 0 where it rises."""
    falls = sorted(after.bottom - before.bottom for before, after in itertools.pairwise(track))
    return max(0.0, falls[len(falls) // 2])
