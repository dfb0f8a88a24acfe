"""Messages on position, attitude and velocity.

Depth appears in four forms. Home is at the water's surface, so `relative_alt` and `altitude_relative` are -depth;
LOCAL_POSITION_NED.z is +depth, down positive as in NED; AMSL altitudes count from mean sea level, in a lake too;
WATER_DEPTH is the distance from the vehicle to the bottom.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from firmware_py.marine import Origin, body_to_ned, local_to_geodetic, wrap
from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.scaling import INT16, INT32, UINT16, boot_ms, boot_us, whole
from firmware_py.params import TakesEffect, param
from firmware_py.records.cycle import Cycle
from firmware_py.records.estimate import StateEstimate

Encoder = Callable[[Cycle], Message | None]
"""Encodes one message from a cycle; None if its values are unknown."""

DEG_E7 = math.radians(1e-7)
_MM, _CM_S, _CENTIDEG = 1e-3, 1e-2, math.radians(0.01)
_HPA = 100.0
_TERRAIN_UNKNOWN, _CLEARANCE_UNKNOWN = -1001.0, -1.0
"""What ALTITUDE defines as unknown: less than -1000 m, and less than 0 m."""


@dataclass(frozen=True, slots=True)
class TelemetryParams:
    """What the messages contain and the vehicle does not measure."""

    surface_altitude: float = param(
        0.0,
        unit="m",
        low=-500.0,
        high=6500.0,
        doc="The water's surface above mean sea level: 0 at sea, not in a lake.",
        mav="MAV_SURF_ALT",
        when=TakesEffect.RESTART,
    )


class PoseTelemetry:
    """Encoders of the messages on position, attitude and velocity."""

    def __init__(self, params: TelemetryParams, origin: Origin, n_max: float) -> None:
        self._surface = params.surface_altitude
        self._origin = origin
        self._n_max = n_max

    def encoders(self) -> dict[int, Encoder]:
        """Return the encoder of each message id."""
        return {
            dialect.MAVLINK_MSG_ID_ATTITUDE: self.attitude,
            dialect.MAVLINK_MSG_ID_LOCAL_POSITION_NED: self.local_position,
            dialect.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: self.global_position,
            dialect.MAVLINK_MSG_ID_VFR_HUD: self.vfr_hud,
            dialect.MAVLINK_MSG_ID_ALTITUDE: self.altitude,
            dialect.MAVLINK_MSG_ID_WATER_DEPTH: self.water_depth,
            dialect.MAVLINK_MSG_ID_SCALED_PRESSURE2: self.water_pressure,
            dialect.MAVLINK_MSG_ID_HOME_POSITION: self.home,
            dialect.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN: self.global_origin,
        }

    def attitude(self, cycle: Cycle) -> Message:
        """Encode ATTITUDE: rad and rad/s; the rates are about the body axes."""
        _, _, _, phi, theta, psi = cycle.state.eta
        _, _, _, p, q, r = cycle.state.nu
        return dialect.MAVLink_attitude_message(boot_ms(cycle.tick), phi, theta, wrap(psi), p, q, r)

    def local_position(self, cycle: Cycle) -> Message:
        """Encode LOCAL_POSITION_NED: m and m/s, down positive."""
        x, y, z, _, _, _ = cycle.state.eta
        return dialect.MAVLink_local_position_ned_message(boot_ms(cycle.tick), x, y, z, *_velocity(cycle.state))

    def global_position(self, cycle: Cycle) -> Message | None:
        """Encode GLOBAL_POSITION_INT; return None if a value is unknown, since the message cannot say so."""
        x, y, z, _, _, psi = cycle.state.eta
        vx, vy, vz = _velocity(cycle.state)
        if not math.isfinite(x + y + z + vx + vy + vz):
            return None
        latitude, longitude = local_to_geodetic(self._origin, x, y)
        return dialect.MAVLink_global_position_int_message(
            boot_ms(cycle.tick),
            whole(latitude, DEG_E7, INT32),
            whole(longitude, DEG_E7, INT32),
            whole(self._surface - z, _MM, INT32),
            whole(-z, _MM, INT32),
            whole(vx, _CM_S, INT16),
            whole(vy, _CM_S, INT16),
            whole(vz, _CM_S, INT16),
            _heading(psi),
        )

    def vfr_hud(self, cycle: Cycle) -> Message:
        """Encode VFR_HUD: `airspeed` is surge, `throttle` the share of the highest propeller speed, `alt` AMSL."""
        state = cycle.state
        vx, vy, vz = _velocity(state)
        throttle = whole(abs(cycle.applied.n) / self._n_max, 0.01, (0, 100))
        heading = whole(state.eta.psi % math.tau, math.radians(1.0), (0, 360), unknown=-1) % 360
        altitude = self._surface - state.eta.z
        return dialect.MAVLink_vfr_hud_message(state.nu.u, math.hypot(vx, vy), heading, throttle, altitude, -vz)

    def altitude(self, cycle: Cycle) -> Message:
        """Encode ALTITUDE, m: depth in four fields, and the distance to the bottom in two."""
        z, bottom = cycle.state.eta.z, cycle.state.altitude
        known = math.isfinite(bottom)
        return dialect.MAVLink_altitude_message(
            boot_us(cycle.tick),
            -z,
            self._surface - z,
            -z,
            -z,
            bottom if known else _TERRAIN_UNKNOWN,
            bottom if known else _CLEARANCE_UNKNOWN,
        )

    def water_depth(self, cycle: Cycle) -> Message | None:
        """Encode WATER_DEPTH: distance to the bottom, m, and where it was measured; None if the position is unknown."""
        x, y, z, phi, theta, psi = cycle.state.eta
        if not math.isfinite(x + y):
            return None
        latitude, longitude = local_to_geodetic(self._origin, x, y)
        bottom = cycle.state.altitude
        return dialect.MAVLink_water_depth_message(
            boot_ms(cycle.tick),
            0,
            math.isfinite(bottom),
            whole(latitude, DEG_E7, INT32),
            whole(longitude, DEG_E7, INT32),
            self._surface - z,
            phi,
            theta,
            wrap(psi),
            bottom,
            math.nan,
        )

    def water_pressure(self, cycle: Cycle) -> Message:
        """Encode SCALED_PRESSURE2: absolute pressure of the water, hPa. SCALED_PRESSURE would be that of the hull."""
        return dialect.MAVLink_scaled_pressure2_message(
            boot_ms(cycle.tick), cycle.heard.pressure.value / _HPA, math.nan, 0, 0
        )

    def home(self, cycle: Cycle) -> Message:
        """Encode HOME_POSITION: the origin, at the water's surface."""
        latitude, longitude, altitude = self._origin_fields()
        return dialect.MAVLink_home_position_message(
            latitude, longitude, altitude, 0.0, 0.0, 0.0, (1.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0, boot_us(cycle.tick)
        )

    def global_origin(self, cycle: Cycle) -> Message:
        """Encode GPS_GLOBAL_ORIGIN: the origin of the local frame."""
        return dialect.MAVLink_gps_global_origin_message(*self._origin_fields(), boot_us(cycle.tick))

    def _origin_fields(self) -> tuple[int, int, int]:
        latitude, longitude = (whole(angle, DEG_E7, INT32) for angle in self._origin)
        return latitude, longitude, whole(self._surface, _MM, INT32)


def _velocity(state: StateEstimate) -> tuple[float, float, float]:
    """Return the velocity (north, east, down), m/s; NaN if the attitude is unknown."""
    eta, nu = state.eta, state.nu
    if not math.isfinite(eta.phi + eta.theta + eta.psi):
        return math.nan, math.nan, math.nan
    return body_to_ned(eta.phi, eta.theta, eta.psi, nu.u, nu.v, nu.w)


def _heading(psi: float) -> int:
    """Return the heading in 0.01 deg, 0 to 35999; 65535 if it is unknown."""
    count = whole(psi % math.tau, _CENTIDEG, UINT16, unknown=65535)
    return 0 if count == 36000 else count
