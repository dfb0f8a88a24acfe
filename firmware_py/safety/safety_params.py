"""Table [safety]: the limits of the rules, and what each rule does."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

from firmware_py.params import param, table
from firmware_py.safety.action import Action
from firmware_py.safety.actuators.actuator_params import ActuatorParams
from firmware_py.safety.ascent_params import AscentParams
from firmware_py.safety.gate import GateParams
from firmware_py.safety.station_params import StationParams

_WARN, _RETURN, _SURFACE, _DROP = Action.WARN, Action.RETURN, Action.SURFACE, Action.SURFACE_AND_DROP
_UP = (_SURFACE, _DROP)
_UP_ONLY: dict[str, Any] = {
    "refused": (Action.HOLD, Action.RETURN),
    "why": "neither hold nor return can be flown then, or both keep what is wrong",
}
_NOT_HOLD: dict[str, Any] = {"refused": (Action.HOLD,), "why": "it would stay under water, or beyond the fence"}


@dataclass(frozen=True)
class SafetyParams:
    """The limits of the rules; each `*_time` is how long a condition must hold without a break."""

    attitude_timeout: float = param(
        0.5, unit="s", low=0.05, high=5.0, doc="An attitude older than this is lost.", mav="ATT_TIMEOUT"
    )
    attitude_action: Action = param(_SURFACE, doc="Action when attitude is lost.", mav="ATT_ACT", **_UP_ONLY)
    depth_timeout: float = param(
        1.0, unit="s", low=0.1, high=10.0, doc="A depth older than this is lost.", mav="DEP_TIMEOUT"
    )
    depth_action: Action = param(_SURFACE, doc="Action when depth is lost.", mav="DEP_ACT", **_UP_ONLY)
    leak_time: float = param(
        0.5, unit="s", low=0.0, high=60.0, doc="A leak counts after so long, and two readings.", mav="LEAK_TIME"
    )
    leak_action: Action = param(_SURFACE, doc="Action on a leak.", mav="LEAK_ACT", **_NOT_HOLD)
    leak_silent_time: float = param(
        30.0,
        unit="s",
        low=1.0,
        high=3600.0,
        doc="The leak sensor is silent after so long, if it was heard before.",
        mav="LEAK_SIL_T",
    )
    leak_silent_action: Action = param(_WARN, doc="Action when the leak sensor is silent.", mav="LEAK_SIL_ACT")
    battery_min: float = param(10.0, unit="%", low=0.0, high=90.0, doc="Least charge under way.", mav="BATT_MIN")
    battery_action: Action = param(_SURFACE, doc="Action below battery_min.", mav="BATT_ACT", **_NOT_HOLD)
    battery_warn: float = param(20.0, unit="%", low=0.0, high=100.0, doc="Charge to warn at.", mav="BATT_WARN")
    battery_warn_action: Action = param(_WARN, doc="Action below battery_warn.", mav="BATT_WARN_AC")
    battery_arm: float = param(
        20.0,
        unit="%",
        low=0.0,
        high=100.0,
        doc="Least charge at arming, and it must be known; 0 is off.",
        mav="BATT_ARM",
    )
    battery_time: float = param(
        5.0, unit="s", low=0.0, high=60.0, doc="A low charge counts after so long.", mav="BATT_TIME"
    )
    battery_silent_time: float = param(
        30.0,
        unit="s",
        low=1.0,
        high=3600.0,
        doc="The charge is unknown after so long without a report, if it was known before.",
        mav="BATT_SIL_T",
    )
    battery_silent_action: Action = param(_RETURN, doc="Action when the charge is not known.", mav="BATT_SIL_ACT")
    depth_max: float = param(30.0, unit="m", low=1.0, high=6000.0, doc="Greatest depth.", mav="DEPTH_MAX")
    depth_max_time: float = param(
        0.3, unit="s", low=0.0, high=10.0, doc="A greater depth than depth_max counts after so long.", mav="DEPTH_TIME"
    )
    depth_max_action: Action = param(_SURFACE, doc="Action below depth_max.", mav="DEPTH_ACT", **_UP_ONLY)
    altitude_min: float = param(2.0, unit="m", low=0.0, high=50.0, doc="Least height above the bottom.", mav="ALT_MIN")
    altitude_time: float = param(
        1.0, unit="s", low=0.0, high=10.0, doc="A height under altitude_min counts after so long.", mav="ALT_TIME"
    )
    altitude_ahead: float = param(
        4.0,
        unit="s",
        low=0.0,
        high=60.0,
        doc="The height above the bottom so far ahead in time counts, if it shrinks.",
        mav="ALT_AHEAD",
    )
    stop_time: float = param(
        25.0,
        unit="s",
        low=0.0,
        high=300.0,
        doc="Reverse thrust stops it within so long; over a bottom too steep to climb the height then counts.",
        mav="STOP_TIME",
    )
    altitude_action: Action = param(_SURFACE, doc="Action under altitude_min.", mav="ALT_ACT", **_UP_ONLY)
    late_max: int = param(10, low=0, high=1000, doc="Most late cycles in a second.", mav="LATE_MAX")
    late_action: Action = param(_SURFACE, doc="Action after more late cycles than late_max.", mav="LATE_ACT")
    fence_time: float = param(
        1.0, unit="s", low=0.0, high=60.0, doc="A breach of the fence counts after so long.", mav="FENCE_TIME"
    )
    fence_action: Action = param(_SURFACE, doc="Action beyond the fence.", mav="FENCE_ACT", **_NOT_HOLD)
    pitch_max: float = param(45.0, unit="deg", low=20.0, high=90.0, doc="Greatest pitch, up or down.", mav="PITCH_MAX")
    pitch_time: float = param(
        2.0, unit="s", low=0.1, high=60.0, doc="More pitch than pitch_max counts after so long.", mav="PITCH_TIME"
    )
    pitch_action: Action = param(_SURFACE, doc="Action beyond pitch_max.", mav="PITCH_ACT", **_UP_ONLY)
    roll_max: float = param(60.0, unit="deg", low=20.0, high=180.0, doc="Greatest roll.", mav="ROLL_MAX")
    roll_time: float = param(
        10.0,
        unit="s",
        low=0.1,
        high=600.0,
        doc="More roll than roll_max counts after so long; a current abeam rolls it too.",
        mav="ROLL_TIME",
    )
    roll_action: Action = param(_SURFACE, doc="Action beyond roll_max.", mav="ROLL_ACT", **_UP_ONLY)
    depth_error_max: float = param(
        5.0, unit="m", low=0.5, high=1000.0, doc="Greatest distance from the depth that is flown.", mav="DERR_MAX"
    )
    depth_error_time: float = param(
        20.0,
        unit="s",
        low=1.0,
        high=3600.0,
        doc="A depth off by depth_error_max counts after so long.",
        mav="DERR_TIME",
    )
    depth_error_action: Action = param(_SURFACE, doc="Action when the depth is not held.", mav="DERR_ACT")
    leg_way: float = param(
        10.0,
        unit="m",
        low=0.1,
        high=1000.0,
        doc="Least way towards the waypoint, in the time of leg_time.",
        mav="LEG_WAY",
    )
    leg_time: float = param(
        180.0,
        unit="s",
        low=10.0,
        high=36000.0,
        doc="Time in which it must come nearer to the waypoint by leg_way.",
        mav="LEG_TIME",
    )
    leg_action: Action = param(_SURFACE, doc="Action when no way is made to the waypoint.", mav="LEG_ACT", **_NOT_HOLD)
    energy_margin: float = param(
        1.5,
        low=1.0,
        high=10.0,
        doc="The way home is reckoned with so many times the charge a metre of the way so far.",
        mav="ENERGY_MARG",
    )
    energy_action: Action = param(
        _WARN, doc="Action when the charge above battery_min does not bring it home.", mav="ENERGY_ACT"
    )
    surfacing_time: float = param(
        600.0, unit="s", low=30.0, high=36000.0, doc="Surfacing takes too long after this time.", mav="SURFG_TIME"
    )
    surfacing_action: Action = param(_WARN, doc="Action after each surfacing_time.", mav="SURFG_ACT", **_UP_ONLY)
    sensor_time: float = param(
        2.0,
        unit="s",
        low=0.0,
        high=600.0,
        doc="A sensor that is lost or not believed counts after so long.",
        mav="SENS_TIME",
    )
    ahrs_action: Action = param(
        _SURFACE, doc="Action when the AHRS's tilt is not believed, and gyros carry it on.", mav="AHRS_ACT", **_UP_ONLY
    )
    heading_action: Action = param(
        _WARN, doc="Action when the AHRS's heading is not believed, and gyros carry it on.", mav="HEADING_ACT"
    )
    dvl_action: Action = param(_WARN, doc="Action when the DVL is lost or not believed.", mav="DVL_ACT")
    altimeter_action: Action = param(_WARN, doc="Action when the altimeter is lost or not believed.", mav="ALTIM_ACT")
    bottom_action: Action = param(_WARN, doc="Action when neither DVL nor altimeter sees the bottom.", mav="BOTTOM_ACT")
    terrain_action: Action = param(
        _SURFACE,
        doc="Action when a height above the bottom is flown, and nothing sees it (terrain failsafe).",
        mav="TERRAIN_ACT",
        **_UP_ONLY,
    )
    unchecked_time: float = param(
        60.0,
        unit="s",
        low=1.0,
        high=36000.0,
        doc="After so long without a bottom in reach a slow drift of the pressure is hardly seen.",
        mav="UNCHECK_TIME",
    )
    unchecked_action: Action = param(
        _WARN, doc="Action when pressure alone has told the depth for unchecked_time.", mav="UNCHECK_ACT"
    )
    actuator_time: float = param(
        0.2, unit="s", low=0.0, high=60.0, doc="A fault of an actuator counts after so long.", mav="ACTR_TIME"
    )
    reserve: float = param(
        20.0,
        unit="%",
        low=0.0,
        high=100.0,
        doc="Share of a sound vehicle's pull-up, or turn, with which damaged fins still control it.",
        mav="RESERVE",
    )
    damage_action: Action = param(
        _WARN, doc="Action when a fin is damaged and the others control the vehicle.", mav="DAMAGE_ACT"
    )
    plane_action: Action = param(
        _SURFACE,
        doc="Action when planes are jammed or lost and the others cannot control the vehicle.",
        mav="PLANE_ACT",
        **_UP_ONLY,
    )
    rudder_action: Action = param(
        _SURFACE,
        doc="Action when rudders are jammed or lost and the others cannot control the vehicle.",
        mav="RUDDER_ACT",
    )
    propeller_action: Action = param(_DROP, doc="Action on a jammed or lost propeller.", mav="PROP_ACT", **_UP_ONLY)
    runaway_action: Action = param(_SURFACE, doc="Action when the propeller turns faster than told.", mav="RUNAWAY_ACT")
    actuator_silent_action: Action = param(
        _WARN, doc="Action when a fin, the propeller or the hardpoint reports nothing valid.", mav="ACTR_SIL_ACT"
    )
    actuator_worn_action: Action = param(
        _WARN, doc="Action when a fin is slow or loose, or the propeller weak.", mav="ACTR_WRN_ACT"
    )
    bus_time: float = param(
        2.0,
        unit="s",
        low=0.2,
        high=60.0,
        doc="The bus is silent after so long without a message of any device.",
        mav="BUS_TIME",
    )
    bus_action: Action = param(_SURFACE, doc="Action when no device is heard.", mav="BUS_ACT", **_UP_ONLY)
    restart_time: float = param(
        5.0, unit="s", low=0.5, high=600.0, doc="A start under water counts after so long.", mav="RESTART_T"
    )
    restart_action: Action = param(
        _SURFACE,
        doc="Action when the program begins anew under water soon after it was armed.",
        mav="RESTART_ACT",
        **_UP_ONLY,
    )
    start_action: Action = param(
        _WARN, doc="Action when the program begins under water otherwise.", mav="START_ACT", **_UP_ONLY
    )
    rally_home: bool = param(
        False, doc="Home is a rally point beside others, not only where there is no other.", mav="RALLY_HOME"
    )
    station: StationParams = table(StationParams, mav="GCS_")
    surface_depth: float = param(
        0.5, unit="m", low=0.1, high=1.5, doc="Above this depth it is at the surface.", mav="SURF_DEPTH"
    )
    surface_time: float = param(
        2.0, unit="s", low=0.0, high=60.0, doc="Surfacing is done after so long at the surface.", mav="SURF_TIME"
    )
    submerged_depth: float = param(
        1.0, unit="m", low=0.1, high=3.0, doc="Below this depth it is disarmed only if forced.", mav="SUBM_DEPTH"
    )
    sunk_time: float = param(
        10.0,
        unit="s",
        low=1.0,
        high=300.0,
        doc="It sank again if it is under water for so long after it surfaced and disarmed itself.",
        mav="SUNK_TIME",
    )
    sunk_action: Action = param(_DROP, doc="Action when it sank; a sound one drops later.", mav="SUNK_ACT", **_UP_ONLY)
    fix_timeout: float = param(
        2.0, unit="s", low=0.2, high=60.0, doc="An older position fix does not tell of the surface.", mav="FIX_TIMEOUT"
    )
    tilt_max: float = param(
        45.0, unit="deg", low=5.0, high=90.0, doc="Arming needs less roll and pitch than this.", mav="TILT_MAX"
    )
    fin_timeout: float = param(
        1.0, unit="s", low=0.1, high=10.0, doc="Arming needs every fin heard within; see fin_needed.", mav="FIN_TIMEOUT"
    )
    weight_needed: bool = param(
        False, doc="Arming is refused once the drop weight was released; else it warns.", mav="WGHT_NEEDED"
    )
    fin_needed: bool = param(True, doc="False for fins that report no angle.", mav="FIN_NEEDED")
    gate: GateParams = table(GateParams, mav="GATE_")
    ascent: AscentParams = table(AscentParams, mav="ASC_")
    actuators: ActuatorParams = table(ActuatorParams, mav="ACT_")


def left_below(params: Any, table: str = "safety.") -> Iterator[str]:
    """Yield the actions that are "none" or "warn" where, unless told otherwise, the rule brings the vehicle up."""
    for field in fields(params):
        value = getattr(params, field.name)
        if is_dataclass(value):
            yield from left_below(value, f"{table}{field.name}.")
        elif isinstance(value, Action) and value <= Action.WARN and field.default in _UP:
            yield f"{table}{field.name} = {value.name.lower()}"
