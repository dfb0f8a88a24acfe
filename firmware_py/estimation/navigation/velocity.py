"""Velocity over the bottom: by the coefficient filter, else by the DVL, held between pings, else by the hull's model.

The coefficient filter carries the velocity from ping to ping by thrust, drag and fins, and it knows the current. It is
believed from when it agrees with the pings; then it goes on without them, for as long as its own 1 sigma is small.
While it is not believed, pings are held. Without either, propeller and rudder tell the velocity through the water, and
the current that was known last, by the filter or by the pings (`integrity.model_check`), is added.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.estimation.freshness import is_fresh
from firmware_py.estimation.navigation.velocity_params import VelocityParams
from firmware_py.marine import clip
from firmware_py.records.estimate import VelocitySource
from firmware_py.records.sensing import Dvl, Heard

_LEAVES = 3.0
"""The filter is believed up to so many times the 1 sigma at which it began to be."""
_PROBATION = 120.0
"""A filter that pings contradicted, and that agrees with them again, may have taken in the fault of a DVL. For so long,
s, it is not believed without them, and its sigma is no less than the change of the current that it tells."""
_HELD = 1.2
"""A ping is held for so long, s, where the filter could tell the velocity: until the next one of a DVL of 1 Hz."""
_COASTS = 120.0
"""A hull whose propeller is stopped may be under way for about so long, s: one of 5 m loses half of 1.4 m/s."""
_LATE = 1.0
"""A filter that is farther behind, s, has stopped."""


class Current(NamedTuple):
    """The water's mean velocity, north and east, m/s, its 1 sigma on each axis, and when it was known, s."""

    north: float
    east: float
    std: float
    t: float

    def std_at(self, params: VelocityParams, t: float) -> float:
        """Return 1 sigma at the time t, m/s."""
        return math.hypot(self.std, params.current_walk * math.sqrt(max(0.0, t - self.t)))


UNKNOWN_CURRENT = Current(0.0, 0.0, math.inf, -math.inf)


class FilterVelocity(NamedTuple):
    """What the coefficient filter knows of the velocities at the time t, s.

    Attributes:
        t: time of validity, s.
        u: over the ground, m/s.
        v: see u.
        w: see u.
        std: 1 sigma of u and of v, m/s.
        current: the water's mean velocity.
        eddy: what eddies add to it now, north and east, m/s.
        turbulence: their intensity, m/s.
    """

    t: float
    u: float
    v: float
    w: float
    std: float
    current: Current
    eddy: tuple[float, float]
    turbulence: float


class HullVelocity(NamedTuple):
    """Speed ahead and sway through the water by the vehicle file, m/s, and the current that pings have left.

    `doubt` is what pings that are not believed say that the current has changed by. `low` and `high` are what u may be
    too low by, if turned fins are not there to brake it, and too high, `aside` what v may be off by, m/s: buoyancy may
    be other than weighed, and the model is that of a hull under water.
    """

    u: float
    v: float
    current: Current
    doubt: float = 0.0
    low: float = 0.0
    high: float = 0.0
    aside: float = 0.0


class Motion(NamedTuple):
    """What the vehicle does now: phi, theta, psi, rad; propeller speed n, rev/s; its model, None: it does not hold."""

    phi: float
    theta: float
    psi: float
    n: float
    hull: HullVelocity | None = None


class Measured(NamedTuple):
    """A velocity over the bottom that was true at the time t, s: body axes and 1 sigma, m/s."""

    t: float
    u: float
    v: float
    w: float
    std: float


NO_PING = Measured(-math.inf, 0.0, 0.0, 0.0, 0.0)


