"""What validity promises of a value: that later evidence leaves it within five of the sigmas reported with it.

While a coefficient is valid, every report of it bounds what it may become. A later value beyond the narrowest of these
bounds contradicts a report: the coefficient has changed (damage, a wrong model), or the sigma was too small.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.vehicle.vehicle import NEGATIVE

SIGMAS = 5.0
"""A later value may differ by so many of the sigmas of then."""


class ValueBounds(NamedTuple):
    """Between what each coefficient was promised to stay, (names,); infinite where it was never valid."""

    low: tuple[float, ...]
    high: tuple[float, ...]

    def hold(self, value: Sequence[float]) -> bool:
        """Return whether every value is within its bounds."""
        return all(low <= x <= high for low, x, high in zip(self.low, value, self.high, strict=True))

    def after(self, value: Sequence[float], std: Sequence[float], valid: Sequence[bool]) -> ValueBounds:
        """Return the bounds after a report of values, 1 sigmas and what of it is valid."""
        margins = [SIGMAS * sigma if ok else math.inf for sigma, ok in zip(std, valid, strict=True)]
        return ValueBounds(
            tuple([max(low, x - margin) for low, x, margin in zip(self.low, value, margins, strict=True)]),
            tuple([min(high, x + margin) for high, x, margin in zip(self.high, value, margins, strict=True)]),
        )


def unbounded(count: int) -> ValueBounds:
    """Return the bounds of coefficients that were never valid."""
    return ValueBounds((-math.inf,) * count, (math.inf,) * count)


def possible(names: Sequence[str], low: Sequence[float], high: Sequence[float]) -> ValueBounds:
    """Return between what each coefficient can be: in the filter's bounds, and of the sign that every vehicle has."""
    signed = [min(x, 0.0) if name in NEGATIVE else x for name, x in zip(names, high, strict=True)]
    return ValueBounds(tuple(low), tuple(signed))
