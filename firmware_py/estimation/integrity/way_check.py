"""The DVL against fixes, at the surface: the way that it shows against the way that they show.

What fixes leave the way by DVL and heading by grows as fast as the DVL is off, whatever the current; what they leave
the way through the water by the hull's model by grows as fast as the current is. So both are known after twelve fixes,
before anything believes a DVL that was wrong from the start: under water its fault is a current to everybody.

If they contradict each other the DVL is wrong where it makes the current stronger than the fixes do, and only ahead or
astern: aside the heading may be wrong, and a current from that side would make it the DVL. Fixes that jump contradict
it in one half of the time only. Under water a DVL that was wrong stays so for as long as it tells of a current that is
as far from theirs, and turns with the hull: where the difference stays as it was over the ground, the fixes walked
off. Nobody goes by their current: with fins and propeller partly out of the water the hull's model is 0.1 m/s off, or
0.3.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.estimation.navigation.velocity import HullVelocity
from firmware_py.marine import EARTH_RADIUS, wrap
from firmware_py.records.sensing import Dvl, Fix

_SIGMAS, _LEAST = 5.0, 0.3
"""The two contradict each other beyond so many sigmas, and beyond this, m/s: fixes wander."""
_ENTRIES, _ENOUGH = 30, 12
"""So many fixes are compared at most, and at least."""
_HALF = 0.6
"""Each half of the fixes has to show this share of the contradiction."""
_FIX_STD = 1.0
"""A fix is off by so much at least, m, whatever its receiver says: it may jump."""
_APART = 0.9
"""Fixes that follow each other sooner, s, tell little more."""
_GAP = 3.0
"""After a longer silence of the fixes, s, the comparison begins anew."""
_MARGIN = 0.5
"""Where the currents by DVL and by fixes differ in strength by less than this share of the contradiction, nothing tells
which is wrong. A current that comes back to less than this share of it clears the DVL."""
_HULL = 0.35
"""So does one that is less than this away, m/s, and nearer to the one by fixes than to the lie: the hull's model may
have been off by so much at the surface."""
_ALONG, _STRAIGHT = 0.7, 0.5
"""So much of the contradiction has to be ahead or astern, by a mean heading that was held for this share of the time,
and as much of it along the way by DVL."""
_COMPASS = 0.6
"""A contradiction that is greater than this share of the way by DVL may lie across that way: a compass would have to
be 35 deg off to make it, 2 sin(35 deg / 2)."""
_TOLD = 0.9
"""Only a way that was so straight clears a DVL, or tells anew what it is off by."""
_TURNED = 1.0
"""On a heading that is farther from that at the surface, rad, a lie that turns with the hull is told from fixes that
walked off."""


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


@dataclass(slots=True)
class WayCheckMemory:
    """What is remembered.

    `t` is when a fix was heard last, s; `latitude` and `longitude` are of the first, rad. `north` and `east` are the
    way since by DVL and heading, m, `through_n` and `through_e` that through the water, `ahead_n` and `ahead_e` for how
    long it has headed there, s; `entries` are of the fixes. `lie` is how far the DVL was wrong, m/s, 0 once it is
    believed again. When it was convicted, its u was too high by `lie_ahead`, m/s, on the heading `psi`, rad; fixes left
    its way by `off_n` and `off_e`, m/s, and told the current `current_n` and `current_e`, m/s.
    """

    t: float = -math.inf
    latitude: float = 0.0
    longitude: float = 0.0
    north: float = 0.0
    east: float = 0.0
    through_n: float = 0.0
    through_e: float = 0.0
    ahead_n: float = 0.0
    ahead_e: float = 0.0
    entries: tuple[Entry, ...] = ()
    lie: float = 0.0
    lie_ahead: float = 0.0
    psi: float = 0.0
    off_n: float = 0.0
    off_e: float = 0.0
    current_n: float = 0.0
    current_e: float = 0.0


class WayCheck:
    """Carries both ways on and compares them with fixes."""

    def __init__(self) -> None:
        self.memory = WayCheckMemory()

    def carry(
        self, dt: float, psi: float, theta: float, ping: tuple[float, float] | None, hull: HullVelocity | None
    ) -> None:
        """Go on by dt, s, under heading and pitch, rad, at u and v of the newest ping, m/s, believed or not.

        None: there is no ping, or the hull's model does not hold; the comparison begins anew.
        """
        m = self.memory
        if not m.entries:
            return
        if ping is None or hull is None:
            m.entries = ()
            return
        s, c, level = math.sin(psi), math.cos(psi), math.cos(theta)
        (u, v), u_hull = ping, hull.u * level
        u *= level
        m.north += dt * (u * c - v * s)
        m.east += dt * (u * s + v * c)
        m.through_n += dt * (u_hull * c - hull.v * s)
        m.through_e += dt * (u_hull * s + hull.v * c)
        m.ahead_n += dt * c
        m.ahead_e += dt * s

    def hear(self, fix: Fix, t: float) -> bool:
        """Take a fix at the time t, s, and return whether the DVL is wrong by the fixes up to it."""
        m = self.memory
        if t - m.t > _GAP or not m.entries:
            m.latitude, m.longitude, m.entries = fix.latitude, fix.longitude, ()
            m.north = m.east = m.through_n = m.through_e = m.ahead_n = m.ahead_e = 0.0
        elif t - m.t < _APART:
            return False
        m.t = t
        north = (fix.latitude - m.latitude) * EARTH_RADIUS
        east = wrap(fix.longitude - m.longitude) * EARTH_RADIUS * math.cos(m.latitude)
        left = north - m.north, east - m.east, north - m.through_n, east - m.through_e
        way = m.north, m.east, m.ahead_n, m.ahead_e
        m.entries = (*m.entries[1 - _ENTRIES :], Entry(t, fix.std, *left, *way))
        return len(m.entries) >= _ENOUGH and self._contradicts()

    def _contradicts(self) -> bool:
        m, entries = self.memory, self.memory.entries
        off_n, off_e, current_n, current_e, square = _slopes(entries)
        off, std = math.hypot(off_n, off_e), max(_FIX_STD, *[entry.std for entry in entries]) / math.sqrt(square)
        first, last = entries[0], entries[-1]
        time, ahead_n, ahead_e = last.t - first.t, last.ahead_n - first.ahead_n, last.ahead_e - first.ahead_e
        straight = math.hypot(ahead_n, ahead_e)
        if len(entries) == _ENTRIES and off < _MARGIN * m.lie and straight > _TOLD * time:
            m.lie = 0.0
        by_fixes, by_dvl = math.hypot(current_n, current_e), math.hypot(current_n - off_n, current_e - off_e)
        if not (off > max(_LEAST, _SIGMAS * std) and by_dvl - by_fixes > _MARGIN * off):
            return False
        north, east, along = last.north - first.north, last.east - first.east, off_n * ahead_n + off_e * ahead_e
        way = math.hypot(north, east)
        if straight < _STRAIGHT * time or abs(along) < _ALONG * off * straight:
            return False
        if off * time < _COMPASS * way and abs(off_n * north + off_e * east) < _ALONG * off * way:
            return False
        half = len(entries) // 2
        for part in (entries[:half], entries[half:]):
            part_n, part_e, *_ = _slopes(part)
            if part_n * off_n + part_e * off_e < _HALF * off * off:
                return False
        if m.lie == 0.0 or straight > _TOLD * time:
            m.lie, m.lie_ahead, m.psi = off, -along / straight, math.atan2(ahead_e, ahead_n)
            m.off_n, m.off_e, m.current_n, m.current_e = off_n, off_e, current_n, current_e
        return True

    def still_wrong(self, ping: Dvl, psi: float, hull: HullVelocity | None) -> bool:
        """Return whether a DVL that was wrong tells, under the heading psi, rad, of a current as far from the true one.

        Where the hull's model does not hold, nothing clears it.
        """
        m = self.memory
        if m.lie == 0.0 or hull is None:
            return m.lie > 0.0
        s, c = math.sin(psi), math.cos(psi)
        ahead, aside = ping.u - hull.u, ping.v - hull.v
        north, east = ahead * c - aside * s - m.current_n, ahead * s + aside * c - m.current_e
        by_lie = math.hypot(north - m.lie_ahead * c, east - m.lie_ahead * s)
        if math.hypot(north, east) <= max(min(_HULL, by_lie), _MARGIN * m.lie):
            return False
        return abs(wrap(psi - m.psi)) < _TURNED or by_lie <= math.hypot(north + m.off_n, east + m.off_e)

    def clear(self) -> None:
        """Take note that the DVL is believed again."""
        self.memory.lie = 0.0

    def freeze(self) -> WayCheckMemory:
        """Return the whole memory."""
        return copy.copy(self.memory)

    def thaw(self, memory: WayCheckMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self.memory = copy.copy(memory)


def _slopes(entries: Sequence[Entry]) -> tuple[float, float, float, float, float]:
    """Return how fast the four of each entry grow, m/s (least squares), and the sum of squared times, s^2."""
    middle = sum(entry.t for entry in entries) / len(entries)
    square = sum((entry.t - middle) ** 2 for entry in entries)
    north, east, through_n, through_e = [
        sum((entry.t - middle) * entry[i] for entry in entries) / square for i in range(2, 6)
    ]
    return north, east, through_n, through_e, square
