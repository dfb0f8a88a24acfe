"""The messages of the HIL interface: what the plant and its instruments measure, in PX4's units."""

from __future__ import annotations

import math
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as dialect  # type: ignore[import-untyped]

from firmware_py.marine import GRAVITY, Origin, body_to_ned, clip, local_to_geodetic, quaternion_from_euler
from firmware_py.records.sensing import Ahrs, Battery, Dvl, Fix
from sim_bridge.devices.instruments import AltimeterParams
from sim_bridge.plant.plant import Plant

_FIELD_AT_EQUATOR = 0.294048
"""Of the earth's axial dipole, gauss: g_1^0 of IGRF-13 for 2020."""
_UNKNOWN_U16 = 65535
_UNKNOWN_CHARGE = -1
_INT32_MAX = 2147483647.0
_NO_FIX, _FIX_3D = 1, 3
_INVALID_SIGNAL, _PERFECT_SIGNAL = 1, 100


def specific_force(plant: Plant) -> tuple[float, float, float]:
    """Return what an accelerometer at the body's origin would measure, m/s^2: at rest it is -g, up."""
    _, _, _, phi, theta, _ = plant.eta
    u, v, w, p, q, r = plant.nu
    u_dot, v_dot, w_dot = plant.nu_dot[:3]
    return (
        u_dot + q * w - r * v + GRAVITY * math.sin(theta),
        v_dot + r * u - p * w - GRAVITY * math.cos(theta) * math.sin(phi),
        w_dot + p * v - q * u - GRAVITY * math.cos(theta) * math.cos(phi),
    )


def magnetic_field(latitude: float) -> tuple[float, float, float]:
    """Return the earth's field as that of an axial dipole, NED, gauss; it has no declination."""
    return _FIELD_AT_EQUATOR * math.cos(latitude), 0.0, 2.0 * _FIELD_AT_EQUATOR * math.sin(latitude)


def state_quaternion(plant: Plant, measured: tuple[Ahrs, Dvl], origin: Origin, time_us: int) -> Any:
    """Return HIL_STATE_QUATERNION: attitude, rates and velocity as `measured`, the rest as it is."""
    ahrs, dvl = measured
    x, y, z = plant.eta[:3]
    q_x, q_y, q_z, q_w = quaternion_from_euler(*ahrs[:3])
    latitude, longitude = local_to_geodetic(origin, x, y)
    velocity = body_to_ned(*ahrs[:3], *dvl[:3])
    return dialect.MAVLink_hil_state_quaternion_message(
        time_us,
        (q_w, q_x, q_y, q_z),
        *ahrs[3:],
        _degrees_e7(latitude),
        _degrees_e7(longitude),
        round(-1e3 * z),
        *(_int16(100.0 * v) for v in velocity),
        0,
        0,
        *(_int16(1e3 * f / GRAVITY) for f in specific_force(plant)),
    )


def gps(fix: Fix | None, plant: Plant, time_us: int) -> Any:
    """Return HIL_GPS: position of the receiver, its error as `eph` in cm (as PX4 reads it), the true velocity.

    A position that is not finite is no fix.
    """
    if fix is None or not math.isfinite(fix.latitude + fix.longitude):
        unknown = (_UNKNOWN_U16,) * 3
        return dialect.MAVLink_hil_gps_message(time_us, _NO_FIX, 0, 0, 0, *unknown, 0, 0, 0, _UNKNOWN_U16, 0)
    north, east, down = body_to_ned(*plant.eta[3:], *plant.nu[:3])
    course = round(math.degrees(math.atan2(east, north)) * 100.0) % 36000
    return dialect.MAVLink_hil_gps_message(
        time_us,
        _FIX_3D,
        _degrees_e7(fix.latitude),
        _degrees_e7(fix.longitude),
        round(-1e3 * plant.eta.z),
        min(round(100.0 * fix.std), _UNKNOWN_U16 - 1),
        _UNKNOWN_U16,
        min(round(100.0 * math.hypot(north, east)), _UNKNOWN_U16 - 1),
        *(_int16(100.0 * v) for v in (north, east, down)),
        course,
        9,
    )


def distance_sensor(altitude: float, params: AltimeterParams, time_ms: int) -> Any:
    """Return DISTANCE_SENSOR; too near (0) or too far (inf) is a distance beyond the limits and an invalid signal."""
    near, far = (min(round(100.0 * limit), _UNKNOWN_U16 - 1) for limit in (params.range_min, params.range_max))
    valid = 0.0 < altitude < math.inf
    return dialect.MAVLink_distance_sensor_message(
        time_ms,
        near,
        far,
        min(round(100.0 * altitude), far) if valid else far + 1 if altitude else 0,
        dialect.MAV_DISTANCE_SENSOR_ULTRASOUND,
        0,
        dialect.MAV_SENSOR_ROTATION_PITCH_270,
        min(round((100.0 * params.noise) ** 2), 254),
        signal_quality=_PERFECT_SIGNAL if valid else _INVALID_SIGNAL,
    )


def leak(humidity: float, time_ms: int) -> Any:
    """Return NAMED_VALUE_FLOAT: PX4's interface has no leak sensor."""
    return dialect.MAVLink_named_value_float_message(time_ms, b"LEAK", humidity)


def drop_weight(load: float, time_ms: int) -> Any:
    """Return NAMED_VALUE_FLOAT: PX4's interface has no hardpoint."""
    return dialect.MAVLink_named_value_float_message(time_ms, b"WEIGHT", load)


def battery_status(battery: Battery) -> Any:
    """Return BATTERY_STATUS: the charge within 0 to 100 %, or unknown if it is NaN."""
    whole = round(1e3 * battery.voltage)  # what exceeds one field continues in the next
    first = min(max(whole, 0), _UNKNOWN_U16 - 1)
    voltages = (first, whole - first if whole > first else _UNKNOWN_U16, *(_UNKNOWN_U16,) * 8)
    percent = clip(100.0 * battery.remaining, 0.0, 100.0)
    charge = _UNKNOWN_CHARGE if math.isnan(percent) else round(percent)
    kind = (0, dialect.MAV_BATTERY_FUNCTION_ALL, dialect.MAV_BATTERY_TYPE_UNKNOWN, 32767)
    return dialect.MAVLink_battery_status_message(*kind, voltages, _int16(100.0 * battery.current), -1, -1, charge)


def _degrees_e7(angle: float) -> int:
    return round(clip(math.degrees(angle) * 1e7, -_INT32_MAX, _INT32_MAX))


def _int16(value: float) -> int:
    """Return a field; 0 for a velocity of an attitude that is NaN, which nobody can turn back into the body frame."""
    return round(clip(value, -32767.0, 32767.0)) if math.isfinite(value) else 0
