"""SET_POSITION_TARGET_* as setpoints: position, depth and yaw, or a velocity as heading and speed.

Attitude, acceleration and yaw rate cannot be set: the control laws derive them from depth and heading.
"""

from __future__ import annotations

import math

from firmware_py.marine import Eta
from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.link_output import CommandRefused
from firmware_py.mavlink.base.water_frame import LOCAL, WaterFrame, within_range
from firmware_py.records.order import Setpoint

_NAN = math.nan
_E7 = 1e-7
_OFFSET: int = dialect.MAV_FRAME_LOCAL_OFFSET_NED
_IGNORE_POSITION, _IGNORE_DEPTH, _IGNORE_YAW = 1 | 2, 4, 1024
_IGNORE_VELOCITY, _IGNORE_REST = 8 | 16, 64 | 128 | 256 | 2048


def setpoint_of(m: Message, water_frame: WaterFrame, here: Eta) -> Setpoint:
    """Return the setpoint of a SET_POSITION_TARGET message; NaN for what its type_mask ignores.

    `here` is where the vehicle is: LOCAL_OFFSET_NED counts from there. (Stations change the depth with it, and offsets
    of 0 north and east.)

    Raises:
        CommandRefused: the vehicle cannot follow it.
    """
    mask, frame = m.type_mask, m.coordinate_frame
    depth = psi_d = u_d = x = y = _NAN
    local = m.get_msgId() == dialect.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED
    if local != (frame in (LOCAL, _OFFSET)):
        raise CommandRefused(f"frame {frame} is not supported; use a global frame, LOCAL_NED or LOCAL_OFFSET_NED")
    if mask & _IGNORE_REST != _IGNORE_REST:
        raise CommandRefused(f"type_mask {mask}: acceleration and yaw rate cannot be followed; ignore them")
    north, east, down = (here.x, here.y, here.z) if frame == _OFFSET else (0.0, 0.0, 0.0)
    if not mask & _IGNORE_POSITION and not (frame == _OFFSET and m.x == m.y == 0.0):  # where it is: only the depth
        position = local and within_range(north + m.x, east + m.y)
        x, y = position or water_frame.position(m.lat_int * _E7, m.lon_int * _E7)
    if not mask & _IGNORE_DEPTH:
        depth = water_frame.depth(LOCAL, down + m.z) if local else water_frame.depth(frame, m.alt)
    if not mask & _IGNORE_VELOCITY:
        u_d = speed_ahead(math.hypot(m.vx, m.vy))
        if math.isnan(x) and u_d > 0.0:
            psi_d = math.atan2(m.vy, m.vx)
    if not mask & _IGNORE_YAW and math.isnan(x):
        psi_d = heading(math.degrees(m.yaw))
    if all(map(math.isnan, (depth, psi_d, u_d, x))):
        raise CommandRefused(f"type_mask {mask} leaves nothing to follow")
    return Setpoint(depth, psi_d, u_d, x, y)


def speed_ahead(speed: float) -> float:
    """Return a speed, m/s, unchanged.

    Raises:
        CommandRefused: it is not a speed ahead.
    """
    if not 0.0 <= speed <= 100.0:
        raise CommandRefused(f"{speed:g} m/s is not a speed ahead")
    return speed


def heading(angle: float) -> float:
    """Return the heading, rad, of an angle in degrees.

    Raises:
        CommandRefused: it is not finite.
    """
    if not math.isfinite(angle):
        raise CommandRefused(f"{angle:g} deg is not a heading")
    return math.radians(angle % 360.0)
