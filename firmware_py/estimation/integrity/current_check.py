"""DVL pings against the speed through the water and the current that the coefficient filter knows.

A ping less the filter's velocity through the water is the current. A current walks: it changes by `current_walk` a root
of a second, and eddies stir it, by as much as they did before. What no such change explains is the DVL's fault, or a
current that has changed after all. Two things tell them apart:

- Water that changes does not move the hull at once: drag does, as fast as the difference allows. A DVL that goes off
  faster than a current of 1 m/s more could speed the hull up is wrong (`STEP`, `DRIFT`), whatever it says later: it has
  to come back to the current that was known.
- What goes off more slowly may be a current (`CURRENT`). The DVL is suspect for a minute, in which filter or hull's
  model carry the velocity; if it still tells the same then, it is believed, and its current is the new one.

Where the hull's model alone tells what the speed through the water is, and may be off (`HullVelocity`), nobody is
accused for as much, and no current learned from it.

A u that is too low, and did not fall faster than drag brakes, is thrust that was lost, as often as not: nobody is
accused, and after a minute that is the new current.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

from firmware_py.estimation.navigation.velocity import FilterVelocity, HullVelocity
from firmware_py.marine import wrap
from firmware_py.records.health import SourceFault
from firmware_py.records.sensing import Dvl, Heard
from firmware_py.vehicle.vehicle import Vehicle

_SIGMAS = 5.0
"""So many sigmas no change of the current explains."""
_SMOOTH = 1.0
"""Time constant over which pings are averaged, s."""
_TIME = 60.0
"""And over which the current is, s."""
_SPREAD_LEAST, _SPREAD_TIME = 30.0, 300.0
"""How strong eddies are is averaged over so long, s: as long as is known, between these."""
_SWAY = 0.3
"""What the filter's sway through the water may be off by, of itself."""
_CHANGE = 1.0
"""A current that changes by more than this, m/s, is not reckoned with where the hull speeds up."""
_SIDEWAYS = 10.0
"""Sideways the water moves the hull so many times as easily as ahead."""
_PART = 1.0 / 3.0
"""A change begins where it passes this part of the limit."""
_PROBATION = 60.0
"""For so long, s, a DVL is suspect whose current has changed; one that goes on creeping is suspect again soon after."""
_FILTER_PROBATION = 120.0
"""A filter that was lost is not asked for so long, s."""
_STEP = 1.0
"""What takes longer, s, drifts."""
_BACK = 0.5
"""A DVL that is suspect agrees again below this part of the limit."""
_SLOWLY = (SourceFault.NONE, SourceFault.CURRENT)
"""So does a hull whose model is off by fins or buoyancy; the surface may stop it at once."""
_NOISE = 4.0
"""What a ping may be off by, of its figure of merit."""
_TURNED = math.radians(20.0)
"""A greater change of heading is a turn."""
_FIRST = 5.0
"""Over so long the current is averaged first, s."""
_OFFSET, _HULL = 20.0, 0.02
"""Time constant over which the hull's model is compared with the filter, s, since that is relied on again at most; and
what it is off by then, m/s."""
_HOLDS = 300.0
"""For so long, s, that holds."""
_GAP = 1.0
"""The filter's velocity is carried on to a ping for no longer, s."""
_STRONGEST = 3.0
"""By more than this, m/s, no current changes: a DVL that says so is wrong."""
_CURRENT_OR_DVL = (SourceFault.CURRENT, SourceFault.DRIFT, SourceFault.STEP)
"""What may be a current that is stronger, or came more suddenly, than was reckoned with."""


@dataclass(slots=True)
class CurrentCheckMemory:
    """What is remembered.

    `t` is when the last ping was true, `agreed` when one last agreed with the current `north` and `east`, m/s, known
    for `settled`, s. `spread` is the mean square of what single ones leave it by, over `age`, s, `then` what it was at
    `t_then` and `before` some time earlier: what the DVL does now excuses nothing. `off_n` and `off_e` are what pings
    leave it by now, averaged, m/s, `ahead` and `aside` the same by the hull, `sway` the square of the sway; `t_ahead`
    and `t_aside` when these were small last, `psi_ahead` and `psi_aside` the heading then, rad, `u` a ping's then.
    `told` is when the filter told its velocity last, `known` when it was relied on, as it is from `relied` on; `std`
    its sigma of the current, `off_u` and `off_v` what it left the hull's model by, m/s. `fault` is why the DVL is
    suspect, `accused` since when; `excused` since when it might be.
    """

    t: float = -math.inf
    agreed: float = -math.inf
    north: float = 0.0
    east: float = 0.0
    settled: float = 0.0
    age: float = 0.0
    spread: float = 0.0
    before: float = 0.0
    then: float = 0.0
    t_then: float = -math.inf
    off_n: float = 0.0
    off_e: float = 0.0
    ahead: float = 0.0
    aside: float = 0.0
    sway: float = 0.0
    t_ahead: float = 0.0
    t_aside: float = 0.0
    psi_ahead: float = 0.0
    u: float = 0.0
    psi_aside: float = 0.0
    excused: float = math.inf
    off_u: float = 0.0
    off_v: float = 0.0
    std: float = 0.0
    known: float = -math.inf
    told: float = -math.inf
    relied: float = -math.inf
    accused: float = 0.0
    fault: SourceFault = SourceFault.NONE


