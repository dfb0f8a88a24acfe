"""Where the vehicle is and how it moves, as messages.

Depth has four names. The home is at the water's surface, so `relative_alt` and `altitude_relative` are -depth;
LOCAL_POSITION_NED.z is +depth, down as all of NED; what is called AMSL counts from the sea, in a lake as well; and
WATER_DEPTH is none of them, but the water that is left below the vehicle.
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
"""Makes one message of a cycle, or None when there is nothing true to say."""

DEG_E7 = math.radians(1e-7)
_MM, _CM_S, _CENTIDEG = 1e-3, 1e-2, math.radians(0.01)
_HPA = 100.0
_TERRAIN_UNKNOWN, _CLEARANCE_UNKNOWN = -1001.0, -1.0
"""ALTITUDE's own words: less than -1000 m, and less than 0."""


@dataclass(frozen=True, slots=True)
class TelemetryParams:
    """What the messages need that the vehicle does not measure."""

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
    """Makers of the messages on position and motion."""

    def __init__(self, params: TelemetryParams, origin: Origin, n_max: float) -> None:
        self._surface = params.surface_altitude
        self._origin = origin
        self._n_max = n_max

    def encoders(self) -> dict[int, Encoder]:
        """A maker for each message id."""
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
        """ATTITUDE: rad, rad/s, the rates about the body's axes."""
        _, _, _, phi, theta, psi = cycle.state.eta
        _, _, _, p, q, r = cycle.state.nu
        return dialect.MAVLink_attitude_message(boot_ms(cycle.tick), phi, theta, wrap(psi), p, q, r)

    def local_position(self, cycle: Cycle) -> Message:
        """LOCAL_POSITION_NED: m, m/s, down positive."""
        x, y, z, _, _, _ = cycle.state.eta
        return dialect.MAVLink_local_position_ned_message(boot_ms(cycle.tick), x, y, z, *_velocity(cycle.state))

    def global_position(self, cycle: Cycle) -> Message | None:
        """GLOBAL_POSITION_INT; it has no word for an unknown place or speed, so then there is none."""
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
        """VFR_HUD: `airspeed` is the surge, `throttle` the propeller's share of its highest speed, `alt` is AMSL."""
        state = cycle.state
        vx, vy, vz = _velocity(state)
        throttle = whole(abs(cycle.applied.n) / self._n_max, 0.01, (0, 100))
        heading = whole(state.eta.psi % math.tau, math.radians(1.0), (0, 360), unknown=-1) % 360
        altitude = self._surface - state.eta.z
        return dialect.MAVLink_vfr_hud_message(state.nu.u, math.hypot(vx, vy), heading, throttle, altitude, -vz)

    def altitude(self, cycle: Cycle) -> Message:
        """ALTITUDE: one depth and one distance to the bottom under all their names, m."""
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
        """WATER_DEPTH: distance to the bottom, m, and where that was measured; none where the place is unknown."""
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
        """SCALED_PRESSURE2: the water's absolute pressure, hPa; the first SCALED_PRESSURE would be the hull's."""
        return dialect.MAVLink_scaled_pressure2_message(
            boot_ms(cycle.tick), cycle.frame.pressure.value / _HPA, math.nan, 0, 0
        )

    def home(self, cycle: Cycle) -> Message:
        """HOME_POSITION: the origin, at the water's surface."""
        latitude, longitude, altitude = self._origin_fields()
        return dialect.MAVLink_home_position_message(
            latitude, longitude, altitude, 0.0, 0.0, 0.0, (1.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0, boot_us(cycle.tick)
        )

    def global_origin(self, cycle: Cycle) -> Message:
        """GPS_GLOBAL_ORIGIN of the local frame."""
        return dialect.MAVLink_gps_global_origin_message(*self._origin_fields(), boot_us(cycle.tick))

    def _origin_fields(self) -> tuple[int, int, int]:
        latitude, longitude = (whole(angle, DEG_E7, INT32) for angle in self._origin)
        return latitude, longitude, whole(self._surface, _MM, INT32)


def _velocity(state: StateEstimate) -> tuple[float, float, float]:
    """(north, east, down), m/s."""
    eta, nu = state.eta, state.nu
    if not math.isfinite(eta.phi + eta.theta + eta.psi):
        return math.nan, math.nan, math.nan
    return body_to_ned(eta.phi, eta.theta, eta.psi, nu.u, nu.v, nu.w)


def _heading(psi: float) -> int:
    """0 to 35999 hundredths of a degree, 65535 unknown."""
    count = whole(psi % math.tau, _CENTIDEG, UINT16, unknown=65535)
    return 0 if count == 36000 else count
