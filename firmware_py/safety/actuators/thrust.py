"""The propeller's thrust: does the vehicle's speed follow what its propeller does, whatever the current?

Three filters follow the speed through the water and the current (`water_speed`). One believes what was found out so
far: that the propeller pulls, or that it does not. From it two others set out, again and again: one that believes the
contrary, and one that believes the same of a current that has just changed by as much as it may. While the second
explains the pings of the DVL no worse than the first, both are begun anew; else the sum of the log-likelihood ratio
grows, and at `evidence` the contrary is true.

So no current within the bound, and no jump of it, is a lost propeller: for a while both slow the vehicle down alike,
but a sound propeller drives it faster when it turns faster, as it is soon told to.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.records.health import ActuatorFault
from firmware_py.safety.actuators.runaway import RunawayMemory, RunawayWatch
from firmware_py.safety.actuators.water_speed import Surge, WaterSpeed, WaterSpeedFilter
from firmware_py.vehicle.vehicle import Vehicle

_CLIP = 2.0
"""No ping counts for more, nats."""
_LIKELY = 0.4
"""With this share of the evidence the contrary is likely."""
_GAP = 1.0
"""Between two pings at most, s."""
_FALSE = 0.5
"""A ping that is so far from what was expected, m/s, is left out: between two pings neither vehicle nor water change so
much. Where they go on so, the gap has soon grown too long, and the next one begins anew."""
_PITCHED = 1.0
"""Pitching at q a hull is braked or pushed by q times this, m/s: (m - X_wq) / (m - X_udot), heaving by 0.3 m/s."""
_VAGUE = 0.5
"""Where the model does not hold, thrust and drag are off by this share of the thrust, and by"""
_PUSHED = 0.05
"""this, m/s^2, for about a second at a time: weight, waves, a propeller astern."""


class Ping(NamedTuple):
    """What the vehicle did at a ping.

    Attributes:
        t: time of validity, s.
        u: speed over the bottom ahead, m/s.
        v: to starboard, m/s.
        psi: heading, rad.
        theta: pitch, rad.
        q: rate of pitch, rad/s.
        r: rate of turn, rad/s.
        rudder: rad, positive to port.
        planes: stern planes, rad.
        n: speed of the propeller, rev/s: as reported, else as commanded.
        reported: whether `n` is; if not, it may turn faster.
        judged: False where the model of thrust and drag does not hold.
    """

    t: float
    u: float
    v: float
    psi: float
    theta: float
    q: float
    r: float
    rudder: float
    planes: float
    n: float
    reported: bool
    judged: bool


class ThrustMemory(NamedTuple):
    """What is remembered.

    Attributes:
        lost: whether the propeller makes no thrust.
        t_last: time of validity of the last ping, s.
        sway: through the water, m/s, by rate of turn and rudder.
        water: what is believed.
        other: the same if the contrary is true of the propeller; None: the same.
        changed: the same if the current has just changed.
        evidence: for the contrary, nats.
        runaway: of the watch for a propeller that turns too fast.
    """

    lost: bool
    t_last: float
    sway: float
    water: WaterSpeed | None
    other: WaterSpeed | None
    changed: WaterSpeed | None
    evidence: float
    runaway: RunawayMemory | None = None


_FRESH = ThrustMemory(False, -math.inf, 0.0, None, None, None, 0.0)


class ThrustWatch:
    """Judges the propeller by the vehicle's speed."""

    def __init__(self, vehicle: Vehicle, evidence: float, current: float, eddies: float) -> None:
        """Make a watch.

        Args:
            vehicle: its hull and its propeller.
            evidence: the log-likelihood ratio, nats, at which a fault is named.
            current: the strongest current, m/s.
            eddies: the strongest eddies, 1 sigma, m/s.

        Raises:
            ParamError: the vehicle has no inertia in sway and yaw.
        """
        self._filter = WaterSpeedFilter(vehicle, current, eddies)
        self._advance = vehicle.propeller.u_trim / vehicle.propeller.n_trim
        self._evidence = evidence
        self._runaway = RunawayWatch(self._filter.k, evidence, current)
        self._memory = _FRESH

    @property
    def fault(self) -> ActuatorFault:
        """NONE, LOST or RUNAWAY."""
        if self._memory.lost:
            return ActuatorFault.LOST
        return ActuatorFault.RUNAWAY if self._runaway.fast else ActuatorFault.NONE

    def water(self, t: float) -> tuple[WaterSpeed, ...]:
        """Return what speed and current may be: as is believed, and as the contrary says if it is likely.

        Nothing, if no ping has told of it within a second of t, s.
        """
        m = self._memory
        if m.water is None or t - m.t_last > _GAP:
            return ()
        return (m.water,) if m.other is None or m.evidence < _LIKELY * self._evidence else (m.water, m.other)

    def update(self, ping: Ping) -> ActuatorFault:
        """Return the propeller's fault after a ping of the DVL."""
        m, filter_, psi = self._memory, self._filter, ping.psi
        t, dt = ping.t, ping.t - self._memory.t_last
        if m.water is None or not 0.0 < dt <= _GAP:
            water = filter_.begin(ping.u, psi) if m.water is None else filter_.again(m.water, ping.u, psi, dt)
            self._memory = ThrustMemory(m.lost, t, 0.0, water, None, None, 0.0)
            self._runaway.pause(ping.u)
            return self.fault
        if abs(ping.u - m.water.u - math.cos(ping.theta) * m.water.along(psi)) > _FALSE:
            return self.fault
        u_n = self._advance * ping.n
        sway = filter_.sway(m.sway, m.water.u, ping.r, ping.rudder, dt)
        off = _PITCHED * abs(ping.q) + filter_.fin_drag(m.water.u, ping.rudder, ping.planes)
        off = math.hypot(off, filter_.unweighed(ping.theta))
        surge = Surge(u_n * abs(u_n), filter_.braking(sway, ping.r), filter_.lift(ping.theta), dt, off)
        if not ping.judged:
            surge = surge._replace(off=off + _PUSHED + _VAGUE * filter_.k * abs(surge.thrust))
        pulls = 0.0 if m.lost else 1.0
        water, _ = self._follow(m.water, surge, pulls, ping, sway)
        if not ping.judged:
            self._memory = ThrustMemory(m.lost, t, sway, water, None, None, 0.0)
            self._runaway.pause(ping.u)
            return self.fault
        other, is_other = self._follow(m.other or m.water, surge, 1.0 - pulls, ping, sway)
        changed = m.changed or filter_.widened(m.water)
        changed, is_changed = self._follow(changed, surge, pulls, ping, sway)
        evidence = m.evidence + min(max(is_other - is_changed, -_CLIP), _CLIP)
        if evidence > self._evidence:
            self._memory = ThrustMemory(not m.lost, t, sway, other, None, None, 0.0)
        elif evidence > 0.0:
            self._memory = ThrustMemory(m.lost, t, sway, water, other, changed, evidence)
        else:
            self._memory = ThrustMemory(m.lost, t, sway, water, None, None, 0.0)
        self._runaway.update(dt, ping.u, u_n, max(abs(ping.q), abs(ping.r)), ping.reported)
        return self.fault

    def _follow(
        self, water: WaterSpeed, surge: Surge, share: float, ping: Ping, sway: float
    ) -> tuple[WaterSpeed, float]:
        """Return speed and current after a ping, and the log-likelihood of its u."""
        filter_ = self._filter
        water, likelihood = filter_.hear_ahead(filter_.predict(water, surge, share), ping.u, ping.psi, ping.theta)
        return filter_.hear_aside(water, ping.v - sway, ping.psi, surge.dt), likelihood

    def freeze(self) -> ThrustMemory:
        """Return the whole memory."""
        return self._memory._replace(runaway=self._runaway.freeze())

    def thaw(self, memory: ThrustMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory._replace(runaway=None)
        if memory.runaway is not None:
            self._runaway.thaw(memory.runaway)
