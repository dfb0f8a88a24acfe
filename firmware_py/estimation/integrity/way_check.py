"""The DVL against fixes, at the surface: the way that it shows against the way that they show.

What fixes leave the way by DVL and heading by grows as fast as the DVL is off, whatever the current; what they leave
the way through the water by the hull's model by grows as fast as the current is. So both are known within ten seconds,
before anything believes a DVL that was wrong from the start: under water its fault is a current to everybody.

If they contradict each other the DVL is wrong where it makes the current stronger than the fixes do. Under water it
stays so for as long as it tells of a current that is as far from theirs; nothing else there knows of it.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

from firmware_py.estimation.navigation.velocity import HullVelocity
from firmware_py.marine import EARTH_RADIUS, wrap
from firmware_py.records.sensing import Dvl, Fix

_SIGMAS, _LEAST = 5.0, 0.3
"""The two contradict each other beyond so many sigmas, and beyond this, m/s: fixes wander."""
_ENTRIES, _ENOUGH = 30, 6
"""So many fixes are compared at most, and at least."""
_GAP = 3.0
"""After a longer silence of the fixes, s, the comparison begins anew."""
_MARGIN = 0.5
"""Where the currents by DVL and by fixes differ in strength by less than this share of the contradiction, nothing tells
which is wrong. A current that comes back to less than this share of it clears the DVL."""


@dataclass(slots=True)
class WayCheckMemory:
    """What is remembered.

    `t` is when a fix was heard last, s; `latitude` and `longitude` are of the first, rad. `north` and `east` are the
    way since by DVL and heading, m, `through_n` and `through_e` that through the water; `entries` are time and what
    fixes left these ways by, m. `lie` is how far the DVL was wrong, m/s, 0 once it is believed again, and `current_n`
    and `current_e` are the current by fixes then, m/s.
    """

    t: float = -math.inf
    latitude: float = 0.0
    longitude: float = 0.0
    north: float = 0.0
    east: float = 0.0
    through_n: float = 0.0
    through_e: float = 0.0
    entries: tuple[tuple[float, float, float, float, float], ...] = ()
    lie: float = 0.0
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

    def hear(self, fix: Fix, t: float) -> bool:
        """Take a fix at the time t, s, and return whether the DVL is wrong by the fixes up to it."""
        m = self.memory
        if t - m.t > _GAP or not m.entries:
            m.latitude, m.longitude, m.entries = fix.latitude, fix.longitude, ()
            m.north = m.east = m.through_n = m.through_e = 0.0
        m.t = t
        north = (fix.latitude - m.latitude) * EARTH_RADIUS
        east = wrap(fix.longitude - m.longitude) * EARTH_RADIUS * math.cos(m.latitude)
        entry = (t, north - m.north, east - m.east, north - m.through_n, east - m.through_e)
        m.entries = (*m.entries[1 - _ENTRIES :], entry)
        return len(m.entries) >= _ENOUGH and self._contradicts(fix.std)

    def _contradicts(self, std: float) -> bool:
        m, n = self.memory, len(self.memory.entries)
        middle = sum(entry[0] for entry in m.entries) / n
        square = sum((entry[0] - middle) ** 2 for entry in m.entries)
        off_n, off_e, current_n, current_e = [
            sum((entry[0] - middle) * entry[i] for entry in m.entries) / square for i in range(1, 5)
        ]
        off, limit = math.hypot(off_n, off_e), max(_LEAST, _SIGMAS * std / math.sqrt(square))
        by_fixes, by_dvl = math.hypot(current_n, current_e), math.hypot(current_n - off_n, current_e - off_e)
        wrong = off > limit and by_dvl - by_fixes > _MARGIN * off
        if wrong:
            m.lie, m.current_n, m.current_e = off, current_n, current_e
        return wrong

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
        return math.hypot(north, east) > _MARGIN * m.lie

    def clear(self) -> None:
        """Take note that the DVL is believed again."""
        self.memory.lie = 0.0

    def freeze(self) -> WayCheckMemory:
        """Return the whole memory."""
        return copy.copy(self.memory)

    def thaw(self, memory: WayCheckMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self.memory = copy.copy(memory)
