"""DVL pings against the ping before, the speed that thrust and drag make likely, and the current.

What u leaves the speed by thrust and drag by is followed in two ways: as thrust or drag that is other than thought, so
that drag takes the hull back to what the propeller drives it to (`likely`); and as a current, which no drag takes, and
which turns against the hull when that turns. A DVL is wrong where u has left both. With the first alone a sound DVL was
named in a current of 1.2 m/s: of a hull of 1.3 m, whose drag is great for its mass, straight on too.

Of a hull that lies on its side, or stands on its end, no model says how fast it should be, nor what the water does.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass, field

from firmware_py.estimation.integrity.current_check import CurrentCheck, CurrentCheckMemory
from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.estimation.integrity.source_watch import SourceWatch
from firmware_py.estimation.integrity.way_check import WayCheck, WayCheckMemory
from firmware_py.estimation.navigation.velocity import HullVelocity
from firmware_py.records.health import SourceFault
from firmware_py.records.sensing import Dvl, Heard
from firmware_py.vehicle.vehicle import Vehicle

_REAL = 4
"""So many pings in a row that jump are a step."""
_IMPOSSIBLE = 3
_ACCELERATION = 0.3
"""What the velocity may change by in a gap between pings, m/s^2."""
_FOLLOW = 15.0
"""Time constant with which the likely speed follows the measured one, s: current, and a model that is not right."""
_ASIDE, _HEAVE = 0.8, 0.35
"""Most that a DVL which was suspect may show of sway, and of heave, m/s."""
_DRIVEN = 0.5
"""Thrust and drag tell the speed while the propeller drives for this, m/s, or more. Astern or at rest, and without the
drop weight, a hull glides by its buoyancy as fast as `IntegrityParams.speed`."""
_SURFACING = 5.0
"""The same while the bow leaves the water, m/s^2."""
_GAP = 2.0
_LEVER, _LAG = 0.2, 0.1
"""A DVL sits within so much of the length from the middle, and its pings may be so much older than they say, s: while
the vehicle turns, it sees other velocities than the navigation."""
_UNSEEN = math.radians(15.0)
"""Without AHRS it may turn as fast as this, rad/s."""


@dataclass(slots=True)
class VelocityCheckMemory:
    """The last ping that was believed, the likely speed (m/s), and whether thrust and drag tell it.

    `driven` is the speed that thrust and drag alone make, in whatever current, m/s; NaN: the propeller does not drive,
    and what it drove the hull to before is braked away. `north` and `east` are the current that pings leave that by,
    m/s; NaN: none yet. `upright` is whether the hull lies as the models have it.
    `turning` is the square of the greatest rate of turn since then, rad^2/s^2; `current` and `way` are what
    `CurrentCheck` and `WayCheck` remember.
    """

    t: float = -math.inf
    u: float = 0.0
    v: float = 0.0
    w: float = 0.0
    likely: float = 0.0
    driven: float = math.nan
    north: float = math.nan
    east: float = math.nan
    holds: bool = False
    upright: bool = True
    measured: bool = False
    turning: float = 0.0
    current: CurrentCheckMemory = field(default_factory=CurrentCheckMemory)
    way: WayCheckMemory = field(default_factory=WayCheckMemory)


class VelocityCheck:
    """Checks the velocities of pings; `current` is to be told what the coefficient filter knows, `way` of fixes."""

    def __init__(self, params: IntegrityParams, vehicle: Vehicle, current_walk: float) -> None:
        """Take limits and vehicle, and how the current walks, m/s a root of a second."""
        self._params, self.current, self.way = params, CurrentCheck(current_walk, vehicle), WayCheck()
        hull, propeller = vehicle.hull, vehicle.propeller
        self._ratio = propeller.u_trim / propeller.n_trim
        self._half, self._lever = 0.5 * hull.length, _LEVER * hull.length
        self._drag, self._lift = vehicle.surge_drag, vehicle.lift_ahead
        self.memory = VelocityCheckMemory()

    def step(self, dt: float, n: float, theta: float, dropped: bool, brakes: float, upright: bool = True) -> None:
        """Let thrust, drag and buoyancy act for dt, s.

        Args:
            dt: s.
            n: the propeller's speed, rev/s.
            theta: pitch, rad.
            dropped: whether the drop weight is gone.
            brakes: what turning and fins do to the speed ahead, m/s^2.
            upright: whether the hull is neither rolled nor pitched beyond what the models are proven for.
        """
        memory = self.memory
        pull, likely, lift = n * self._ratio, memory.likely, self._lift * math.sin(theta) + brakes
        memory.upright, memory.holds = upright, pull >= _DRIVEN and upright and not dropped
        memory.likely = self._pulled(likely, pull, lift, dt)
        if memory.driven == memory.driven:
            memory.driven = self._pulled(memory.driven, pull, lift, dt)
        elif memory.holds:
            memory.driven = pull
        if dropped or max(pull, memory.driven) < _DRIVEN:
            memory.driven = math.nan

    def _pulled(self, u: float, pull: float, lift: float, dt: float) -> float:
        """Return a speed, m/s, after thrust that makes `pull` on a level course, drag, and lift, m/s^2, for dt, s."""
        return u + dt * self._drag * (pull * abs(pull) - u * abs(u)) + dt * lift

    def turn(self, p: float, q: float, r: float) -> None:
        """Take note of body rates, rad/s."""
        squared = p * p + q * q + r * r
        if squared > self.memory.turning:
            self.memory.turning = squared

    def see(self, hull: HullVelocity | None, attitude: bool) -> None:
        """Take what the hull's model says, and whether there is an attitude.

        Without it nothing tells of a current, nor does the filter of a hull that rolls over: it takes that for water.
        """
        self.current.hull = hull if attitude else None
        if not (attitude and self.memory.upright):
            self.current.known = None
        if not attitude:
            self.turn(0.0, _UNSEEN, 0.0)

    def check(self, heard: Heard[Dvl], t: float, watch: SourceWatch, depth: float, angles: tuple[float, float]) -> bool:
        """Return whether the velocity of a ping may be used; what speaks against it is noted in `watch`.

        The bow is out of the water where depth, m, and the pitch of `angles` (heading and pitch, rad) say so: then the
        vehicle is soon slowed down.
        """
        params, memory = self._params, self.memory
        u, v, w, _, _ = heard.value
        most = params.speed_max
        if not (abs(u) <= most and abs(v) <= most and abs(w) <= most):
            if watch.refuse(t) >= _IMPOSSIBLE:
                watch.accuse(SourceFault.IMPOSSIBLE, t)
            return False
        gap, (psi, theta) = heard.t_valid - memory.t, angles
        told = self.current.judge(heard, psi, theta, watch.believed)
        if told is not SourceFault.NONE:
            watch.accuse(told, t)
        if self.way.still_wrong(heard.value, psi, self.current.hull):
            watch.accuse(SourceFault.CONTRADICTED, t)
        if not watch.believed:
            if memory.measured and watch.memory.fault is SourceFault.DRIFT and memory.driven > 0.0:
                memory.likely, memory.north, memory.east = memory.driven, 0.0, 0.0  # they have followed what drifted
            if memory.holds:
                off = min(abs(u - memory.likely), abs(u - self._carried(psi))) > params.speed
            else:
                off = watch.memory.fault in (SourceFault.DRIFT, SourceFault.STEP)  # nothing clears it now
            turning = math.sqrt(memory.turning) * self._lever
            if off or abs(v) > _ASIDE + turning or abs(w) > _HEAVE + turning:
                watch.accuse(SourceFault.STEP, t)
            memory.measured, memory.turning = False, 0.0
            return True
        self.way.clear()
        if not memory.measured or gap > _GAP:
            self._take(heard, True, psi)
            return True
        if depth < self._half * abs(math.sin(theta)):
            step = params.speed_step + _SURFACING * gap
        else:
            step = params.speed_step + _ACCELERATION * max(0.0, gap - 0.2)
        step += math.sqrt(memory.turning) * (self._lever + math.hypot(memory.u, memory.v, memory.w) * (gap + _LAG))
        if abs(u - memory.u) > step or abs(v - memory.v) > step or abs(w - memory.w) > step:
            if watch.refuse(t) >= _REAL:
                watch.accuse(SourceFault.STEP, t)
            return False
        self._take(heard, False, psi)
        either = memory.likely, self._carried(psi), 0.0
        least, most = min(either) - params.speed, max(either) + params.speed
        if memory.holds and not least <= u <= most:
            watch.accuse(SourceFault.DRIFT, t)  # between 0 and likely the hull may be held up, or the thrust lost
        return True

    def _carried(self, psi: float) -> float:
        """Return the speed that thrust, drag and the current make under this heading, rad, m/s; NaN: not known."""
        memory = self.memory
        return memory.driven + memory.north * math.cos(psi) + memory.east * math.sin(psi)

    def _take(self, heard: Heard[Dvl], first: bool, psi: float) -> None:
        """Take a ping under this heading, rad."""
        memory, hull = self.memory, self.current.hull
        u, v, w, _, _ = heard.value
        share = min(1.0, (heard.t_valid - memory.t) / _FOLLOW)
        c, s = math.cos(psi), math.sin(psi)
        ahead, aside = u - memory.driven, v if hull is None else v - hull.v
        north, east = ahead * c - aside * s, ahead * s + aside * c
        if first or not memory.holds:
            memory.likely = u
        else:
            memory.likely += (u - memory.likely) * share
        if first or not memory.holds or memory.north != memory.north:
            memory.north, memory.east = north, east
        else:
            memory.north += (north - memory.north) * share
            memory.east += (east - memory.east) * share
        memory.t, memory.u, memory.v, memory.w, memory.measured = heard.t_valid, u, v, w, True
        memory.turning = 0.0

    def freeze(self) -> VelocityCheckMemory:
        """Return the whole memory."""
        memory = copy.copy(self.memory)
        memory.current, memory.way = self.current.freeze(), self.way.freeze()
        return memory

    def thaw(self, memory: VelocityCheckMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self.memory = copy.copy(memory)
        self.current.thaw(memory.current)
        self.way.thaw(memory.way)
