"""Altitude: the distance to the bottom, from altimeter or DVL."""

from __future__ import annotations

import math

from firmware_py.records.sensing import SensorFrame


def newest(frame: SensorFrame, t: float, timeout: float) -> float:
    """Return the newer of the two distances that is usable and not older than `timeout`, s, at the time t, s.

    It is in m; NaN without one. What is not finite, negative or from the future is not usable.
    """
    best, newest_t = math.nan, t - timeout
    for heard, value in ((frame.altitude, frame.altitude.value), (frame.dvl, frame.dvl.value.altitude)):
        if heard.ok and newest_t <= heard.t_valid <= t and 0.0 <= value < math.inf:
            best, newest_t = value, heard.t_valid
    return best
