"""Attitudes as their devices tell them, and turned to other axes; quaternions are (x, y, z, w), as in `marine`."""

from __future__ import annotations

import math
from typing import TypeAlias

from firmware_py.adapters.drivers.driver import Reading
from firmware_py.marine import euler_from_quaternion, quaternion_from_euler
from firmware_py.records.sensing import Ahrs, Heard

Quaternion: TypeAlias = tuple[float, float, float, float]
Three: TypeAlias = tuple[float, float, float]
_NO_ANGLES: Three = (math.nan, math.nan, math.nan)
_NO_QUATERNION: Quaternion = (math.nan, math.nan, math.nan, math.nan)


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the quaternion of the rotation b followed by a."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def scalar_last(quaternion: Quaternion) -> Quaternion:
    """Return (x, y, z, w) of (w, x, y, z)."""
    w, x, y, z = quaternion
    return x, y, z, w


def from_angles(angles: Three) -> Quaternion:
    """Return the quaternion of roll, pitch, yaw, rad; NaN where one of them is not finite: infinity has no sine."""
    return quaternion_from_euler(*angles) if math.isfinite(sum(angles)) else _NO_QUATERNION


def ahrs(angles: Three, quaternion: Quaternion, rates: Three, t: float, ok: bool) -> Reading:
    """Return the reading of an AHRS, valid at t, s.

    Args:
        angles: roll, pitch, yaw, rad, north, east, down; used where the quaternion is not known. None is known where
            one is not finite, as of a filter that has run away.
        quaternion: from axes forward, to starboard, down to north, east, down.
        rates: about these axes, rad/s.
        t: time of validity, s.
        ok: the device vouches for it. Without its rates an attitude is of no use: it is not ok.
    """
    turned = euler_from_quaternion(*quaternion)
    if not math.isfinite(sum(turned)):
        turned = angles if math.isfinite(sum(angles)) else _NO_ANGLES
    value = Ahrs(*turned, *rates)
    return Reading("ahrs", 0, Heard(value, t, True, ok and math.isfinite(sum(value))))
