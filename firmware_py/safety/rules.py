"""What may end a mode (RULES) and what arming needs beyond that (ARMING).

Why the table says what it says:

- Surfacing is powered, for the vehicle is neutral (W = B): stopped, it stays where it is. So SURFACE is the answer to
  everything in which it can still be steered, and a rule leads to DISARMED only at the surface.
- Without attitude no law can steer, but the vehicle still climbs under fixed stern planes (`ascent`).
- Without depth it climbs too: the estimate of depth goes on by dead reckoning, good enough to come up. Then a position
  fix, which is not to be had under water, shows that it came up.
- Beyond the fence it surfaces too: the way back could lead through what the fence is there for. Its depth is
  `depth_max`. One that lies beyond the fence may be armed in MANUAL, and steered back.
- Without propeller a vehicle may still coast up, or float: the drop weight goes when it does not.
- No rule acts on one sample: a condition must hold for a time, or is itself one.
- Above a bottom that it no longer sees it surfaces: every depth that it could hold runs aground where that rises.
- A mission is flown without a station; every other mode has somebody who watches it, and is not to go on without.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from firmware_py.records.event import Cause
from firmware_py.records.fence import WITHIN
from firmware_py.records.health import HEADING_FAULTS, SourceFault, SourceHealth, SourceState
from firmware_py.records.order import Mode
from firmware_py.safety.action import MODE_OF, Action, safer
from firmware_py.safety.conditions import Conditions, Faulty
from firmware_py.safety.look_ahead import altitude_reached, depth_reached, too_low
from firmware_py.safety.safety_params import SafetyParams

__all__ = ["ARMING", "RULES", "Conditions", "Reason", "Rule", "SafetyParams", "safer", "surely_under_water"]

_Numbers = Callable[[Conditions, SafetyParams], tuple[float, ...]]


class Reason(NamedTuple):
    """Why something is done: a cause with its numbers and names."""

    cause: Cause
    numbers: tuple[float, ...] = ()
    names: tuple[str, ...] = ()


class Rule(NamedTuple):
    """While `holds`, for `time` (the name of a parameter; "" at once), the answer holds.

    Attributes:
        cause: what an event says of it.
        holds: the condition.
        time: how long it must hold without a break.
        answer: the name of the parameter that says what is done, or what is; or a mode, in which the present one simply
            ends.
        numbers: of the cause, for its event.
        at_arming: whether a vehicle is not armed while the condition holds.
        faulty: the actuator that the cause is about, if it is about one.
        drops: whether the drop weight goes now, if that is what is done.
        while_disarmed: whether it counts of a disarmed vehicle too.
    """

    cause: Cause
    holds: Callable[[Conditions, SafetyParams], bool]
    time: str
    answer: str | Action | Mode
    numbers: _Numbers = lambda *_: ()
    at_arming: bool = True
    faulty: Callable[[Conditions], Faulty | None] = lambda _: None
    drops: Callable[[Conditions], bool] = lambda _: True
    while_disarmed: bool = False

    def reason(self, c: Conditions, params: SafetyParams) -> Reason:
        """Return why it answers, while it holds."""
        faulty = self.faulty(c)
        if faulty is not None:
            return Reason(self.cause, (float(faulty.fault), *self.numbers(c, params)), (faulty.name,))
        return Reason(self.cause, self.numbers(c, params))


DISARMED, SURFACE = Mode.DISARMED, Mode.SURFACE
_GOOD, _SUSPECT = SourceState.GOOD, SourceState.SUSPECT
_TILT_HOLDS = (SourceFault.OUTLIERS, SourceFault.UNDECIDED, *HEADING_FAULTS)
_SWING, _STEEP = 2.0 / 3.0, math.radians(30.0)
"""With a slow stern plane it cannot stop a swing beyond this share of `pitch_max`, or this, rad: the greater counts."""
_NEARER = 5.0
"""Without depth and fix, a bottom nearer by so much than where a fix was last heard, m, means that it sinks."""
_FLOWN = (Mode.HOLD, Mode.MISSION, Mode.LOITER, Mode.GUIDED, Mode.RETURN)
"""Modes in which a depth is flown."""


def _carried_on(health: SourceHealth) -> bool:
    """Return whether gyros carry on the tilt of an AHRS; outliers are left out one by one, enough values are left."""
    return health.state is _SUSPECT and health.fault not in _TILT_HOLDS


def _unseen(health: SourceHealth) -> bool:
    return health.state is not _GOOD and health.fault is not SourceFault.UNDECIDED  # then the nearer bottom holds


def _blind(c: Conditions) -> bool:
    return _unseen(c.sensors.altitude) and _unseen(c.sensors.dvl)


def _unchecked(c: Conditions, p: SafetyParams) -> bool:
    return c.depth_ok and c.altitude != c.altitude and c.depth > p.submerged_depth


def _terrain_lost(c: Conditions, _: SafetyParams) -> bool:
    """Return whether the bottom that tells the depth is not seen; two sound sensors find it out of reach, and far."""
    out_of_reach = c.sensors.altitude.state is _GOOD and c.sensors.dvl.state is _GOOD
    return c.above and c.altitude != c.altitude and not out_of_reach


def _off_depth(c: Conditions, p: SafetyParams) -> bool:
    return c.wanted in _FLOWN and abs(c.depth - c.wanted_depth) > p.depth_error_max


def _pitch_limit(c: Conditions, p: SafetyParams) -> float:
    return min(p.pitch_max, max(_SWING * p.pitch_max, _STEEP)) if c.faults.slow else p.pitch_max


def _surfacing_long(c: Conditions, p: SafetyParams) -> bool:
    return c.surfacing >= p.surfacing_time and c.surfacing % p.surfacing_time < 1.0  # and again after as long


def _depth_good(c: Conditions) -> bool:
    return c.depth_ok and c.sensors.pressure.state is _GOOD


def surely_under_water(c: Conditions, p: SafetyParams) -> bool:
    """Return whether a good depth says so, and no fix says otherwise: one of air would, but not a frozen one."""
    return _depth_good(c) and c.depth > p.submerged_depth and not _speaks_of_air(c)


def _speaks_of_air(c: Conditions) -> bool:
    """Return whether a receiver hears satellites, be they in doubt; one that repeats its last fix may be anywhere."""
    fix = c.sensors.fix
    return c.fix_heard or (fix.state is _SUSPECT and fix.fault is not SourceFault.FROZEN)


def _sunk(c: Conditions, p: SafetyParams) -> bool:
    """Return whether a vehicle that came up sinks: its depth says so, or for want of one a bottom that is nearer."""
    untold = not (_depth_good(c) or c.fix_heard)
    return c.watched and (surely_under_water(c, p) or (untold and c.sunk_by > _NEARER))


def _restarted(c: Conditions, p: SafetyParams) -> bool:
    unknown = not c.depth_ok and not _speaks_of_air(c)
    still_there = unknown and c.start.kept.still_under_water(p.submerged_depth)
    return c.start.was_armed and (surely_under_water(c, p) or still_there)


def _begun_under_water(c: Conditions, p: SafetyParams) -> bool:
    if not c.start.open or _restarted(c, p):
        return False
    return c.depth > p.submerged_depth if c.depth_ok else c.start.was_armed


def _depth(c: Conditions) -> float:
    return c.depth if c.depth_ok else math.nan


def _actuator_fault(cause: Cause, faulty: Callable[[Conditions], Faulty | None], action: str) -> Rule:
    """Return the rule of one kind of faults."""
    return Rule(cause, lambda c, _: faulty(c) is not None, "actuator_time", action, faulty=faulty)


def _station_lost(mode: Mode, time: str, action: str) -> Rule:
    """Return the rule of one mode on the silence of stations."""
    return Rule(
        Cause.STATION_LOST,
        lambda c, p: c.wanted is mode and c.station_silence > getattr(p.station, time),
        "",
        f"station.{action}",
        lambda _, p: (getattr(p.station, time),),
        at_arming=False,
    )


# fmt: off
RULES: tuple[Rule, ...] = (
    Rule(Cause.SURFACED,         lambda c, _: c.wanted is SURFACE and c.surfaced, "surface_time", DISARMED),
    # The vehicle cannot be steered as it should.
    Rule(Cause.ATTITUDE_LOST,    lambda c, _: not c.attitude_ok, "", "attitude_action",
         lambda c, p: (p.attitude_timeout, float(c.attitude_fault))),
    Rule(Cause.DEPTH_LOST,       lambda c, _: not c.depth_ok, "", "depth_action",
         lambda c, p: (p.depth_timeout, float(c.depth_fault))),
    _actuator_fault(Cause.PROPELLER_FAULT, lambda c: c.faults.propeller, "propeller_action")._replace(
         drops=lambda c: not c.climbs),
    _actuator_fault(Cause.PROPELLER_FAULT, lambda c: c.faults.runaway, "runaway_action"),
    _actuator_fault(Cause.PLANE_FAULT,     lambda c: c.faults.plane, "plane_action"),
    _actuator_fault(Cause.RUDDER_FAULT,    lambda c: c.faults.rudder, "rudder_action"),
    _actuator_fault(Cause.DAMAGED,         lambda c: c.faults.damaged, "damage_action")._replace(
         numbers=lambda c, _: (c.left.dive_left, c.left.turn_left)),
    Rule(Cause.BUS_SILENT,       lambda c, _: c.bus_silent, "", "bus_action",
         lambda _, p: (p.bus_time,)),
    # The hull and its energy.
    Rule(Cause.LEAK,             lambda c, _: c.leak, "leak_time", "leak_action"),
    Rule(Cause.LEAK_SILENT,      lambda c, _: c.leak_silent, "leak_silent_time", "leak_silent_action",
         lambda _, p: (p.leak_silent_time,)),
    Rule(Cause.BATTERY_LOW,      lambda c, p: c.charge < p.battery_min, "battery_time", "battery_action",
         lambda c, p: (c.charge, p.battery_min)),
    Rule(Cause.BATTERY_WARNING,  lambda c, p: c.charge < p.battery_warn, "battery_time", "battery_warn_action",
         lambda c, p: (c.charge, p.battery_warn)),
    Rule(Cause.BATTERY_SILENT,   lambda c, _: c.charge_silent, "battery_silent_time", "battery_silent_action",
         lambda _, p: (p.battery_silent_time,)),
    Rule(Cause.ENERGY,           lambda c, _: c.charge < c.charge_home, "battery_time", "energy_action",
         lambda c, _: (c.charge, c.charge_home), at_arming=False),
    # Where it is, and how it lies there.
    Rule(Cause.DEPTH_LIMIT,      lambda c, p: depth_reached(c, p) > p.depth_max, "depth_max_time", "depth_max_action",
         lambda c, p: (depth_reached(c, p), p.depth_max)),
    Rule(Cause.ALTITUDE_LIMIT,   too_low, "altitude_time", "altitude_action",
         lambda c, p: (altitude_reached(c, p), p.altitude_min)),
    Rule(Cause.FENCE,            lambda c, _: c.breach != WITHIN and not c.returning, "fence_time", "fence_action",
         lambda c, _: (float(c.breach),)),
    Rule(Cause.PITCH,            lambda c, p: c.pitch > _pitch_limit(c, p), "pitch_time", "pitch_action",
         lambda c, p: (c.pitch, _pitch_limit(c, p))),
    Rule(Cause.ROLL,             lambda c, p: c.roll > p.roll_max, "roll_time", "roll_action",
         lambda c, p: (c.roll, p.roll_max)),
    Rule(Cause.DEPTH_ERROR,      _off_depth, "depth_error_time", "depth_error_action",
         lambda c, p: (c.depth, c.wanted_depth, p.depth_error_max), at_arming=False),
    Rule(Cause.NO_WAY_MADE,      lambda c, _: c.leg_left > 0.0, "", "leg_action",
         lambda c, p: (c.leg_left, p.leg_time), at_arming=False),
    Rule(Cause.SURFACING_LONG,   _surfacing_long, "", "surfacing_action",
         lambda c, _: (c.surfacing,), at_arming=False),
    # What sensors and actuators are worth.
    Rule(Cause.AHRS_SUSPECT,     lambda c, _: c.attitude_ok and _carried_on(c.sensors.ahrs),
         "sensor_time", "ahrs_action",
         lambda c, _: (float(c.sensors.ahrs.fault),)),
    Rule(Cause.HEADING_SUSPECT,  lambda c, _: c.sensors.ahrs.fault in HEADING_FAULTS,
         "sensor_time", "heading_action"),
    Rule(Cause.BOTTOM_UNSEEN,    lambda c, _: _blind(c), "sensor_time", "bottom_action"),
    Rule(Cause.TERRAIN_LOST,     _terrain_lost, "sensor_time", "terrain_action", at_arming=False),
    Rule(Cause.DEPTH_UNCHECKED,  _unchecked, "unchecked_time", "unchecked_action",
         lambda _, p: (p.unchecked_time,), at_arming=False),
    Rule(Cause.DVL_BAD,          lambda c, _: c.sensors.dvl.state is not _GOOD, "sensor_time", "dvl_action",
         lambda c, _: (float(c.sensors.dvl.fault),)),
    Rule(Cause.ALTIMETER_BAD,    lambda c, _: c.sensors.altitude.state is not _GOOD, "sensor_time", "altimeter_action",
         lambda c, _: (float(c.sensors.altitude.fault),)),
    _actuator_fault(Cause.ACTUATOR_SILENT, lambda c: c.faults.silent, "actuator_silent_action"),
    _actuator_fault(Cause.ACTUATOR_WORN,   lambda c: c.faults.worn, "actuator_worn_action"),
    Rule(Cause.LATE_CYCLES,      lambda c, p: c.late > p.late_max, "", "late_action",
         lambda c, p: (float(c.late), float(p.late_max))),
    # Who watches it.
    Rule(Cause.STICKS_LOST,
         lambda c, p: c.wanted is Mode.MANUAL and c.depth > p.submerged_depth and c.sticks_silence > 1.0,
         "station.sticks_time", "station.sticks_action",
         lambda _, p: (p.station.sticks_time,), at_arming=False),
    _station_lost(Mode.MANUAL,  "manual_time",  "manual_action"),
    _station_lost(Mode.HOLD,    "hold_time",    "hold_action"),
    _station_lost(Mode.LOITER,  "loiter_time",  "loiter_action"),
    _station_lost(Mode.GUIDED,  "guided_time",  "guided_action"),
    _station_lost(Mode.MISSION, "mission_time", "mission_action"),
    # What brings up a vehicle that is disarmed.
    Rule(Cause.SUNK,             _sunk, "sunk_time", "sunk_action",
         lambda c, _: (_depth(c),), at_arming=False, while_disarmed=True,
         drops=lambda c: c.leak or c.brought_up),  # a sound one has the power to come up once more
    Rule(Cause.RESTARTED,        _restarted, "restart_time", "restart_action",
         lambda c, _: (_depth(c), float(c.start.kept.mode), c.start.kept.ago), at_arming=False, while_disarmed=True),
    Rule(Cause.STARTED_UNDER_WATER, _begun_under_water, "restart_time", "start_action",
         lambda c, _: (_depth(c),), at_arming=False, while_disarmed=True),
    Rule(Cause.LEFT_UNDER_WATER, lambda c, p: c.done_with and surely_under_water(c, p), "sunk_time", Action.WARN,
         lambda c, _: (c.depth,), at_arming=False, while_disarmed=True),
    # What was ordered is done.
    Rule(Cause.MISSION_DONE,     lambda c, _: c.mission_done and c.wanted is Mode.MISSION, "", SURFACE),
    Rule(Cause.RETURN_DONE,      lambda c, _: c.mission_done and c.wanted is Mode.RETURN, "", SURFACE),
)
"""Of several that hold, the safest answer is the mode; of equally safe ones, the first is the reason that is told."""

ARMING: tuple[Rule, ...] = (
    Rule(Cause.ATTITUDE_LOST,  lambda c, _: not c.attitude_ok, "", DISARMED,
         lambda c, p: (p.attitude_timeout, float(c.attitude_fault))),
    Rule(Cause.FINS_NOT_HEARD, lambda c, p: p.fin_needed and not c.fins_heard, "", DISARMED,
         lambda _, p: (p.fin_timeout,)),
    Rule(Cause.TILT,           lambda c, p: max(c.roll, c.pitch) > p.tilt_max, "", DISARMED,
         lambda c, p: (max(c.roll, c.pitch), p.tilt_max)),
    Rule(Cause.TERRAIN_LOST,
         lambda c, p: c.wanted is Mode.MISSION and c.mission_above and _blind(c) and p.terrain_action in MODE_OF,
         "", DISARMED),
    Rule(Cause.WEIGHT_GONE,
         lambda c, p: c.wanted is not SURFACE and p.weight_needed and c.weight_gone, "", DISARMED),
    Rule(Cause.CHARGE_NEEDED,
         lambda c, p: c.wanted is not SURFACE and p.battery_arm > 0.0 and not c.charge >= p.battery_arm, "", DISARMED,
         lambda c, p: (c.charge, p.battery_arm)),
)
"""What arming asks beyond the rules; to come up from where it lies, a vehicle may be armed with what charge is left,
and without a weight."""
# fmt: on
