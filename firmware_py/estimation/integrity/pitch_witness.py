"""Pitch without an AHRS: from the velocity along the body and the rate of depth."""

from __future__ import annotations

import math


def pitch_from_velocity(phi: float, u: float, v: float, w: float, z_dot: float) -> float:
    """Return the pitch, rad, at which the body velocity (m/s) makes the depth grow by z_dot, m/s; NaN if none does.

    Solves z_dot = -u sin(theta) + (v sin(phi) + w cos(phi)) cos(theta), the third row of R_zyx (Fossen 2011, Eq. 2.18),
    for the pitch between -90 and 90 deg at which the vehicle moves ahead. phi is in rad.
    """
    a = v * math.sin(phi) + w * math.cos(phi)
    speed = math.hypot(u, a)
    if not (u > 0.0 and abs(z_dot) <= speed):
        return math.nan
    return math.atan2(a, u) - math.asin(z_dot / speed)
