"""The local frame on the earth and the water surface: what heights and places of a station are in the vehicle's frame.

Heights become depths: an AMSL height counts from mean sea level, a relative altitude from the water surface. A height
above the surface is no depth and is refused.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.marine import Origin, geodetic_to_local
from firmware_py.mavlink.base.codec import dialect
from firmware_py.mavlink.base.link_output import NO_FRAME, CommandRefused

AMSL = (dialect.MAV_FRAME_GLOBAL, dialect.MAV_FRAME_GLOBAL_INT)
RELATIVE = (dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT, dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT)
LOCAL: int = dialect.MAV_FRAME_LOCAL_NED
_SURFACE_TOLERANCE = 0.01
"""A height of so little above the surface, m, is rounding."""
_MAX_DISTANCE = 1e5
"""A position farther from the origin, m, is refused."""


class WaterFrame(NamedTuple):
    """The local frame's origin on the earth, and the water surface above mean sea level, m."""

    origin: Origin
    surface: float

    def depth(self, frame: int, height: float) -> float:
        """Return the depth, m, of a height in a MAV_FRAME; NaN for NaN.

        Raises:
            CommandRefused: the height is above the water, or the frame has no such height.
        """
        if frame in AMSL:
            depth = self.surface - height
        elif frame in RELATIVE:
            depth = -height
        elif frame == LOCAL:
            depth = height
        else:
            raise CommandRefused(f"frame {frame} is not supported; use a global frame or LOCAL_NED", NO_FRAME)
        if math.isinf(depth) or depth < -_SURFACE_TOLERANCE:
            raise CommandRefused(f"{-depth:.2f} m above the water is not a depth")
        return max(depth, 0.0) if math.isfinite(depth) else math.nan

    def position(self, latitude: float, longitude: float) -> tuple[float, float]:
        """Return (x, y), m, of latitude and longitude in degrees.

        Raises:
            CommandRefused: it is not a position on the earth, or too far from the origin.
        """
        if not (abs(latitude) <= 90.0 and abs(longitude) <= 180.0):
            raise CommandRefused(f"{latitude:g}, {longitude:g} is not a position")
        return within_range(*geodetic_to_local(self.origin, math.radians(latitude), math.radians(longitude)))


def within_range(x: float, y: float) -> tuple[float, float]:
    """Return (x, y), m, unchanged.

    Raises:
        CommandRefused: it is too far from the origin.
    """
    if not math.hypot(x, y) <= _MAX_DISTANCE:
        raise CommandRefused(f"the position is not within {_MAX_DISTANCE / 1000.0:g} km of the origin")
    return x, y
