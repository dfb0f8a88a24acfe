"""Whether a fin can be where its servo reports it.

An angle that no fin can have is no report: its servo counts in another unit, has lost its turn, or is broken, and tells
nothing of the fin. Taken for an angle it would be a jam at the end of the travel, and cost the drop weight.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from firmware_py.records.sensing import Heard

MARGIN = math.radians(15.0)
"""So far beyond the end of its travel a fin may be reported, rad.

One that is driven to its stop is named hard over, so it must be believed: the stop is some degrees beyond the travel,
and the horn sits a tooth off its zero (15 deg of a spline with 24 teeth).
"""
HOLD = 5.0
"""So long after an angle that cannot be, what the servo reports is not believed, s: it lies between two lies too."""


class FinReports:
    """Judges what the fins' servos report.

    Args:
        fins: names, in their order.
        reaches: the greatest angle to which each servo turns its fin, rad.
    """

    def __init__(self, fins: Sequence[str], reaches: Sequence[float]) -> None:
        self._names = tuple(fins)
        self._most = tuple([reach + MARGIN for reach in reaches])
        self._t_beyond = [-math.inf] * len(self._names)
        self._counts = [0] * len(self._names)

    @property
    def count(self) -> int:
        """Return how many fins there are."""
        return len(self._names)

    def judged(self, fin: int, heard: Heard[float], t: float) -> Heard[float]:
        """Return what was heard of a fin at t, s; not ok if it cannot be there, or could not be lately."""
        if not heard.ok:
            return heard
        if not -self._most[fin] <= heard.value <= self._most[fin]:
            self._t_beyond[fin] = t
            self._counts[fin] += 1
        elif t - self._t_beyond[fin] >= HOLD:
            return heard
        return Heard(heard.value, heard.t_valid, heard.fresh, False)

    def losses(self) -> dict[str, int]:
        """Return how often each fin was reported where it cannot be; fins of which that never happened are left out."""
        return {f"{name}_impossible_angles": n for name, n in zip(self._names, self._counts, strict=True) if n}