class CurrentCheck:
    """Watches what the current is by each ping; `hear` takes what the filter knows, `hull` is what the model does."""

    def __init__(self, walk: float, vehicle: Vehicle) -> None:
        """Take how the current walks, m/s a root of a second, and the vehicle, whose drag moves it with the water."""
        drag, u = vehicle.surge_drag, vehicle.propeller.u_trim
        self._walk = walk
        self._brakes = 1.5 * drag * u * u
        """How fast drag brakes at trim speed, with half as much in reserve, m/s^2."""
        self._carries = 1.5 * drag * ((u + _CHANGE) ** 2 - u * u)
        """How fast a current that is `_CHANGE` stronger speeds the hull up, m/s^2, the same."""
        self.known: FilterVelocity | None = None
        self.hull: HullVelocity | None = None
        self.memory = CurrentCheckMemory()

    def hear(self, known: FilterVelocity | None, t: float) -> None:
        """Take what the filter knows at the time t, s, pings or none: without them it goes on, and is not lost."""
        m, self.known = self.memory, known
        if known is not None and known.t > t - _GAP:
            if -math.inf < m.told < t - _GAP:
                m.relied = t + _FILTER_PROBATION
            m.told = t

    def judge(self, heard: Heard[Dvl], psi: float, theta: float, believed: bool) -> SourceFault:
        """Return what speaks against a ping under these angles, rad; `believed` is whether the DVL is."""
        m, t = self.memory, heard.t_valid
        gap, m.t = min(max(t - m.t, 0.0), _GAP), t
        witnesses = self._through(t, gap, psi, theta)
        if not witnesses:
            if t - m.accused >= _PROBATION:
                m.fault = SourceFault.NONE
            return m.fault
        c, s = math.cos(psi), math.sin(psi)
        if m.agreed == -math.inf:
            m.spread = m.before = self.known.turbulence**2 if self.known else 0.0
            self._begin(t, witnesses[0], heard, c, s)
        along, across = m.north * c + m.east * s, m.east * c - m.north * s
        ahead = min([heard.value.u - u - along for u, _ in witnesses], key=abs)
        aside = min([heard.value.v - v - across for _, v in witnesses], key=abs)
        off_n, off_e = ahead * c - aside * s, ahead * s + aside * c
        share = gap / (_SMOOTH + gap)
        m.off_n += share * (off_n - m.off_n)
        m.off_e += share * (off_e - m.off_e)
        m.ahead, m.aside = m.off_n * c + m.off_e * s, m.off_e * c - m.off_n * s
        m.sway = max(witnesses[0][1] ** 2, m.sway - share * m.sway)
        walked = self._walk * self._walk * (_TIME + max(t - m.agreed, 0.0))
        stirred = m.before if m.settled > _TIME else 2.0 * m.before  # eddies are in the mean too, at first
        usual = heard.value.fom**2 + m.std * m.std + _HULL * _HULL + stirred + walked
        most, most_aside = _SIGMAS * math.sqrt(usual), _SIGMAS * math.sqrt(usual + _SWAY * _SWAY * m.sway)
        if abs(m.ahead) < _PART * most:
            m.t_ahead, m.psi_ahead, m.u = t, psi, heard.value.u
        if abs(m.aside) < _PART * most_aside:
            m.t_aside, m.psi_aside = t, psi
        back = 1.0 if m.fault is SourceFault.NONE else _BACK
        alone = self.hull if m.known < t else None
        low, high, off = (alone.low, alone.high, alone.aside) if alone is not None else (0.0, 0.0, 0.0)
        possible = -most - high <= m.ahead <= most + low and abs(m.aside) <= most_aside + off
        if abs(m.ahead) <= back * most and abs(m.aside) <= back * most_aside:
            m.fault, m.excused = SourceFault.NONE, math.inf
            if believed:
                self._follow(t, gap, off_n, off_e)
        elif m.fault is SourceFault.NONE:
            if abs(m.ahead) > most:
                fault = self._ahead(heard, psi, abs(ahead) - _PART * most)
            else:
                turned, since = wrap(psi - m.psi_aside), t - m.t_aside
                fault = _gone(abs(aside) - _PART * most_aside, since, _SIDEWAYS * self._carries, turned)
            if not (possible and (fault in _SLOWLY or (off and m.ahead <= most))):
                m.fault, m.accused = fault, t
                m.excused = math.inf if fault is not SourceFault.NONE else min(m.excused, t)
        if t - (m.accused if m.fault is SourceFault.CURRENT else m.excused) >= _PROBATION:
            self._begin(t, witnesses[0], heard, c, s)
        return m.fault

    def _through(self, t: float, gap: float, psi: float, theta: float) -> list[tuple[float, float]]:
        """Return u and v through the water, m/s, by each that knows.

        These are the filter, and the hull's model with what the filter has shown that to be off by. A filter that was
        lost may have taken in the fault of a DVL: for as long as that is on probation the other one is asked alone.
        """
        m, known, hull, through = self.memory, self.known, self.hull, []
        if known is not None and known.t > t - _GAP and (t >= m.relied or hull is None):
            c, s = math.cos(psi), math.sin(psi)
            north, east = known.current.north + known.eddy[0], known.current.east + known.eddy[1]
            u, v = known.u - (north * c + east * s) * math.cos(theta), known.v - east * c + north * s
            through.append((u, v))
            m.std = known.current.std
            if hull is not None:
                share = gap / (min(_OFFSET, t - m.relied) + gap)  # what was so before the filter was lost is over
                m.off_u += share * (u - hull.u - m.off_u)
                m.off_v += share * (v - hull.v - m.off_v)
                m.known = t
        if hull is not None and t - m.known <= _HOLDS:
            through.append((hull.u + m.off_u, hull.v + m.off_v))
        return through

    def _ahead(self, heard: Heard[Dvl], psi: float, went: float) -> SourceFault:
        """Return why u went off by so much, m/s: nothing where it is too low, and fell no faster than drag brakes."""
        m, u, since = self.memory, heard.value.u, heard.t_valid - self.memory.t_ahead
        if m.ahead < 0.0 < u and m.u - u <= self._brakes * since + _NOISE * heard.value.fom:
            return SourceFault.NONE
        return _gone(went, since, self._carries, wrap(psi - m.psi_ahead))

    def corrected(self, hull: HullVelocity | None, fault: SourceFault) -> HullVelocity | None:
        """Return what the hull's model says with what the filter has shown that to be off by, and the doubt about it.

        That is what a DVL with this `fault` says that the current has changed by: it may be right.
        """
        m = self.memory
        if hull is None:
            return None
        off = math.hypot(m.ahead, m.aside)
        hull = hull._replace(doubt=off if fault in _CURRENT_OR_DVL and off <= _STRONGEST else 0.0)
        return hull if m.t - m.known > _HOLDS else hull._replace(u=hull.u + m.off_u, v=hull.v + m.off_v)

    def _begin(self, t: float, through: tuple[float, float], heard: Heard[Dvl], c: float, s: float) -> None:
        """Take the current that a ping tells for the one that is known; how strong eddies are stays."""
        m, ahead, aside = self.memory, heard.value.u - through[0], heard.value.v - through[1]
        m.north, m.east = ahead * c - aside * s, ahead * s + aside * c
        m.off_n, m.off_e, m.ahead, m.aside, m.agreed = 0.0, 0.0, 0.0, 0.0, t
        m.fault, m.excused, m.settled = SourceFault.NONE, math.inf, 0.0

    def _follow(self, t: float, gap: float, off_n: float, off_e: float) -> None:
        """Let the current that is known, and its spread, follow what a ping leaves them by, m/s."""
        m = self.memory
        m.agreed, m.settled = t, m.settled + gap
        m.age += gap
        share = gap / min(_TIME, _FIRST + m.settled)
        m.north += share * off_n
        m.east += share * off_e
        share = gap / min(max(m.age, _SPREAD_LEAST), _SPREAD_TIME)
        m.spread += share * (0.5 * (off_n * off_n + off_e * off_e) - m.spread)
        if m.age < _TIME and self.known is not None:
            m.before = m.then = max(m.spread, self.known.turbulence**2)
        elif t - m.t_then >= 0.5 * _TIME:
            m.before, m.then, m.t_then = m.then, m.spread, t

    def freeze(self) -> CurrentCheckMemory:
        """Return the whole memory."""
        return copy.copy(self.memory)

    def thaw(self, memory: CurrentCheckMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self.memory = copy.copy(memory)


def _gone(went: float, since: float, carries: float, turned: float) -> SourceFault:
    """Return why a velocity went off by so much, m/s, in so long, s, where water moves the hull so fast, m/s^2.

    Under another heading, `turned`, rad, a current of before shows in another velocity.
    """
    if went <= carries * since or abs(turned) >= _TURNED:
        return SourceFault.CURRENT
    return SourceFault.STEP if since < _STEP else SourceFault.DRIFT
