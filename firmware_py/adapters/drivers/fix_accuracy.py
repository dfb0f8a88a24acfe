"""How accurate a satellite fix is, where its receiver tells its dilution of precision alone, or nothing."""

from __future__ import annotations

import math

RANGE_STD = 5.0
"""1 sigma of a receiver's measured distances, m, for one that tells its dilution alone. Ours: without corrections."""
UNKNOWN_STD = 10.0
"""1 sigma of a fix whose receiver tells nothing, m. Ours: few satellites, a dilution of 2."""
LEAST_STD = 0.1
"""No fix is taken to be better than this, m: what antenna and time of validity leave. Ours."""


def of_dilution(dilution: float) -> float:
    """Return 1 sigma of each axis, m, from a horizontal or greater dilution; NaN where it is not known."""
    return at_least(dilution * RANGE_STD) if 0.0 < dilution < math.inf else math.nan


def at_least(std: float) -> float:
    """Return 1 sigma, m, no better than a fix can be; NaN and what is not positive as it is."""
    return max(std, LEAST_STD) if std > 0.0 else std


def of_variance(variance: float, dilution: float) -> float:
    """Return 1 sigma of each axis, m, from a variance, m^2; where it is 0 or NaN, from a dilution if that is known.

    NaN of a negative variance, inf of an infinite one.
    """
    if variance < 0.0:
        return math.nan
    if variance > 0.0:
        return at_least(math.sqrt(variance))
    std = of_dilution(dilution)
    return UNKNOWN_STD if math.isnan(std) else std
