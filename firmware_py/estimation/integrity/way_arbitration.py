"""Who is wrong when the way by the DVL and the way by fixes go apart at the surface: the hull's model is the third.

What either of them leaves the way through the water by, as propeller and rudder make it, grows as fast as the current
is, by that witness. The water carries a hull by one current, so it is one of the two that is wrong:

- the one whose current has changed, where both told of the same before: water that changes, changes both;
- else the DVL, if it makes the current stronger than the fixes do; and fixes, if they stand still while propeller and
  DVL drive on, or tell of a current that is stronger than any: a weaker one a DVL may miss that is off as much.

It is told only ahead or astern: aside the heading may be wrong, and turns both ways away from the fixes. And only if
each half of the fixes shows it: a jump shows in one. Where these do not tell, nobody is accused.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence
from typing import NamedTuple

_SIGMAS, _LEAST = 5.0, 0.3
"""The two contradict each other beyond so many sigmas, and beyond this, m/s: fixes wander."""
_FIX_STD = 1.0
"""A fix is off by so much at least, m, whatever its receiver says: it may jump."""
MARGIN = 0.5
"""Where the currents by DVL and by fixes differ in strength, or in what they changed by, by less than this share of the
contradiction, nothing tells which is wrong. A current that comes back to less than this share of it clears the DVL."""
_HALF, _HALF_SPEEDING = 0.6, 0.3
"""Each half of the fixes has to show this share of the contradiction; of fixes that do not follow a vehicle that gains
way the first half shows less."""
_ALONG, _STRAIGHT = 0.7, 0.5
"""So much of the contradiction has to be ahead or astern, by a mean heading that was held for this share of the time,
and as much of it along the way by DVL."""
_COMPASS = 0.6
"""A contradiction that is greater than this share of the way by DVL may lie across that way: a compass would have to
be 35 deg off to make it, 2 sin(35 deg / 2)."""
_STRONGEST = 1.2
"""No current is stronger, m/s."""
_STILL = 0.2
"""Fixes that move at less than this share of the vehicle's speed stand still."""
_DRIVEN = 0.5
"""Without pings, they do so under a vehicle whose propeller drives it faster than this, m/s."""


class Wrong(enum.Enum):
    """Who is wrong; UNDECIDED: one of the two."""

    NOBODY = enum.auto()
    DVL = enum.auto()
    FIXES = enum.auto()
    UNDECIDED = enum.auto()


class Entry(NamedTuple):
    """A fix: time, s; 1 sigma, m; what it leaves the ways by DVL and through the water by, m; what these were then."""

    t: float
    std: float
    off_n: float
    off_e: float
    drift_n: float
    drift_e: float
    north: float
    east: float
    ahead_n: float
    ahead_e: float


class Comparison(NamedTuple):
    """What some fixes show.

    Attributes:
        off_n: how fast the fixes leave the way by DVL, north, m/s.
        off_e: the same, east.
        off: the same, its size.
        std: 1 sigma of that.
        current_n: the current by fixes, north, m/s.
        current_e: the same, east.
        time: from the first to the last of them, s.
        ahead_n: how long the vehicle has headed north meanwhile, s.
        ahead_e: the same, east.
        north: the way by DVL meanwhile, m.
        east: see north.
        halves: the least of `off` that either half of them shows, m/s.
    """

    off_n: float
    off_e: float
    off: float
    std: float
    current_n: float
    current_e: float
    time: float
    ahead_n: float
    ahead_e: float
    north: float
    east: float
    halves: float

    @property
    def straight(self) -> float:
        """For how long the mean heading was held, s."""
        return math.hypot(self.ahead_n, self.ahead_e)

    @property
    def along(self) -> float:
        """How fast the fixes leave the way by DVL ahead, by that heading, m/s."""
        return (self.off_n * self.ahead_n + self.off_e * self.ahead_e) / max(self.straight, 1e-9)

    @property
    def way(self) -> float:
        """The way by DVL, m."""
        return math.hypot(self.north, self.east)

    @property
    def current_by_dvl(self) -> tuple[float, float]:
        """The current by DVL, north and east, m/s."""
        return self.current_n - self.off_n, self.current_e - self.off_e

    @property
    def differs(self) -> bool:
        """Whether DVL and fixes contradict each other."""
        return self.off > max(_LEAST, _SIGMAS * self.std)


def compare(entries: Sequence[Entry]) -> Comparison:
    """Return what so many fixes show; a few at least."""
    off_n, off_e, current_n, current_e, square = _slopes(entries)
    off, half = math.hypot(off_n, off_e), len(entries) // 2
    parts = [_slopes(part) for part in (entries[:half], entries[half:])]
    first, last = entries[0], entries[-1]
    return Comparison(
        off_n,
        off_e,
        off,
        max(_FIX_STD, *[entry.std for entry in entries]) / math.sqrt(square),
        current_n,
        current_e,
        last.t - first.t,
        last.ahead_n - first.ahead_n,
        last.ahead_e - first.ahead_e,
        last.north - first.north,
        last.east - first.east,
        min((part[0] * off_n + part[1] * off_e) / max(off, 1e-9) for part in parts),
    )


def arbitrate(c: Comparison, known: tuple[float, float] | None) -> Wrong:
    """Return who is wrong; `known` is the current that both told before, north and east, m/s, None if they did not."""
    if not c.differs:
        return Wrong.NOBODY
    north, east = known or (0.0, 0.0)
    by_dvl_n, by_dvl_e = c.current_by_dvl
    more = math.hypot(by_dvl_n - north, by_dvl_e - east) - math.hypot(c.current_n - north, c.current_e - east)
    half = _HALF if more > 0.0 else _HALF_SPEEDING
    if abs(more) <= MARGIN * c.off or c.halves < half * c.off or not _is_along(c):
        return Wrong.UNDECIDED
    if more < 0.0 and known is None and not _is_absurd(c):
        return Wrong.UNDECIDED
    return Wrong.DVL if more > 0.0 else Wrong.FIXES


def _is_absurd(c: Comparison) -> bool:
    """Return whether fixes stand still as only a receiver does, or tell of a current that is stronger than any."""
    moved = math.hypot(c.off_n + c.north / c.time, c.off_e + c.east / c.time)
    return moved < _STILL * c.way / c.time or math.hypot(c.current_n, c.current_e) > _STRONGEST


def is_absurd_blind(c: Comparison) -> bool:
    """Return the same without pings: then there is no way by DVL, and what fixes leave that by is their own way."""
    current = math.hypot(c.current_n, c.current_e) - _SIGMAS * c.std
    driven = math.hypot(c.off_n - c.current_n, c.off_e - c.current_e)
    return current > (_DRIVEN if c.off < _STILL * driven else _STRONGEST)


def _is_along(c: Comparison) -> bool:
    """Return whether the contradiction is ahead or astern, by heading and by way."""
    if c.straight < _STRAIGHT * c.time or abs(c.along) < _ALONG * c.off:
        return False
    by_way = abs(c.off_n * c.north + c.off_e * c.east)
    return c.off * c.time >= _COMPASS * c.way or by_way >= _ALONG * c.off * c.way


def _slopes(entries: Sequence[Entry]) -> tuple[float, float, float, float, float]:
    """Return how fast the four of each entry grow, m/s (least squares), and the sum of squared times, s^2."""
    middle = sum(entry.t for entry in entries) / len(entries)
    square = sum((entry.t - middle) ** 2 for entry in entries)
    north, east, through_n, through_e = [
        sum((entry.t - middle) * entry[i] for entry in entries) / square for i in range(2, 6)
    ]
    return north, east, through_n, through_e, square
