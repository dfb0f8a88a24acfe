"""Position: dead reckoning from fix to fix, with an error that is honest about where it comes from.

Two kinds of error are kept apart. What is new in every ping adds up as a *walk* (variance, m^2). What stays the same,
a heading that is off, a DVL scale or bias, a velocity that is only guessed, adds up as a *drift* (1 sigma, m). So
position_std^2 = walk + drift^2; like the fix's 2 std^2 it is the variance of both axes together (DRMS squared).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.estimation.freshness import is_fresh
from firmware_py.marine import EDDY_TIME, Origin, geodetic_to_local
from firmware_py.params import param
from firmware_py.records.sensing import Fix, Heard


@dataclass(frozen=True)
class PositionParams:
    """Where the error of dead reckoning comes from, and which fixes to believe."""

    std_start: float = param(
        100.0, unit="m", low=0.1, high=1e5, doc="1 sigma of the position before any fix.", mav="STD0"
    )
    heading_std: float = param(
        1.0, unit="deg", low=0.0, high=20.0, doc="1 sigma of what the heading is off for long.", mav="HDG_STD"
    )
    scale_std: float = param(0.5, unit="%", low=0.0, high=20.0, doc="1 sigma of the DVL's scale.", mav="SCALE")
    bias_std: float = param(
        0.002, unit="m/s", low=0.0, high=0.5, doc="1 sigma of the DVL's bias, along each axis.", mav="BIAS"
    )
    fix_depth: float = param(1.0, unit="m", low=0.0, high=10.0, doc="No fix is believed deeper than this.", mav="FIX_Z")
    fix_std_max: float = param(
        30.0, unit="m", low=0.1, high=1000.0, doc="No fix of a worse 1 sigma is believed.", mav="FIX_STD"
    )
    fix_range: float = param(
        2e4, unit="m", low=100.0, high=1e5, doc="No fix farther from the origin is believed.", mav="FIX_RNG"
    )
    fix_resets: int = param(
        3,
        low=1,
        high=100,
        doc="So many fixes that agree put a position right that they contradict.",
        mav="FIX_N",
    )
    fix_bias_std: float = param(
        0.5, unit="m", low=0.0, high=10.0, doc="What averaging fixes cannot take away.", mav="FIX_BIAS"
    )


_CARRIED = math.radians(5.0)
"""1 sigma of a heading that gyros carry, rad: their bias over ten minutes, and what was off when it was noticed."""
OUTLIER_SIGMAS = 5.0
"""A fix so many sigmas away is not explained by chance."""
_AVERAGED, _CHANCE = 15, 3.0
"""Over so many fixes is averaged what they leave the position by: noise cancels, a wrong velocity stays. So many sigmas
of that are no chance: the position is off by as much."""
_RUN = 10.0
"""Fixes further apart than this, s, are no run: what moved the vehicle in between is another thing."""
_CARRIED_SPEED = 3.0
"""Faster than this no vehicle is carried at the surface, m/s."""
_KEPT = 40
"""By what so many fixes have moved the position is kept,"""
_KEPT_APART = 0.9
"""of those that follow each other sooner, s, of one."""
_ONSET = 0.5
"""Nobody knows which part of what is taken back was right: 1 sigma, its share."""


class Moved(NamedTuple):
    """By what fixes up to one that was true at t, s, have moved the position in all, north and east, m."""

    t: float
    x: float
    y: float


class PositionMemory(NamedTuple):
    """North and east (m), the two kinds of error, and the time of validity of the last fix.

    `refused` is how many fixes in a row contradicted the position and agreed with each other; the last one was `off_x`
    north and `off_y` east of it, m. `jump` is by how much such fixes put the position right in this tick, m. Fixes
    leave it by `left_x` and `left_y`, in sigmas, on the average of some. Where chance does not explain that, they
    move it by `astray` a second, m/s: by so much the velocity is off, and `pinged` whether pings told it. `doubt` is
    what the position may be off by beside, m: fixes or DVL are wrong, and nothing tells which. `moved` is by what the
    last fixes have moved it.
    """

    x: float
    y: float
    walk: float
    drift: float
    t_fix: float
    refused: int = 0
    off_x: float = 0.0
    off_y: float = 0.0
    jump: float = 0.0
    left_x: float = 0.0
    left_y: float = 0.0
    astray: float = 0.0
    pinged: bool = True
    doubt: float = 0.0
    moved: tuple[Moved, ...] = ()


def start(params: PositionParams) -> PositionMemory:
    """The memory of a vehicle that knows no more than that it is near the origin."""
    return PositionMemory(0.0, 0.0, params.std_start**2, 0.0, -math.inf)


def drift_rate(
    params: PositionParams, speed: float, heading_ok: bool, carried: bool = False, velocity_std: float = 0.0
) -> float:
    """Growth of the drift, m/s, at a speed over the bottom, m/s; a lost heading may be off by a radian.

    `carried` is whether gyros alone carry the heading; `velocity_std` what the velocity is off by for long, 1 sigma,
    m/s, where it is more than the DVL's bias.
    """
    heading = math.hypot(params.heading_std, _CARRIED if carried else 0.0) if heading_ok else 1.0
    return speed * math.hypot(heading, params.scale_std) + math.sqrt(2.0) * max(params.bias_std, velocity_std)


def wander_rate(turbulence: float) -> float:
    """Growth of the walk, m^2/s, where eddies of an intensity, m/s, carry the vehicle unseen."""
    return 4.0 * EDDY_TIME * turbulence * turbulence


def go_by_pings(memory: PositionMemory) -> PositionMemory:
    """Return the memory now that pings tell the velocity: what one without them was off by says nothing of theirs.

    What pings were off by, by a wrong heading for one, is kept while they are silent and when they come back.
    """
    return memory if memory.pinged else memory._replace(left_x=0.0, left_y=0.0, astray=0.0, pinged=True)


def take_fix(
    params: PositionParams,
    memory: PositionMemory,
    heard: Heard[Fix],
    t: float,
    origin: Origin,
    velocity: tuple[float, float],
    pinged: bool = True,
) -> PositionMemory:
    """Take a fix in by its scalar Kalman gain, moved from its time of validity to t with `velocity` (m/s, NED).

    `pinged` is whether pings tell that velocity.

    A fix more than OUTLIER_SIGMAS away is refused. `fix_resets` of them in a row that agree with each other, or the
    first of a run, show that the vehicle was carried, or the estimate wrong: that fix is the position then. What fixes
    leave the position by on the average, beyond chance, it is off by, and the velocity by what they move it then.
    """
    place = _place(params, heard.value, origin) if is_fresh(heard, memory.t_fix, t) else None
    if place is None:
        return memory
    x, y, std = *place, heard.value.std
    age = t - heard.t_valid
    dx, dy = x + velocity[0] * age - memory.x, y + velocity[1] * age - memory.y
    variance, off = memory.walk + memory.drift**2, dx * dx + dy * dy
    jump = 0.0
    beyond = off > OUTLIER_SIGMAS**2 * (variance + 2.0 * std**2)
    if beyond and memory.t_fix > -math.inf:
        near = OUTLIER_SIGMAS * 2.0 * std + _CARRIED_SPEED * (heard.t_valid - memory.t_fix)
        agrees = memory.refused > 0 and math.hypot(dx - memory.off_x, dy - memory.off_y) <= near
        refused = memory.refused + 1 if agrees else 1
        if refused < params.fix_resets:
            return memory._replace(t_fix=heard.t_valid, refused=refused, off_x=dx, off_y=dy)
    if beyond:
        variance, jump = off, math.sqrt(off)
    usual = math.sqrt(variance + 2.0 * std**2)
    left_x, left_y, astray = _left(memory, heard.t_valid, beyond, pinged, dx / usual, dy / usual)
    left = math.hypot(left_x, left_y)
    surprises = left > _CHANCE / math.sqrt(2 * _AVERAGED - 1)
    if surprises:
        variance = max(variance, (left * usual) ** 2)
    gain = variance / (variance + 2.0 * std**2)
    if surprises:
        astray = gain * left * usual / (heard.t_valid - memory.t_fix)
    return PositionMemory(
        memory.x + gain * dx,
        memory.y + gain * dy,
        max((1.0 - gain) * variance, params.fix_bias_std**2),
        0.0,
        heard.t_valid,
        jump=jump,
        left_x=left_x,
        left_y=left_y,
        astray=astray,
        pinged=pinged,
        doubt=memory.doubt,
        moved=_moved(memory.moved, heard.t_valid, gain * dx, gain * dy),
    )


def _place(params: PositionParams, fix: Fix, origin: Origin) -> tuple[float, float] | None:
    """Return where a fix is, north and east of the origin, m; None if it can be no place of this vehicle."""
    latitude, longitude, std = fix
    if not (abs(latitude) <= math.pi / 2 and abs(longitude) <= math.tau and 0.0 < std <= params.fix_std_max):
        return None
    x, y = geodetic_to_local(origin, latitude, longitude)
    return (x, y) if math.hypot(x, y) <= params.fix_range else None


def _left(
    memory: PositionMemory, t: float, beyond: bool, pinged: bool, off_x: float, off_y: float
) -> tuple[float, float, float]:
    """Return by what fixes up to one of t, s, leave the position, in sigmas, and by how much the velocity is off, m/s.

    That fix is off by `off_x` and `off_y`, in sigmas, or `beyond` what counts as chance.
    """
    x, y, astray = memory.left_x, memory.left_y, memory.astray * (1.0 - 1.0 / _AVERAGED)
    if beyond or t - memory.t_fix > _RUN or pinged is not memory.pinged:  # it is put right, or of another velocity
        x = y = astray = 0.0
    return (x, y, astray) if beyond else (x + (off_x - x) / _AVERAGED, y + (off_y - y) / _AVERAGED, astray)


def take_back(params: PositionParams, memory: PositionMemory, since: float) -> PositionMemory:
    """Take back what fixes that were true after `since`, s, have moved the position by."""
    moved = memory.moved
    if not moved:
        return memory
    last, then = moved[-1], next((before for before in reversed(moved) if before.t <= since), moved[0])
    x, y = last.x - then.x, last.y - then.y
    walk = memory.walk + _ONSET**2 * (x * x + y * y) + 4.0 * params.fix_bias_std**2
    return memory._replace(x=memory.x - x, y=memory.y - y, walk=walk, left_x=0.0, left_y=0.0, astray=0.0, moved=())


def _moved(moved: tuple[Moved, ...], t: float, dx: float, dy: float) -> tuple[Moved, ...]:
    """Return by what fixes have moved the position, now that one of t, s, has moved it by dx and dy more, m."""
    last = moved[-1] if moved else Moved(t, 0.0, 0.0)
    now = Moved(t, last.x + dx, last.y + dy)
    kept = moved[:-1] if len(moved) > 1 and last.t - moved[-2].t < _KEPT_APART else moved
    return (*kept[1 - _KEPT :], now)


def std(memory: PositionMemory) -> float:
    """1 sigma of (x, y) together, m."""
    return math.sqrt(memory.walk + memory.drift**2 + memory.doubt**2)
