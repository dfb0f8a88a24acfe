"""Attitudes as their devices tell them, and turned to other axes; quaternions are (x, y, z, w), as in `marine`."""

from __future__ import annotations

import math
from typing import TypeAlias

from firmware_py.adapters.drivers.driver import Reading
from firmware_py.marine import euler_from_quaternion
from firmware_py.records.sensing import Ahrs, Heard

Quaternion: TypeAlias = tuple[float, float, float, float]
Three: TypeAlias = tuple[float, float, float]


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


def ahrs(angles: Three, quaternion: Quaternion, rates: Three, t: float, ok: bool) -> Reading:
    """Return the reading of an AHRS, valid at t, s.

    Args:
        angles: roll, pitch, yaw, rad, north, east, down; used where the quaternion is not known.
        quaternion: from axes forward, to starboard, down to north, east, down.
        rates: about these axes, rad/s.
        t: time of validity, s.
        ok: the device vouches for it. Without its rates an attitude is of no use: it is not ok.
    """
    turned = euler_from_quaternion(*quaternion)
    value = Ahrs(*(turned if math.isfinite(sum(turned)) else angles), *rates)
    return Reading("ahrs", 0, Heard(value, t, True, ok and math.isfinite(sum(value))))
