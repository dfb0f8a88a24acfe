"""The current: the filter takes it for steady, until what is measured says that the water changes.

That it is steady makes coefficients certain, and wrong where it is not: a front is passed in seconds or in half a
minute. So where the gyros contradict the filter, or innovations have become greater than they should be, the current is
a random walk for some seconds. Innovations that are less, as whenever another coefficient begins to learn, tell nothing
of the water, and a current that walks without a cause takes what the sway explains. The passes through the flight take
it for steady too: they begin anew behind that. What acts through the flow is not learned meanwhile: from a speed that
nobody knows everything seems to do less than it does (N_v of a hull that went straight on, 130 sigma off, and valid).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.estimation.coefficient_ekf import CoefficientEkf

FRONT_TIME = 10.0
"""Once it has begun to change it may go on for so long, s: a hull of 5 m passes the sharpest front in three."""
FRONT_WALK = 0.1
"""By so much, 1 sigma, m/s/sqrt(s)."""
CALM, EDDIES_BEGIN = 0.005, 0.03
"""Eddies of more than the latter in water that had less than the former, m/s, may be a current that changes."""


class DoubtedWaterMemory(NamedTuple):
    """What is remembered.

    Attributes:
        until: when the current is steady again, s; -inf: it is.
        bursts: how often the gyros had contradicted the filter.
        trusted: whether innovations were what they should be.
        confirmed: how many coefficients passes had confirmed.
        calm: the least turbulence since a pass confirmed anything, or it last rose, m/s: eddies that are found in the
            beginning have always been there.
    """

    until: float = -math.inf
    bursts: int = 0
    trusted: bool = False
    confirmed: int = 0
    calm: float = math.inf


class DoubtedWater:
    """Tells a filter whether the current may change; `update` at a steady rate."""

    def __init__(self, ekf: CoefficientEkf) -> None:
        self._ekf, self._memory = ekf, DoubtedWaterMemory()

    def update(self, t: float, trusted: bool, surprised: bool, turbulence: float) -> None:
        """Let the current change, or be steady again.

        Args:
            t: now, s.
            trusted: whether innovations are what they should be.
            surprised: whether they are greater.
            turbulence: of the eddies that are likely, m/s.
        """
        m, ekf = self._memory, self._ekf
        until, confirmed = m.until, int(ekf.iterated.sum())
        rises = m.confirmed > 0 and m.calm < CALM and turbulence > EDDIES_BEGIN
        if ekf.bursts != m.bursts or (m.trusted and surprised) or confirmed < m.confirmed or rises:
            until = t + FRONT_TIME
        elif until <= t:
            until = -math.inf
        calm = turbulence if rises or not confirmed else min(m.calm, turbulence)
        self._memory = DoubtedWaterMemory(until, ekf.bursts, trusted, confirmed, calm)
        if (until > -math.inf) != (m.until > -math.inf):
            self._tell()
            if until == -math.inf:
                ekf.begin_history(near=True)

    @property
    def moves(self) -> bool:
        """Whether the current may change: what acts through the flow is held then."""
        return self._memory.until > -math.inf

    def freeze(self) -> DoubtedWaterMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: DoubtedWaterMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory
        self._tell()

    def _tell(self) -> None:
        walk = FRONT_WALK if self._memory.until > -math.inf else 0.0
        for filters in self._ekf.banks:
            filters.let_current_change(walk)