class VelocityMemory(NamedTuple):
    """What is remembered.

    Attributes:
        t: time of validity of the velocity that was taken last, s.
        u: body velocity, m/s.
        v: see u.
        w: see u.
        fom: 1 sigma that it had, m/s.
        ping: the last good one.
        source: what it rests on.
        current: that was known last.
        eddy: see `FilterVelocity`; 0 without it.
        turbulence: see eddy.
        anchor: the current that the filter knew before pings contradicted it.
        t_broken: when they did, s.
        since: when the first of the pings was true that have come without a gap, s.
        coast: how fast it may still be though its propeller drives it no longer, m/s, where nothing else tells.
    """

    t: float
    u: float
    v: float
    w: float
    fom: float
    ping: Measured
    source: VelocitySource
    current: Current
    eddy: tuple[float, float] = (0.0, 0.0)
    turbulence: float = 0.0
    anchor: Current = UNKNOWN_CURRENT
    t_broken: float = -math.inf
    since: float = -math.inf
    coast: float = 0.0


START = VelocityMemory(-math.inf, 0.0, 0.0, 0.0, 0.0, NO_PING, VelocitySource.NONE, UNKNOWN_CURRENT)


def update(
    params: VelocityParams,
    memory: VelocityMemory,
    heard: Heard[Dvl],
    t: float,
    dt: float,
    motion: Motion,
    known: FilterVelocity | None = None,
) -> VelocityMemory:
    """One tick of dt, s: takes what the filter knows, or a good new ping, else holds the last, else follows the hull.

    Args:
        params: parameters.
        memory: of the tick before.
        heard: the ping that was heard last.
        t: time now, s.
        dt: tick, s.
        motion: what the vehicle does.
        known: by the coefficient filter; None: nothing that can be believed.
    """
    ping = heard.value if is_fresh(heard, memory.ping.t, t) else None
    fom = 0.0
    if ping is not None:
        u, v, w, fom, _ = ping
        fom = fom if math.isfinite(fom) and fom > 0.0 else params.std
        if abs(u) <= params.u_max and abs(v) <= params.u_max and abs(w) <= params.u_max and fom <= params.fom_max:
            since = memory.since if heard.t_valid - memory.ping.t <= params.timeout else heard.t_valid
            memory = memory._replace(ping=Measured(heard.t_valid, u, v, w, fom), since=since)
        else:
            ping = None
    if known is not None and _believed(params, memory, known, t):
        if known.t <= memory.t:
            followed = memory.source is VelocitySource.FILTER
            return memory if followed else memory._replace(source=VelocitySource.FILTER)
        now = known.t, known.u, known.v, known.w, known.std, memory.ping, VelocitySource.FILTER
        water = known.current, known.eddy, known.turbulence
        return VelocityMemory(*now, *water, memory.anchor, memory.t_broken, memory.since)
    if memory.source is VelocitySource.FILTER and t - memory.ping.t <= params.timeout:
        # What pings contradict is no longer believed. The current before the first of several such is the one to keep.
        anchor = memory.anchor if t - memory.t_broken <= _PROBATION else memory.current
        memory = memory._replace(source=VelocitySource.DVL, anchor=anchor, current=anchor, t_broken=t)
    if ping is not None and heard.t_valid > memory.t:
        now = *memory.ping, memory.ping, VelocitySource.DVL
        return VelocityMemory(*now, memory.current, anchor=memory.anchor, t_broken=memory.t_broken, since=memory.since)
    if t - memory.t <= params.timeout:
        return memory
    return _follow(params, memory, motion, t, dt)


def _believed(params: VelocityParams, memory: VelocityMemory, known: FilterVelocity, t: float) -> bool:
    """Return whether the filter tells the velocity: once it has agreed with pings, it may go on without.

    Where it did not, it is behind the first ping that is heard again: it has to take that in before it is believed.
    """
    if memory.source is VelocitySource.FILTER:
        if t - memory.ping.t > params.timeout and memory.ping.t - memory.t_broken <= _PROBATION:
            return False
        return known.std <= _LEAVES * params.filter_std and t - known.t <= _LATE
    heard = t - memory.ping.t <= params.timeout and known.t >= memory.since
    return known.std <= params.filter_std and heard and t - known.t <= _LATE


