"""What may end a mode (RULES, in order of severity) and what arming needs beyond that (ARMING).

Why the table says what it says:

- Surfacing is powered, for the vehicle is neutral (W = B): stopped, it stays where it is. So SURFACE is the answer to
  everything in which it can still be steered, and DISARMED is only for the surface, or when there is no hope.
- Without attitude no law can steer. The gate then centres the fins and stops the propeller by itself; the mode goes to
  SURFACE, so that an AHRS that comes back brings the vehicle up. One that does not come back ends in DISARMED: a
  propeller must not start minutes later, perhaps on deck.
- Without depth the vehicle still climbs: the estimate of depth goes on by dead reckoning, good enough to come up. Then
  a position fix, which is not to be had under water, shows that it came up.
- Beyond the fence it surfaces too: the way back could lead through what the fence is there for. Its depth is
  `depth_max`.
- Sticks that fall silent are no rule: MANUAL bounds their age and centres them, and a neutral vehicle waits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.params import param, table
from firmware_py.records.event import Cause
from firmware_py.records.fence import WITHIN
from firmware_py.records.order import Mode
from firmware_py.safety.actuators.actuator_params import ActuatorParams
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
        2.0, unit="m", low=0.0, high=50.0, doc="Nearer to the bottom than this: surface.", mav="ALT_MIN"
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
        0.5, unit="m", low=0.1, high=5.0, doc="Less deep than this is the surface.", mav="SURF_DEPTH"
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
    actuators: ActuatorParams = table(ActuatorParams, mav="ACT_")


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
    breach: int = WITHIN
    """What is wrong with the place, as `Fence.breach_at` has it."""


class Rule(NamedTuple):
    """While `holds`, for `time` (the name of a parameter; "" at once), the mode is `mode` or a safer one."""

    cause: Cause
    holds: Callable[[Conditions, SafetyParams], bool]
    time: str
    mode: Mode
    numbers: Callable[[Conditions, SafetyParams], tuple[float, ...]] = lambda *_: ()
    """The numbers of the cause, for its event."""


def _at_surface(c: Conditions, p: SafetyParams) -> bool:
    return c.wanted is Mode.SURFACE and (c.depth < p.surface_depth if c.depth_ok else c.fix_heard)


DISARMED, SURFACE = Mode.DISARMED, Mode.SURFACE

# fmt: off
RULES: tuple[Rule, ...] = (
    Rule(Cause.ATTITUDE_DEAD,  lambda c, _: not c.attitude_ok, "attitude_dead_time", DISARMED,
         lambda _, p: (p.attitude_dead_time,)),
    Rule(Cause.SURFACED,       _at_surface, "surface_time", DISARMED),
    Rule(Cause.ATTITUDE_LOST,  lambda c, _: not c.attitude_ok, "", SURFACE,
         lambda _, p: (p.attitude_timeout,)),
    Rule(Cause.DEPTH_LOST,     lambda c, _: not c.depth_ok, "", SURFACE,
         lambda _, p: (p.depth_timeout,)),
    Rule(Cause.LEAK,           lambda c, _: c.leak, "leak_time", SURFACE),
    Rule(Cause.BATTERY_LOW,    lambda c, p: c.charge < p.battery_min, "battery_time", SURFACE,
         lambda c, p: (c.charge, p.battery_min)),
    Rule(Cause.DEPTH_LIMIT,    lambda c, p: c.depth > p.depth_max, "", SURFACE,
         lambda c, p: (c.depth, p.depth_max)),
    Rule(Cause.ALTITUDE_LIMIT, lambda c, p: c.altitude < p.altitude_min, "altitude_time", SURFACE,
         lambda c, p: (c.altitude, p.altitude_min)),
    Rule(Cause.FENCE,          lambda c, _: c.breach != WITHIN, "fence_time", SURFACE,
         lambda c, _: (float(c.breach),)),
    Rule(Cause.LATE_CYCLES,    lambda c, p: c.late > p.late_max, "", SURFACE,
         lambda c, p: (float(c.late), float(p.late_max))),
    Rule(Cause.MISSION_DONE,   lambda c, _: c.mission_done and c.wanted is Mode.MISSION, "", SURFACE),
    Rule(Cause.RETURN_DONE,    lambda c, _: c.mission_done and c.wanted is Mode.RETURN, "", SURFACE),
)

ARMING: tuple[Rule, ...] = (
    Rule(Cause.ATTITUDE_LOST,  lambda c, _: not c.attitude_ok, "", DISARMED,
         lambda _, p: (p.attitude_timeout,)),
    Rule(Cause.FINS_NOT_HEARD, lambda c, p: p.fin_needed and not c.fins_heard, "", DISARMED,
         lambda _, p: (p.fin_timeout,)),
    Rule(Cause.TILT,           lambda c, p: c.tilt > p.tilt_max, "", DISARMED,
         lambda c, p: (c.tilt, p.tilt_max)),
    Rule(Cause.CHARGE_NEEDED,
         lambda c, p: c.wanted is not SURFACE and p.battery_arm > 0.0 and not c.charge >= p.battery_arm, "", DISARMED,
         lambda c, p: (c.charge, p.battery_arm)),
)
"""What arming asks beyond the rules; to come up from where it lies, a vehicle may be armed with what charge is left."""
# fmt: on

_SAFETY = {Mode.DISARMED: 0, Mode.SURFACE: 1}
"""All other modes ask for the same."""


def safer(a: Mode, b: Mode) -> bool:
    """True if mode a asks strictly less of the vehicle than mode b."""
    return _SAFETY.get(a, 2) < _SAFETY.get(b, 2)
