"""The DVL against fixes, at the surface: the way that it shows against the way that they show.

What fixes leave the way by DVL and heading by grows as fast as one of the two is off, whatever the current; what they
leave the way through the water by the hull's model by grows as fast as the current is. So both are known after twelve
fixes, before anything believes a DVL that was wrong from the start: under water its fault is a current to everybody.
Who is wrong says `way_arbitration`.

- A **DVL** that was wrong stays so under water for as long as it tells of a current that is as far from that by fixes,
  and turns with the hull: where the difference stays as it was over the ground, the fixes walked off. Nobody goes by
  their current: with fins and propeller partly out of the water the hull's model is 0.1 m/s off, or 0.3.
- A **receiver** that was wrong stays so until it was silent, or has agreed with the DVL for a while on a way that would
  show its fault. What its fixes have moved the position by meanwhile is taken back.
- Where it is **undecided**, neither is accused, and the position is doubted by as much as the two go apart. So it is
  where without DVL fixes stand still while the propeller drives on, or tell of a current stronger than any: they lie,
  or the propeller drives no more.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.estimation.integrity.way_arbitration import (
    MARGIN,
    Comparison,
    Entry,
    Wrong,
    arbitrate,
    compare,
    is_absurd_blind,
)
from firmware_py.estimation.navigation.velocity import HullVelocity
from firmware_py.marine import NULL_ISLAND, Origin, geodetic_to_local, wrap
from firmware_py.records.sensing import Dvl, Fix

_ENTRIES, _ENOUGH = 30, 12
"""So many fixes are compared at most, and at least."""
_APART = 0.9
"""Fixes that follow each other sooner, s, tell little more."""
_GAP = 3.0
"""After a longer silence of the fixes, s, the comparison begins anew."""
_HULL = 0.35
"""A current that is less than this away, m/s, clears a DVL, if it is nearer to the one by fixes than to the lie: the
hull's model may have been off by so much at the surface."""
_SHOWS = 0.8
"""On a way of this share of the speed at which it was convicted, a receiver shows its fault."""
_AGREE = 0.1
"""DVL and fixes that differ by less than this, m/s, tell of one current: what begins to be wrong soon does by more."""
_TOLD = 0.9
"""Only a way that was so straight clears a DVL, or tells anew what it is off by."""
_TURNED = 1.0
"""On a heading that is farther from that at the surface, rad, a lie that turns with the hull is told from fixes that
walked off."""


@dataclass(slots=True)
class WayCheckMemory:
    """What is remembered.

    `t` is when a fix was heard last, s; `origin` is where the first was. `north` and `east` are the way since by DVL
    and heading, m, `through_n` and `through_e` that through the water, `ahead_n` and `ahead_e` for how long it has
    headed there, s; `entries` are of the fixes. `lie` is how far the DVL was wrong, m/s, 0 once it is believed again.
    When it was convicted, its u was too high by `lie_ahead`, m/s, on the heading `psi`, rad; fixes left its way by
    `off_n` and `off_e`, m/s, and told the current `current_n` and `current_e`, m/s.
    `began` is when the fixes began to come, `blind` whether there was no ping since; `known` is the current that DVL
    and fixes agreed upon since. `lies` is how far fixes were wrong, m/s, 0 once they are believed again, `lied_at` the
    speed over the ground then. `doubt` is what the position may be off by, m, for which it was undecided last at
    `t_doubt`.
    """

    t: float = -math.inf
    origin: Origin = NULL_ISLAND
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
    began: float = -math.inf
    blind: bool = False
    known: tuple[float, float] | None = None
    lies: float = 0.0
    lied_at: float = 0.0
    doubt: float = 0.0
    t_doubt: float = -math.inf


class Finding(NamedTuple):
    """Who is wrong; since when fixes were, s, if the last one has just shown it, else NaN."""

    wrong: Wrong
    since: float = math.nan


