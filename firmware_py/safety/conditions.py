"""What the rules look at in one tick."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.records.fence import WITHIN
from firmware_py.records.health import ALL_GOOD, ActuatorFault, SensorHealth, SourceFault
from firmware_py.records.manoeuvrability import UNLIMITED, Manoeuvrability
from firmware_py.records.order import Mode
from firmware_py.safety.start import OVER, Start


class Faulty(NamedTuple):
    """A fault, and the name of the actuator that has it."""

    fault: ActuatorFault
    name: str


class ActuatorFaults(NamedTuple):
    """The first actuator with a fault of each kind; None where there is none.

    `plane`, `rudder` and `propeller` are jammed or without force; `damaged` is a fin that is so, or weak, while the
    others still control the vehicle. `runaway` is the propeller too; `silent` and `worn` (slow, loose, a weak
    propeller) are any; `slow` is a plane.
    """

    plane: Faulty | None = None
    rudder: Faulty | None = None
    propeller: Faulty | None = None
    runaway: Faulty | None = None
    silent: Faulty | None = None
    worn: Faulty | None = None
    damaged: Faulty | None = None
    slow: Faulty | None = None


NO_FAULTS = ActuatorFaults()


class Conditions(NamedTuple):
    """What the rules look at, in one tick (m, rad, s, charge in [0, 1]; NaN is unknown and breaks no rule)."""

    wanted: Mode
    """The mode in force, or the one ordered in this tick."""
    attitude_ok: bool
    depth_ok: bool
    depth: float
    altitude: float
    z_dot: float
    fix_heard: bool
    leak: bool
    charge: float
    late: int
    mission_done: bool
    """Or, on the way back, that there is nothing left of it."""
    roll: float
    pitch: float
    fins_heard: bool
    breach: int = WITHIN
    """What is wrong with the place, as `Fence.breach_at` has it."""
    surfaced: bool = False
    """What tells of the surface does so; it means something in SURFACE alone."""
    climbs: bool = True
    """It gains height, or is given the time to, and is not about to pass a limit: the drop weight may wait."""
    steered: bool = False
    """It was in MANUAL a moment ago: its dive is one by hand."""
    returning: bool = False
    """Armed in MANUAL beyond the fence, to be steered back, and not yet within it."""
    charge_silent: bool = False
    """The charge was known before, and is not now."""
    leak_silent: bool = False
    bus_silent: bool = False
    wanted_depth: float = math.nan
    """The depth that is being flown."""
    above: bool = False
    """That depth is one above the bottom, and"""
    mission_above: bool = False
    """the mission has such depths."""
    leg_left: float = math.nan
    """Distance to the waypoint on a leg on which no way was made."""
    charge_home: float = math.nan
    """The charge that the way home needs, `battery_min` included."""
    surfacing: float = 0.0
    """For how long the mode has been SURFACE."""
    sensors: SensorHealth = ALL_GOOD
    attitude_fault: SourceFault = SourceFault.NONE
    """What is wrong with the AHRS while the attitude is lost, as far as it is known, and"""
    depth_fault: SourceFault = SourceFault.NONE
    """with the pressure sensor while the depth is."""
    faults: ActuatorFaults = NO_FAULTS
    station_silence: float = math.nan
    """Since when no station has been heard; NaN if none ever was."""
    sticks_silence: float = 0.0
    weight_gone: bool = False
    """The drop weight is released, in this run or in an earlier one, and no hardpoint says that it holds one."""
    watched: bool = False
    """It surfaced and disarmed itself, and nobody has armed or disarmed it since."""
    brought_up: bool = False
    """A failure brought it up when it surfaced last."""
    done_with: bool = False
    """It is disarmed, was armed in this run, and is not watched."""
    sunk_by: float = math.nan
    """By how much the bottom is nearer than when it was at the surface, or than where it came into sight after that."""
    left: Manoeuvrability = UNLIMITED
    """What the vehicle can still do, and"""
    slope: float = 0.0
    """how steeply it dives, rad."""
    rise: float = 0.0
    """How fast the bottom rises under it, m/s, and"""
    rise_slope: float = 0.0
    """how steeply, rad; 0 where it falls."""
    too_steep: float = 0.0
    """By how much faster it rises than the vehicle can climb at this speed, m/s; 0 where it does not."""
    while_it_stops: float = 0.0
    """How fast it rises in the mean until the way is off, m/s; 0 where SURFACE climbs away in place of stopping."""
    start: Start = OVER
    """How it began, while nobody has armed it since."""
