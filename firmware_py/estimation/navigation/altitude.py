"""Altitude: the distance to the bottom, from altimeter or DVL."""

from __future__ import annotations

import math

from firmware_py.records.sensing import SensorFrame


def nearest(frame: SensorFrame, t: float, timeout: float) -> float:
    """Return the lesser of the two distances that are usable and not older than `timeout`, s, at the time t, s.

    It is in m; NaN without one. What is not finite, negative or from the future is not usable.
    """
    best, oldest = math.inf, t - timeout
    for heard, value in ((frame.altitude, frame.altitude.value), (frame.dvl, frame.dvl.value.altitude)):
        if heard.ok and oldest <= heard.t_valid <= t and 0.0 <= value < best:
            best = value
    return best if best < math.inf else math.nan
