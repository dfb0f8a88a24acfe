"""The reference filter of an iterated pass: it runs ahead of the bank and is smoothed."""

from __future__ import annotations

import numpy as np

from firmware_py.estimation.filter.bank_arrays import BankArrays
from firmware_py.estimation.filter.kernel_arguments import FilterBank
from firmware_py.estimation.iteration.measurement_history import MeasurementHistory
from firmware_py.estimation.iteration.rts_smoother import EDDY_STATES, reference_pass, smooth, smoothed
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.state import EDDIES, EDDY_NORTH, MOVING

BLOCK = 256
"""Rows whose motion is smoothed together, after as many more: the water is known by what follows in 2 or 3 s."""
RING = 3 * BLOCK


class SmootherPass:
    """One filter to which coefficients, biases and the current are known; only motion and eddies are not.

    Attributes:
        row: of the tape, where it is.
        known: up to where the smoothed motion is.
        about: the state that is known, (padded,); a review moves in it what moves.
        path: the smoothed motion and eddies before each row up to `known`, (RING, states), at the row modulo RING.
    """

    def __init__(self, filters: BankArrays) -> None:
        """Makes room for a reference of these filters."""
        n, width, count = filters.model.size, filters.width, smoothed(filters.model.water)
        self._filters = filters
        self.bank: FilterBank = filters.kernel._replace(
            tuning=filters.tuning._replace(Q=np.zeros(width), learns=np.zeros(width)),
            intensity=np.zeros(1),
            x=np.zeros((1, width)),
            P=np.zeros((1, n, width)),
            log_likelihood=np.zeros(1),
            weights=np.zeros(1),
        )
        self._filtered, self._predicted = np.zeros((RING, count)), np.zeros((RING, count))
        self._gains = np.zeros((RING, count, count))
        self._scratch, self._moved = np.zeros((count, count)), np.zeros(count)
        self._nis, self._rejected = np.zeros(9), np.zeros(9, dtype=np.int64)
        self.about, self.path = np.zeros(width), np.zeros((RING, count))
        self.row = self.known = 0

    @property
    def goal(self) -> int:
        """Where it stops until what it knows has been used."""
        return self.known + 2 * BLOCK

    def begin(self, mean: Array, leader: int) -> None:
        """Goes to the start of the history; the state `mean`, (n,), with the eddies of filter `leader`."""
        filters, own = self._filters, self.bank
        own.intensity[0] = filters.intensity[leader]
        own.tuning.Q[:], own.tuning.learns[:] = filters.tuning.Q, filters.tuning.learns
        own.tuning.learns[MOVING:] = 0.0
        own.tuning.Q[MOVING:] = 0.0
        self.about[: len(mean)] = mean
        own.x[0] = self.about
        own.P[:] = 0.0
        eddies = slice(EDDY_NORTH, EDDY_NORTH + EDDY_STATES)
        for moving in (slice(0, MOVING), eddies)[: 2 if filters.model.water == EDDIES else 1]:
            own.x[0, moving], own.P[0, moving, moving] = filters.x[leader, moving], filters.P[leader, moving, moving]
            own.tuning.learns[moving] = 1.0
        self.row = self.known = 0

    def go(self, history: MeasurementHistory, to: int) -> bool:
        """Goes on to that row of the history, no further than its goal; False if a number was not finite."""
        begin, self.row = self.row, max(self.row, min(to, self.goal))
        kept = (self._filtered, self._predicted, self._gains, self._scratch, self._nis, self._rejected)
        going: bool = reference_pass(self.bank, history, begin, self.row, *kept)
        return going

    def look_back(self, whole: bool) -> None:
        """Smooths what it went through: a block, or with `whole` all."""
        kept = (self._filtered, self._predicted, self._gains, self._moved, self.path)
        smooth(self.bank.x[0], self.known, self.row, *kept)
        self.known = self.row if whole else self.row - BLOCK

    @property
    def arrays(self) -> tuple[Array, ...]:
        """All that it remembers, but for its two rows."""
        return (
            *(self.bank.x, self.bank.P, self.bank.tuning.Q, self.bank.tuning.learns, self.bank.intensity),
            *(self._filtered, self._predicted, self._gains, self.about, self.path),
        )
