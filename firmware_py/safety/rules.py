"""What may end a mode, in order of severity: one table, read from the top.

Why the table says what it says:

- Surfacing is powered, for the vehicle is neutral (W = B): stopped, it stays where it is. So SURFACE is the answer to
  everything in which it can still be steered, and DISARMED is only for the surface, or when there is no hope.
- Without attitude no law can steer. The gate then centres the fins and stops the propeller by itself; the mode goes to
  SURFACE, so that an AHRS that comes back brings the vehicle up. One that does not come back ends in DISARMED: a
  propeller must not start minutes later, perhaps on deck.
- Without depth the vehicle still climbs: the estimate of depth goes on by dead reckoning, good enough to come up. That
  it came up is then told by a position fix, which is not to be had under water.
- Beyond the fence it surfaces too: the way back could lead through what the fence is there for. Its depth is
  `depth_max`.
- Sticks that fall silent are no rule: MANUAL bounds their age and centres them, and a neutral vehicle waits.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.params import param, table
from firmware_py.records.order import Mode
from firmware_py.safety.gate import GateParams


@dataclass(frozen=True)
class SafetyParams:
    """The limits of the rules; each `*_time` is how long its condition must hold without a break."""

    attitude_timeout: float = param(
        0.5, unit="s", low=0.05, high=5.0, doc="Older attitude is lost: surface.", mav="ATT_TIMEOUT"
    )
    attitude_dead_time: float = param(
        30.0, unit="s", low=1.0, high=600.0, doc="Attitude lost for so long: disarm.", mav="ATT_DEAD"
    )
    depth_timeout: float = param(
        1.0, unit="s", low=0.1, high=10.0, doc="Older depth is lost: surface.", mav="DEP_TIMEOUT"
    )
    leak_time: float = param(1.0, unit="s", low=0.0, high=60.0, doc="A leak for so long: surface.", mav="LEAK_TIME")
    battery_min: float = param(
        10.0, unit="%", low=0.0, high=90.0, doc="Less battery than this: surface.", mav="BATT_MIN"
    )
    battery_arm: float = param(
        20.0, unit="%", low=0.0, high=100.0, doc="Arming needs as much, and needs to know; 0 off.", mav="BATT_ARM"
    )
    battery_time: float = param(
        5.0, unit="s", low=0.0, high=60.0, doc="A low battery for so long: surface.", mav="BATT_TIME"
    )
    depth_max: float = param(
        30.0, unit="m", low=1.0, high=6000.0, doc="The fence's depth; deeper: surface.", mav="DEPTH_MAX"
    )
    altitude_min: float = param(
        2.0, unit="m", low=0.0, high=100.0, doc="Nearer to the bottom than this: surface.", mav="ALT_MIN"
    )
    altitude_time: float = param(
        0.5, unit="s", low=0.0, high=10.0, doc="Too near to the bottom for so long: surface.", mav="ALT_TIME"
    )
    late_max: int = param(
        10, low=0, high=1000, doc="More cycles of the last second late than this: surface.", mav="LATE_MAX"
    )
    fence_time: float = param(
        1.0, unit="s", low=0.0, high=60.0, doc="Beyond the fence for so long: surface.", mav="FENCE_TIME"
    )
    surface_depth: float = param(
        0.5, unit="m", low=0.0, high=5.0, doc="Less deep than this is the surface.", mav="SURF_DEPTH"
    )
    surface_time: float = param(
        2.0, unit="s", low=0.0, high=60.0, doc="At the surface for so long: surfacing is done.", mav="SURF_TIME"
    )
    fix_timeout: float = param(
        2.0, unit="s", low=0.2, high=60.0, doc="An older position fix does not tell of the surface.", mav="FIX_TIMEOUT"
    )
    tilt_max: float = param(
        45.0, unit="deg", low=5.0, high=90.0, doc="Arming needs less roll and pitch than this.", mav="TILT_MAX"
    )
    fin_timeout: float = param(
        1.0, unit="s", low=0.1, high=10.0, doc="Arming needs every fin heard within; see fin_needed.", mav="FIN_TIMEOUT"
    )
    fin_needed: bool = param(True, doc="False for fins that report no angle.", mav="FIN_NEEDED")
    gate: GateParams = table(GateParams, mav="GATE_")


class Conditions(NamedTuple):
    """What the rules look at, in one tick (m, rad, charge in [0, 1]; NaN is unknown and breaks no rule)."""

    wanted: Mode
    """The mode in force, or the one ordered in this tick."""
    attitude_ok: bool
    depth_ok: bool
    depth: float
    altitude: float
    fix_heard: bool
    leak: bool
    charge: float
    late: int
    mission_done: bool
    """Or, on the way back, that there is nothing left of it."""
    tilt: float
    fins_heard: bool
    breach: str = ""
    """What is wrong with the place, by the fence."""

    @property
    def battery(self) -> str:
        """Its charge, in words."""
        return "battery not heard" if math.isnan(self.charge) else f"battery at {self.charge:.0%}"


class Rule(NamedTuple):
    """While `holds`, for `time` (the name of a parameter; "" at once), the mode is `mode` or a safer one."""

    name: str
    holds: Callable[[Conditions, SafetyParams], bool]
    time: str
    mode: Mode
    because: str
    """A sentence for people, formatted with the conditions `c` and the limits `p`."""


def _at_surface(c: Conditions, p: SafetyParams) -> bool:
    return c.wanted is Mode.SURFACE and (c.depth < p.surface_depth if c.depth_ok else c.fix_heard)


DISARMED, SURFACE = Mode.DISARMED, Mode.SURFACE

# fmt: off
RULES: tuple[Rule, ...] = (
    Rule("attitude dead", lambda c, _: not c.attitude_ok, "attitude_dead_time", DISARMED,
         "attitude lost for {p.attitude_dead_time:g} s"),
    Rule("surfaced",      _at_surface, "surface_time", DISARMED,
         "surfaced"),
    Rule("attitude lost", lambda c, _: not c.attitude_ok, "", SURFACE,
         "attitude not heard for {p.attitude_timeout:g} s"),
    Rule("depth lost",    lambda c, _: not c.depth_ok, "", SURFACE,
         "depth not heard for {p.depth_timeout:g} s"),
    Rule("leak",          lambda c, _: c.leak, "leak_time", SURFACE,
         "water in the hull"),
    Rule("battery",       lambda c, p: c.charge < p.battery_min, "battery_time", SURFACE,
         "{c.battery}, less than {p.battery_min:.0%}"),
    Rule("depth limit",   lambda c, p: c.depth > p.depth_max, "", SURFACE,
         "depth {c.depth:.2f} m, limit {p.depth_max:g} m"),
    Rule("altitude",      lambda c, p: c.altitude < p.altitude_min, "altitude_time", SURFACE,
         "altitude {c.altitude:.2f} m, floor {p.altitude_min:g} m"),
    Rule("fence",         lambda c, _: c.breach != "", "fence_time", SURFACE,
         "{c.breach}"),
    Rule("late cycles",   lambda c, p: c.late > p.late_max, "", SURFACE,
         "{c.late} cycles late within a second, limit {p.late_max}"),
    Rule("mission end",   lambda c, _: c.mission_done and c.wanted is Mode.MISSION, "", SURFACE,
         "mission done"),
    Rule("returned",      lambda c, _: c.mission_done and c.wanted is Mode.RETURN, "", SURFACE,
         "return done"),
)

ARMING: tuple[Rule, ...] = (
    Rule("attitude", lambda c, _: not c.attitude_ok, "", DISARMED,
         "attitude not heard for {p.attitude_timeout:g} s"),
    Rule("fins",     lambda c, p: p.fin_needed and not c.fins_heard, "", DISARMED,
         "not every fin heard within {p.fin_timeout:g} s"),
    Rule("tilt",     lambda c, p: c.tilt > p.tilt_max, "", DISARMED,
         "rolled or pitched by {c.tilt:.2f} rad, limit {p.tilt_max:.2f} rad"),
    Rule("charge",   lambda c, p: c.wanted is not SURFACE and p.battery_arm > 0.0 and not c.charge >= p.battery_arm,
         "", DISARMED, "{c.battery}, needs {p.battery_arm:.0%}"),
)
"""What arming asks beyond the rules; to come up from where it lies, a vehicle may be armed with what charge is left."""
# fmt: on

_SAFETY = {Mode.DISARMED: 0, Mode.SURFACE: 1}
"""All other modes ask for the same."""


def safer(a: Mode, b: Mode) -> bool:
    """True if mode a asks strictly less of the vehicle than mode b."""
    return _SAFETY.get(a, 2) < _SAFETY.get(b, 2)
