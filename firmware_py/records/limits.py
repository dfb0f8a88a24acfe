"""What the vehicle keeps to, as whoever takes orders for it has to know beforehand."""

from __future__ import annotations

from typing import NamedTuple

from firmware_py.records.turning import Turning


class OperatingLimits(NamedTuple):
    """The supervisor's greatest depth and least altitude, m, and how wide circles are flown."""

    depth_max: float
    altitude_min: float
    turning: Turning
