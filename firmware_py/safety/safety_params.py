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

    attitude_timeout: float = param(0.5, unit="s", low=0.05, high=5.0, doc="Older attitude is lost.", mav="ATT_TIMEOUT")
    attitude_action: Action = param(_SURFACE, doc="Attitude lost.", mav="ATT_ACT", **_UP_ONLY)
    depth_timeout: float = param(1.0, unit="s", low=0.1, high=10.0, doc="Older depth is lost.", mav="DEP_TIMEOUT")
    depth_action: Action = param(_SURFACE, doc="Depth lost.", mav="DEP_ACT", **_UP_ONLY)
    leak_time: float = param(
        0.5, unit="s", low=0.0, high=60.0, doc="A leak for so long, after two readings of it.", mav="LEAK_TIME"
    )
    leak_action: Action = param(_SURFACE, doc="A leak.", mav="LEAK_ACT", **_NOT_HOLD)
    leak_silent_time: float = param(
        30.0, unit="s", low=1.0, high=3600.0, doc="The leak sensor was heard, and is not for so long.", mav="LEAK_SIL_T"
    )
    leak_silent_action: Action = param(_WARN, doc="The leak sensor is silent.", mav="LEAK_SIL_ACT")
    battery_min: float = param(10.0, unit="%", low=0.0, high=90.0, doc="Less battery than this.", mav="BATT_MIN")
    battery_action: Action = param(_SURFACE, doc="Less battery than battery_min.", mav="BATT_ACT", **_NOT_HOLD)
    battery_warn: float = param(20.0, unit="%", low=0.0, high=100.0, doc="The level to warn at.", mav="BATT_WARN")
    battery_warn_action: Action = param(_WARN, doc="Less battery than battery_warn.", mav="BATT_WARN_AC")
    battery_arm: float = param(
        20.0, unit="%", low=0.0, high=100.0, doc="Arming needs as much, and needs to know; 0 off.", mav="BATT_ARM"
    )
    battery_time: float = param(5.0, unit="s", low=0.0, high=60.0, doc="A low battery for so long.", mav="BATT_TIME")
    battery_silent_time: float = param(
        30.0, unit="s", low=1.0, high=3600.0, doc="The charge was known, and is not for so long.", mav="BATT_SIL_T"
    )
    battery_silent_action: Action = param(_RETURN, doc="The charge is not known.", mav="BATT_SIL_ACT")
    depth_max: float = param(30.0, unit="m", low=1.0, high=6000.0, doc="The fence's depth.", mav="DEPTH_MAX")
    depth_max_time: float = param(0.3, unit="s", low=0.0, high=10.0, doc="Deeper for so long.", mav="DEPTH_TIME")
    depth_max_action: Action = param(_SURFACE, doc="Deeper than depth_max.", mav="DEPTH_ACT", **_UP_ONLY)
    altitude_min: float = param(2.0, unit="m", low=0.0, high=50.0, doc="Nearer to the bottom than this.", mav="ALT_MIN")
    altitude_time: float = param(1.0, unit="s", low=0.0, high=10.0, doc="Too near for so long.", mav="ALT_TIME")
    altitude_ahead: float = param(
        4.0, unit="s", low=0.0, high=60.0, doc="The altitude so far ahead in time counts, if it sinks.", mav="ALT_AHEAD"
    )
    stop_time: float = param(
        25.0,
        unit="s",
        low=0.0,
        high=300.0,
        doc="The way is off within; over a bottom too steep to climb, the altitude so far ahead counts.",
        mav="STOP_TIME",
    )
    altitude_action: Action = param(_SURFACE, doc="Too near to the bottom.", mav="ALT_ACT", **_UP_ONLY)
    late_max: int = param(10, low=0, high=1000, doc="More cycles of the last second late than this.", mav="LATE_MAX")
    late_action: Action = param(_SURFACE, doc="Too many late cycles.", mav="LATE_ACT")
    fence_time: float = param(1.0, unit="s", low=0.0, high=60.0, doc="Beyond the fence for so long.", mav="FENCE_TIME")
    fence_action: Action = param(_SURFACE, doc="Beyond the fence.", mav="FENCE_ACT", **_NOT_HOLD)
    pitch_max: float = param(45.0, unit="deg", low=20.0, high=90.0, doc="More pitch than this.", mav="PITCH_MAX")
    pitch_time: float = param(2.0, unit="s", low=0.1, high=60.0, doc="For so long.", mav="PITCH_TIME")
    pitch_action: Action = param(_SURFACE, doc="Too much pitch.", mav="PITCH_ACT", **_UP_ONLY)
    roll_max: float = param(60.0, unit="deg", low=20.0, high=180.0, doc="More roll than this.", mav="ROLL_MAX")
    roll_time: float = param(
        10.0, unit="s", low=0.1, high=600.0, doc="For so long; a current abeam rolls it too.", mav="ROLL_TIME"
    )
    roll_action: Action = param(_SURFACE, doc="Too much roll.", mav="ROLL_ACT", **_UP_ONLY)
    depth_error_max: float = param(
        5.0, unit="m", low=0.5, high=1000.0, doc="Farther from the depth that is flown than this.", mav="DERR_MAX"
    )
    depth_error_time: float = param(20.0, unit="s", low=1.0, high=3600.0, doc="For so long.", mav="DERR_TIME")
    depth_error_action: Action = param(_SURFACE, doc="The depth is not held.", mav="DERR_ACT")
    leg_way: float = param(10.0, unit="m", low=0.1, high=1000.0, doc="Nearer by this in leg_time.", mav="LEG_WAY")
    leg_time: float = param(180.0, unit="s", low=10.0, high=36000.0, doc="See leg_way.", mav="LEG_TIME")
    leg_action: Action = param(_SURFACE, doc="No way is made to the waypoint.", mav="LEG_ACT", **_NOT_HOLD)
    energy_margin: float = param(
        1.5, low=1.0, high=10.0, doc="The way home needs so many times what the way so far did.", mav="ENERGY_MARG"
    )
    energy_action: Action = param(_WARN, doc="The charge above battery_min does not bring it home.", mav="ENERGY_ACT")
    surfacing_time: float = param(600.0, unit="s", low=30.0, high=36000.0, doc="Surfacing, so far.", mav="SURFG_TIME")
    surfacing_action: Action = param(_WARN, doc="Surfacing for so long, and again.", mav="SURFG_ACT", **_UP_ONLY)
    sensor_time: float = param(
        2.0, unit="s", low=0.0, high=600.0, doc="Lost or not believed for so long.", mav="SENS_TIME"
    )
    ahrs_action: Action = param(
        _SURFACE, doc="The AHRS's tilt is not believed; gyros carry it on.", mav="AHRS_ACT", **_UP_ONLY
    )
    heading_action: Action = param(
        _WARN, doc="The AHRS's heading is not believed; gyros carry it on.", mav="HEADING_ACT"
    )
    dvl_action: Action = param(_WARN, doc="The DVL is lost or not believed.", mav="DVL_ACT")
    altimeter_action: Action = param(_WARN, doc="The altimeter is lost or not believed.", mav="ALTIM_ACT")
    bottom_action: Action = param(_WARN, doc="Both: the bottom is not seen.", mav="BOTTOM_ACT")
    terrain_action: Action = param(
        _SURFACE,
        doc="The depth is flown above the bottom, which nothing sees (terrain failsafe).",
        mav="TERRAIN_ACT",
        **_UP_ONLY,
    )
    unchecked_time: float = param(
        60.0,
        unit="s",
        low=1.0,
        high=36000.0,
        doc="No bottom in reach of altimeter and DVL for so long: a slow drift of the pressure is hardly seen.",
        mav="UNCHECK_TIME",
    )
    unchecked_action: Action = param(_WARN, doc="The same: pressure alone tells the depth.", mav="UNCHECK_ACT")
    actuator_time: float = param(
        0.2, unit="s", low=0.0, high=60.0, doc="A fault of an actuator for so long.", mav="ACTR_TIME"
    )
    reserve: float = param(
        20.0,
        unit="%",
        low=0.0,
        high=100.0,
        doc="Share of a sound vehicle's pull-up, or turn, with which damaged fins still control it.",
        mav="RESERVE",
    )
    damage_action: Action = param(_WARN, doc="A fin is damaged, and the rest controls the vehicle.", mav="DAMAGE_ACT")
    plane_action: Action = param(
        _SURFACE, doc="Planes are jammed or lost, and the rest does not.", mav="PLANE_ACT", **_UP_ONLY
    )
    rudder_action: Action = param(_SURFACE, doc="Rudders are jammed or lost, and the rest does not.", mav="RUDDER_ACT")
    propeller_action: Action = param(_DROP, doc="The propeller is jammed or lost.", mav="PROP_ACT", **_UP_ONLY)
    runaway_action: Action = param(_SURFACE, doc="The propeller drives faster than it is told.", mav="RUNAWAY_ACT")
    actuator_silent_action: Action = param(
        _WARN, doc="A fin, the propeller or the hardpoint reports nothing valid.", mav="ACTR_SIL_ACT"
    )
    actuator_worn_action: Action = param(_WARN, doc="One is slow or loose, or the propeller weak.", mav="ACTR_WRN_ACT")
    bus_time: float = param(
        2.0, unit="s", low=0.2, high=60.0, doc="Nothing at all is heard for so long.", mav="BUS_TIME"
    )
    bus_action: Action = param(_SURFACE, doc="No device is heard.", mav="BUS_ACT", **_UP_ONLY)
    restart_time: float = param(
        5.0, unit="s", low=0.5, high=600.0, doc="Under water for so long after the program began.", mav="RESTART_T"
    )
    restart_action: Action = param(
        _SURFACE, doc="Begun again under water, a short time after it was armed.", mav="RESTART_ACT", **_UP_ONLY
    )
    start_action: Action = param(_WARN, doc="Begun under water otherwise.", mav="START_ACT", **_UP_ONLY)
    rally_home: bool = param(False, doc="Home is a rally point too, not only without any.", mav="RALLY_HOME")
    station: StationParams = table(StationParams, mav="GCS_")
    surface_depth: float = param(
        0.5, unit="m", low=0.1, high=1.5, doc="Less deep than this is the surface.", mav="SURF_DEPTH"
    )
    surface_time: float = param(
        2.0, unit="s", low=0.0, high=60.0, doc="At the surface for so long: surfacing is done.", mav="SURF_TIME"
    )
    submerged_depth: float = param(
        1.0, unit="m", low=0.1, high=3.0, doc="Deeper, it is not disarmed unless forced.", mav="SUBM_DEPTH"
    )
    sunk_time: float = param(
        10.0,
        unit="s",
        low=1.0,
        high=300.0,
        doc="Surfaced, disarmed by itself, and submerged again for so long.",
        mav="SUNK_TIME",
    )
    sunk_action: Action = param(_DROP, doc="It sank again.", mav="SUNK_ACT", **_UP_ONLY)
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