class WayCheck:
    """Carries both ways on and compares them with fixes."""

    def __init__(self) -> None:
        self.memory = WayCheckMemory()

    def carry(
        self, dt: float, psi: float, theta: float, ping: tuple[float, float] | None, hull: HullVelocity | None
    ) -> None:
        """Go on by dt, s, under heading and pitch, rad, at u and v of the newest ping, m/s, believed or not.

        None: there is no ping, or the hull's model does not hold; without that the comparison begins anew.
        """
        m = self.memory
        if not m.entries:
            return
        if hull is None or (m.blind and ping is not None):
            m.entries = ()
            return
        m.blind = ping is None
        s, c, level = math.sin(psi), math.cos(psi), math.cos(theta)
        (u, v), u_hull = ping or (0.0, 0.0), hull.u * level
        u *= level
        m.north += dt * (u * c - v * s)
        m.east += dt * (u * s + v * c)
        m.through_n += dt * (u_hull * c - hull.v * s)
        m.through_e += dt * (u_hull * s + hull.v * c)
        m.ahead_n += dt * c
        m.ahead_e += dt * s

    def hear(self, fix: Fix, t: float, silent: bool = False, sound: bool = True) -> Finding:
        """Take a fix at the time t, s, and return who is wrong by the fixes up to it.

        A receiver that was `silent` before is another one; only a DVL that is else `sound` convicts it.
        """
        m, since = self.memory, t - self.memory.t
        if silent:
            m.lies = 0.0
        known = Finding(Wrong.FIXES if m.lies else Wrong.NOBODY)
        if since > _GAP:
            m.began, m.known = t, None
        if since > _GAP or not m.entries:
            m.origin, m.entries, m.blind = Origin(fix.latitude, fix.longitude), (), False
            m.north = m.east = m.through_n = m.through_e = m.ahead_n = m.ahead_e = 0.0
        elif since < _APART:
            return known
        m.t = t
        north, east = geodetic_to_local(m.origin, fix.latitude, fix.longitude)
        left = north - m.north, east - m.east, north - m.through_n, east - m.through_e
        way = m.north, m.east, m.ahead_n, m.ahead_e
        m.entries = (*m.entries[1 - _ENTRIES :], Entry(t, fix.std, *left, *way))
        return self._judge(compare(m.entries), min(since, _GAP), sound) if len(m.entries) >= _ENOUGH else known

    def _judge(self, c: Comparison, dt: float, sound: bool) -> Finding:
        """Return who is wrong, dt, s, after the fix before, and remember what follows from it."""
        m = self.memory
        if m.blind and not m.lies:
            absurd = is_absurd_blind(c)
            return self._doubt(math.hypot(c.current_n, c.current_e), dt) if absurd else Finding(Wrong.NOBODY)
        long = len(m.entries) == _ENTRIES and not m.blind
        if long and c.off < MARGIN * m.lie and c.straight > _TOLD * c.time:
            m.lie = 0.0
        if long and c.off < MARGIN * m.lies and c.way > _SHOWS * m.lied_at * c.time:
            m.lies = 0.0
        if m.lies:
            return Finding(Wrong.FIXES)
        wrong = arbitrate(c, m.known)
        if wrong is Wrong.NOBODY:
            if long and c.off < _AGREE:
                m.known = c.current_by_dvl
            if m.t_doubt < m.began:
                m.doubt = 0.0
        elif wrong is Wrong.UNDECIDED or (wrong is Wrong.FIXES and (m.lie or not sound)):
            if m.lie or not sound:  # it is known who is wrong
                return Finding(Wrong.NOBODY)
            return self._doubt(c.off, dt)
        elif wrong is Wrong.DVL:
            m.doubt = 0.0
            if m.lie == 0.0 or c.straight > _TOLD * c.time:
                m.lie, m.lie_ahead, m.psi = c.off, -c.along, math.atan2(c.ahead_e, c.ahead_n)
                m.off_n, m.off_e, m.current_n, m.current_e = c.off_n, c.off_e, c.current_n, c.current_e
        else:
            m.lies, m.lied_at, m.doubt = c.off, c.way / c.time, 0.0
            return Finding(Wrong.FIXES, since=m.t - c.time)
        return Finding(wrong)

    def _doubt(self, off: float, dt: float) -> Finding:
        """Take note that for dt, s, two witnesses went apart by `off`, m/s."""
        m = self.memory
        m.doubt += off * dt
        m.t_doubt = m.t
        return Finding(Wrong.UNDECIDED)

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
        if math.hypot(north, east) <= max(min(_HULL, by_lie), MARGIN * m.lie):
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
