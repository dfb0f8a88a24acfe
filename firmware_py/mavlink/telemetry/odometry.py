"""What libraries and stations want as messages of their own of what others say too: motion, fix, bottom, errors."""

from __future__ import annotations

import math

from firmware_py.marine import quaternion_from_euler, wrap
from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.scaling import INT16, INT32, UINT16, boot_ms, boot_us, whole
from firmware_py.mavlink.telemetry.pose import DEG_E7, Encoder
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import Mode

_RECENT = 2.0
"""A fix that is older, s, is none."""
_MILLI, _CM, _MM = 1e-3, 1e-2, 1e-3
_UNKNOWN16 = 65535
_SATELLITES_UNKNOWN = 255
_ALTIMETER_CM = (0, 65534)
_COVARIANCES = 21
_DIAGONAL = (0, 6, 11, 15, 18, 20)
"""Of a symmetric 6x6 matrix of which the upper triangle is sent, row by row."""
_LANDED = {
    Mode.DISARMED: dialect.MAV_LANDED_STATE_ON_GROUND,
    Mode.SURFACE: dialect.MAV_LANDED_STATE_LANDING,
}


class OdometryTelemetry:
    """Makers of these messages; `surface` is the water's above mean sea level, m."""

    def __init__(self, surface: float) -> None:
        self._surface = surface

    def encoders(self) -> dict[int, Encoder]:
        """A maker for each message id."""
        return {
            dialect.MAVLINK_MSG_ID_SCALED_IMU: self.imu,
            dialect.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: self.quaternion,
            dialect.MAVLINK_MSG_ID_ODOMETRY: self.odometry,
            dialect.MAVLINK_MSG_ID_GPS_RAW_INT: self.fix,
            dialect.MAVLINK_MSG_ID_DISTANCE_SENSOR: self.bottom,
            dialect.MAVLINK_MSG_ID_NAV_CONTROLLER_OUTPUT: self.errors,
            dialect.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: self.extended,
        }

    def imu(self, cycle: Cycle) -> Message:
        """SCALED_IMU: gyros as the AHRS says them; no accelerometer is heard, so what gravity alone would show.

        mG and mrad/s; the message has no word for unknown, and there is no magnetometer.
        """
        phi, theta, _ = _angles(cycle)
        ahrs = cycle.frame.ahrs.value
        x, y, z = math.sin(theta), -math.cos(theta) * math.sin(phi), -math.cos(theta) * math.cos(phi)
        force = [whole(g, _MILLI, INT16) for g in (x, y, z)]
        rates = [whole(rate, _MILLI, INT16) for rate in (ahrs.p, ahrs.q, ahrs.r)]
        return dialect.MAVLink_scaled_imu_message(boot_ms(cycle.tick), *force, *rates, 0, 0, 0)

    def quaternion(self, cycle: Cycle) -> Message:
        """ATTITUDE_QUATERNION, w first."""
        _, _, _, p, q, r = cycle.state.nu
        return dialect.MAVLink_attitude_quaternion_message(boot_ms(cycle.tick), *_quaternion(cycle), p, q, r)

    def odometry(self, cycle: Cycle) -> Message:
        """ODOMETRY: place in NED, velocity over ground in the body's axes; variances where they are known, else NaN."""
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
        """GPS_RAW_INT: a fix is to be had at the surface alone, which is then its altitude; under water there is none.

        How many satellites, and how well they stand, the receiver does not say.
        """
        fix = cycle.frame.fix
        there = fix.usable(cycle.tick.t, _RECENT) and math.isfinite(fix.value.latitude + fix.value.longitude)
        latitude, longitude = (fix.value.latitude, fix.value.longitude) if there else (0.0, 0.0)
        return dialect.MAVLink_gps_raw_int_message(
            boot_us(cycle.tick),
            dialect.GPS_FIX_TYPE_3D_FIX if there else dialect.GPS_FIX_TYPE_NO_FIX,
            whole(latitude, DEG_E7, INT32),
            whole(longitude, DEG_E7, INT32),
            whole(self._surface, _MM, INT32) if there else 0,
            *(_UNKNOWN16, _UNKNOWN16, _UNKNOWN16, _UNKNOWN16),
            _SATELLITES_UNKNOWN,
            h_acc=whole(fix.value.std, _MM, INT32) if there else 0,
        )

    def bottom(self, cycle: Cycle) -> Message | None:
        """DISTANCE_SENSOR, looking down, cm; none where the bottom is not seen."""
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
        """NAV_CONTROLLER_OUTPUT: what is asked for less what is; its altitude is up. Degrees, m, m/s.

        The target, of which it has bearing and distance, is the place that is flown to, as guidance has it.
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

    def extended(self, cycle: Cycle) -> Message:
        """EXTENDED_SYS_STATE: disarmed it lies, surfacing it lands."""
        landed = _LANDED.get(cycle.mode.mode, dialect.MAV_LANDED_STATE_IN_AIR)
        return dialect.MAVLink_extended_sys_state_message(dialect.MAV_VTOL_STATE_UNDEFINED, landed)


def _heading(angle: float) -> int:
    return whole(math.degrees(wrap(angle)), 1.0, INT16)


def _quaternion(cycle: Cycle) -> tuple[float, float, float, float]:
    x, y, z, w = quaternion_from_euler(*_angles(cycle))
    return w, x, y, z


def _angles(cycle: Cycle) -> tuple[float, float, float]:
    """(phi, theta, psi), rad; what is infinite has no sine, and is unknown."""
    _, _, _, phi, theta, psi = cycle.state.eta
    return (phi, theta, psi) if math.isfinite(phi + theta + psi) else (math.nan, math.nan, math.nan)


def _covariance(*variances: float) -> list[float]:
    upper = [0.0] * _COVARIANCES
    for position, variance in zip(_DIAGONAL, variances, strict=True):
        upper[position] = variance
    return upper
