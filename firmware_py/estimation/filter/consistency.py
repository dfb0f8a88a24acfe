"""Exponential windows over the normalised innovations squared (NIS) of DVL, gyro and attitude, compiled."""

from __future__ import annotations

import math

from firmware_py.compiled import kernel
from firmware_py.estimation.model.jacobians import Array

OUTLIER = 100.0
"""A NIS beyond this, or below 0, counts as this: one that is far out is forgotten with the window."""
SUM, COUNT, SQUARES = 0, 1, 2
"""Columns of a sensor's window: the weighted NIS, the weights, their squares."""


@kernel("void(f8[::1],f8,f8[:,::1])")
def hear(nis: Array, fade: float, window: Array) -> None:
    """Takes the NIS of a step, (9,), into the exponential windows of the sensors, (3, 3)."""
    for sensor in range(3):
        window[sensor, SUM] *= fade
        window[sensor, COUNT] *= fade
        window[sensor, SQUARES] *= fade * fade
        for i in range(3 * sensor, 3 * sensor + 3):
            if not math.isnan(nis[i]):
                window[sensor, SUM] += nis[i] if 0.0 <= nis[i] <= OUTLIER else OUTLIER
                window[sensor, COUNT] += 1.0
                window[sensor, SQUARES] += 1.0
