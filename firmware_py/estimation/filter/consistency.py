"""Consistency of the filter, compiled: windows over the normalised innovations squared (NIS), and divergence.

There is one exponential window each for DVL, gyro and attitude.
"""

from __future__ import annotations

import math

from firmware_py.compiled import Matrix, Vector, kernel

OUTLIER = 100.0
"""A NIS beyond this, or below 0, counts as this: one that is far out is forgotten with the window."""
SUM, COUNT, SQUARES = 0, 1, 2
"""Columns of a sensor's window: the weighted NIS, the weights, their squares."""
NIS_WINDOW, NIS_COUNT_MIN, NIS_DIVERGED = 3.0, 20.0, 3.0
"""A mean NIS (1 expected) beyond the last, over so many s and from so many measurements, is divergence."""


@kernel()
def add_nis(nis: Vector, fade: float, window: Matrix) -> None:
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


@kernel()
def diverged(window: Matrix) -> bool:
    """Whether a filter believes firmly what the measurements in its window, (3, 3), contradict."""
    for sensor in range(3):
        count = window[sensor, COUNT]
        if count > NIS_COUNT_MIN and window[sensor, SUM] > NIS_DIVERGED * count:
            return True
    return False
