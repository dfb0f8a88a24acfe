"""Whether a pass may take over: it has to explain the flight about as well as the running bank does.

A pass may diverge and converge all the same, far from the measurements: 386 less of log-likelihood over 20,000 of them
is 4 % of their mean NIS, which no window shows.
"""

from __future__ import annotations

import enum
import math

from firmware_py.estimation.model.jacobians import Array

EVIDENCE_LOST = 50.0
"""A pass is rejected if its best filter's log-likelihood is less by more than this than the running bank's best.

Both have seen the same measurements from the same beginning, so they differ by where they end: a bank whose
coefficients are off by z_1, z_2, ... of their sigmas has sum z^2 / 2 less. 50 is
ten coefficients, 3.2 sigma off each: more than linearisation explains. Passes that ended right had -13 to +261 more,
those that ended wrong 184 to 897 less."""


class Verdict(enum.Enum):
    """What became of a pass when it came to the end of the history."""

    NONE = enum.auto()
    """It did not, or is to be repeated."""
    ACCEPTED = enum.auto()
    REJECTED = enum.auto()


class Evidence:
    """The running bank's log-likelihood over the history, whatever resets have taken of it.

    `lost` is what they have taken since the history began; it fades as the log-likelihoods do, with `memory` (s).
    """

    def __init__(self, memory: float) -> None:
        self._memory, self.lost = memory, 0.0

    def fade(self, time: float) -> None:
        """So much time, s, has gone."""
        self.lost *= math.exp(-time / self._memory)

    def enough(self, passed: Array, running: Array) -> bool:
        """Return whether a pass, by the log-likelihoods of its filters, explains what the running bank's do."""
        return float(passed.max()) >= float(running.max()) + self.lost - EVIDENCE_LOST
