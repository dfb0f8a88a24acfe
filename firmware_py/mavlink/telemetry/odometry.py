"""Messages that some stations and libraries need: IMU, quaternion, odometry, position fix, bottom, control errors."""

from __future__ import annotations

import math

from firmware_py.marine import quaternion_from_euler, wrap
from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.scaling import INT16, INT32, UINT16, boot_ms, boot_us, whole
from firmware_py.mavlink.telemetry.pose import DEG_E7, Encoder
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import Mode

_RECENT = 2.0
"""An older fix, s, is not reported."""
_MILLI, _CM, _MM = 1e-3, 1e-2, 1e-3
_UNKNOWN16 = 65535
_SATELLITES_UNKNOWN = 255
_ALTIMETER_CM = (0, 65534)
_COVARIANCES = 21
_DIAGONAL = (0, 6, 11, 15, 18, 20)
"""Indices of the diagonal in the upper triangle of a symmetric 6x6 matrix, row by row."""
_LANDED = {
    Mode.DISARMED: dialect.MAV_LANDED_STATE_ON_GROUND,
    Mode.SURFACE: dialect.MAV_LANDED_STATE_LANDING,
}


class OdometryTelemetry:
    """Encoders of these messages; `surface` is the altitude of the water's surface above mean sea level, m."""

    def __init__(self, surface: float) -> None:
        self._surface = surface

    def encoders(self) -> dict[int, Encoder]:
        """Return the encoder of each message id."""
        return {
            dialect.MAVLINK_MSG_ID_SCALED_IMU: self.imu,
            dialect.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: self.quaternion,
            dialect.MAVLINK_MSG_ID_ODOMETRY: self.odometry,
            dialect.MAVLINK_MSG_ID_GPS_RAW_INT: self.fix,
            dialect.MAVLINK_MSG_ID_DISTANCE_SENSOR: self.bottom,
            dialect.MAVLINK_MSG_ID_NAV_CONTROLLER_OUTPUT: self.errors,
            dialect.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: self.extended_state,
        }

    def imu(self, cycle: Cycle) -> Message:
        """Encode SCALED_IMU, mG and mrad/s: the body rates of the AHRS, and gravity as an accelerometer at rest has it.

        No accelerometer and no magnetometer is received, and the message cannot say that a value is unknown.
        """
        phi, theta, _ = _angles(cycle)
        ahrs = cycle.heard.ahrs.value
        x, y, z = math.sin(theta), -math.cos(theta) * math.sin(phi), -math.cos(theta) * math.cos(phi)
        force = [whole(g, _MILLI, INT16) for g in (x, y, z)]
        rates = [whole(rate, _MILLI, INT16) for rate in (ahrs.p, ahrs.q, ahrs.r)]
        return dialect.MAVLink_scaled_imu_message(boot_ms(cycle.tick), *force, *rates, 0, 0, 0)

    def quaternion(self, cycle: Cycle) -> Message:
        """Encode ATTITUDE_QUATERNION, w first."""
        _, _, _, p, q, r = cycle.state.nu
        return dialect.MAVLink_attitude_quaternion_message(boot_ms(cycle.tick), *_quaternion(cycle), p, q, r)

    def odometry(self, cycle: Cycle) -> Message:
        """Encode ODOMETRY: position in NED, velocity over ground in body axes; variances that are unknown are NaN."""
        state = cycle.state
        position, depth = 0.5 * state.position_std * state.position_std, state.depth_std * state.depth_std
        pose = _covariance(position, position, depth, math.nan, math.nan, math.nan)
        speed = state.velocity_std * state.velocity_std
        velocity = _covariance(speed, speed, math.nan, math.nan, math.nan, math.nan)
        return dialect.MAVLink_odometry_message(
            *(boot_us(cycle.tick), dialect.MAV_FRAME_LOCAL_NED, dialect.MAV_FRAME_BODY_FRD),
            *state.eta[:3],
            _quaternion(cycle),
            *state.nu,
            pose,
            velocity,
            0,
            dialect.MAV_ESTIMATOR_TYPE_AUTOPILOT,
            100 if state.velocity_ok and state.attitude_ok and state.depth_ok else 0,
        )

    def fix(self, cycle: Cycle) -> Message:
        """Encode GPS_RAW_INT. There are fixes at the surface only, so the altitude is that of the surface.

        The receiver does not report the number of satellites, nor their dilution of precision.
        """
        fix = cycle.heard.fix
        has_fix = fix.usable(cycle.tick.t, _RECENT) and math.isfinite(fix.value.latitude + fix.value.longitude)
        latitude, longitude = (fix.value.latitude, fix.value.longitude) if has_fix else (0.0, 0.0)
        return dialect.MAVLink_gps_raw_int_message(
            boot_us(cycle.tick),
            dialect.GPS_FIX_TYPE_3D_FIX if has_fix else dialect.GPS_FIX_TYPE_NO_FIX,
            whole(latitude, DEG_E7, INT32),
            whole(longitude, DEG_E7, INT32),
            whole(self._surface, _MM, INT32) if has_fix else 0,
            *(_UNKNOWN16, _UNKNOWN16, _UNKNOWN16, _UNKNOWN16),
            _SATELLITES_UNKNOWN,
            h_acc=whole(fix.value.std, _MM, INT32) if has_fix else 0,
        )

    def bottom(self, cycle: Cycle) -> Message | None:
        """Encode DISTANCE_SENSOR, looking down, cm; return None without an echo of the bottom."""
        altitude = cycle.state.altitude
        if not math.isfinite(altitude):
            return None
        return dialect.MAVLink_distance_sensor_message(
            boot_ms(cycle.tick),
            *_ALTIMETER_CM,
            whole(altitude, _CM, _ALTIMETER_CM),
            dialect.MAV_DISTANCE_SENSOR_ULTRASOUND,
            0,
            dialect.MAV_SENSOR_ROTATION_PITCH_270,
            255,
        )

    def errors(self, cycle: Cycle) -> Message:
        """Encode NAV_CONTROLLER_OUTPUT: reference less state in deg, m and m/s, altitude up positive.

        Bearing and distance are those of the navigation target, see `Reference`.
        """
        reference, state = cycle.reference, cycle.state
        across = reference.cross_track
        return dialect.MAVLink_nav_controller_output_message(
            math.degrees(state.eta.phi),
            math.degrees(state.eta.theta),
            _heading(reference.psi_d),
            _heading(reference.target_bearing),
            whole(reference.target_distance, 1.0, UINT16),
            state.eta.z - reference.z_d,
            reference.u_d - state.nu.u,
            across if math.isfinite(across) else 0.0,
        )

    def extended_state(self, cycle: Cycle) -> Message:
        """Encode EXTENDED_SYS_STATE: on ground while disarmed, landing in SURFACE, else in air."""
        landed = _LANDED.get(cycle.mode.mode, dialect.MAV_LANDED_STATE_IN_AIR)
        return dialect.MAVLink_extended_sys_state_message(dialect.MAV_VTOL_STATE_UNDEFINED, landed)


def _heading(angle: float) -> int:
    return whole(math.degrees(wrap(angle)), 1.0, INT16)


def _quaternion(cycle: Cycle) -> tuple[float, float, float, float]:
    x, y, z, w = quaternion_from_euler(*_angles(cycle))
    return w, x, y, z


def _angles(cycle: Cycle) -> tuple[float, float, float]:
    """Return (phi, theta, psi), rad; all NaN if one of them is not finite."""
    _, _, _, phi, theta, psi = cycle.state.eta
    return (phi, theta, psi) if math.isfinite(phi + theta + psi) else (math.nan, math.nan, math.nan)


def _covariance(*variances: float) -> list[float]:
    upper = [0.0] * _COVARIANCES
    for position, variance in zip(_DIAGONAL, variances, strict=True):
        upper[position] = variance
    return upper