def _follow(params: VelocityParams, memory: VelocityMemory, motion: Motion, t: float, dt: float) -> VelocityMemory:
    """Go over from the last velocity to the one that propeller, rudder and the last current make likely."""
    hull, current, source = motion.hull, memory.current, VelocitySource.NONE
    doubted = memory.ping.t - memory.t_broken <= _PROBATION
    if doubted:
        current = memory.anchor
    u, v, w = clip(motion.n * params.u_trim / params.n_trim, -params.u_max, params.u_max), 0.0, 0.0
    if hull is not None:
        u, v, source = hull.u, hull.v, VelocitySource.HULL_MODEL
        if not doubted and hull.current.std_at(params, t) < current.std_at(params, t):
            current = hull.current
    if current.std_at(params, t) < params.lost_std:
        c, s = math.cos(motion.psi), math.sin(motion.psi)
        along, aside = current.north * c + current.east * s, current.east * c - current.north * s
        u, v, w = u + along * math.cos(motion.theta), v + aside, along * math.sin(motion.theta)
    share, coast = dt / (params.tau_lost + dt), 0.0
    if source is VelocitySource.NONE:
        coast = max(abs(memory.u), memory.coast) * (1.0 - dt / _COASTS)
    return memory._replace(
        u=memory.u + share * (u - memory.u),
        v=memory.v + share * (v - memory.v),
        w=memory.w + share * (w - memory.w),
        source=source,
        current=current,
        eddy=(0.0, 0.0),
        turbulence=0.0,
        coast=coast,
    )


def std(params: VelocityParams, memory: VelocityMemory, t: float) -> float:
    """1 sigma of u and of v at the time t, m/s: of ping or filter, growing with its age up to that of the model."""
    held = math.hypot(memory.fom, params.accel_std * (t - memory.t)) if memory.t > -math.inf else math.inf
    if memory.source is VelocitySource.FILTER:
        return math.hypot(held, _unseen(params, memory, t))
    if memory.source is VelocitySource.HULL_MODEL:
        return min(held, params.lost_std, math.hypot(params.hull_std, memory.current.std_at(params, t)))
    return min(held, max(params.lost_std, memory.coast - abs(memory.u)))


def reckoned(params: VelocityParams, memory: VelocityMemory, t: float) -> Measured:
    """Return the velocity by which dead reckoning goes on at the time t, s: pings while they are heard.

    All that is known of a steady current is the mean of the pings, so nothing tells the way better than they do. What a
    filter was off by while it was learning the current would stay in the way.
    """
    if memory.source is VelocitySource.FILTER and t - memory.ping.t <= min(_HELD, params.timeout):
        return memory.ping
    return Measured(memory.t, memory.u, memory.v, memory.w, memory.fom)


def lasting_std(params: VelocityParams, memory: VelocityMemory, t: float) -> float:
    """1 sigma of what the way over the ground is off by for long, m/s, beside what pings are: without eddies."""
    if memory.source is not VelocitySource.FILTER:
        return std(params, memory, t) if t - memory.t > params.timeout else 0.0
    own = change = 0.0
    if t - memory.t_broken <= _PROBATION:
        change = math.hypot(memory.current.north - memory.anchor.north, memory.current.east - memory.anchor.east)
    if t - memory.ping.t > params.timeout:
        own = math.sqrt(max(0.0, memory.fom**2 - memory.turbulence**2))
        own = max(memory.current.std, own)
    return math.hypot(own, _unseen(params, memory, t), change)


def _unseen(params: VelocityParams, memory: VelocityMemory, t: float) -> float:
    """1 sigma of how the current has changed since the last ping, m/s."""
    gap = t - memory.ping.t
    return params.current_walk * math.sqrt(gap) if gap > params.timeout else 0.0


def water(params: VelocityParams, memory: VelocityMemory, t: float) -> tuple[float, float, float]:
    """Return the water's velocity north and east, m/s, and its 1 sigma.

    NaN where pings alone tell the velocity, and where the current is not known well enough to be in it.
    """
    current, (north, east) = memory.current, memory.eddy
    now = current.std_at(params, t)
    known = memory.source is VelocitySource.HULL_MODEL and now < params.lost_std
    if known or (memory.source is VelocitySource.FILTER and current.std < math.inf):
        return current.north + north, current.east + east, now
    return math.nan, math.nan, math.nan
