"""Consistency of the filter, compiled: windows over the normalised innovations squared (NIS), and divergence.

There is one exponential window each for DVL, gyro and attitude.
"""

from __future__ import annotations

import math

from firmware_py.compiled import Matrix, Vector, kernel

OUTLIER = 100.0
"""A NIS beyond this, or below 0, counts as this: one that is far out is forgotten with the window."""
GYRO = 1
"""Row of the gyros' window, between those of DVL and attitude."""
SUM, COUNT, SQUARES = 0, 1, 2
"""Columns of a sensor's window: the weighted NIS, the weights, their squares."""
BURST_WINDOW, BURST_COUNT_MIN, BURST_SIGMAS, BURST_PAUSE = 1.0, 60.0, 6.0, 5.0
"""The gyros' short window, s; the least weight that it tells something with; how far out, and for how long it is left
alone after that, s."""
WAIT = 2
"""Place in the short window."""
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
def add_burst(nis: Vector, h: float, burst: Vector) -> None:
    """Takes the NIS of a step of h (s), (9,), into the gyros' short window.

    Args:
        nis: see `add_nis`; u v w p q r phi theta psi.
        h: see nis.
        burst: changed, (3,): the weighted NIS, the weights, and for how long it is to be left alone, s.
    """
    fade = math.exp(-h / BURST_WINDOW)
    burst[SUM] *= fade
    burst[COUNT] *= fade
    burst[WAIT] = max(burst[WAIT] - h, 0.0)
    for i in range(3, 6):
        if not math.isnan(nis[i]):
            burst[SUM] += nis[i] if 0.0 <= nis[i] <= OUTLIER else OUTLIER
            burst[COUNT] += 1.0


@kernel()
def bursts(burst: Vector) -> bool:
    """Whether the mean NIS of the gyros' short window is beyond BURST_SIGMAS of what chance makes of it.

    The exponential window of weight n has the variance of n / 2 times two numbers: each NIS has the variance 2.
    """
    count = burst[COUNT]
    if burst[WAIT] > 0.0 or count < BURST_COUNT_MIN:
        return False
    above: bool = burst[SUM] - count > BURST_SIGMAS * math.sqrt(count)
    return above


@kernel()
def contradicts(window: Vector) -> bool:
    """Whether the measurements of one sensor in its window, (3,), contradict the filter."""
    count = window[COUNT]
    above: bool = count > NIS_COUNT_MIN and window[SUM] > NIS_DIVERGED * count
    return above


@kernel()
def diverged(window: Matrix) -> bool:
    """Whether a filter believes firmly what the measurements in its window, (3, 3), contradict."""
    return contradicts(window[0]) or contradicts(window[GYRO]) or contradicts(window[2])
