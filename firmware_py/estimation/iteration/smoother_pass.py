"""The reference filter of an iterated pass: it runs ahead of the bank and is smoothed."""

from __future__ import annotations

import numpy as np

from firmware_py.compiled import unchecked
from firmware_py.estimation.filter.bank_arrays import BankArrays
from firmware_py.estimation.filter.kernel_arguments import FilterBank, new_scratch, padded, zeros
from firmware_py.estimation.filter.measurement_history import MeasurementHistory
from firmware_py.estimation.iteration.rts_smoother import EDDY_STATES, reference_pass, smooth, smoothed
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.kernel_arguments import without_parameters
from firmware_py.estimation.model.prediction import load_parameters
from firmware_py.estimation.model.state import EDDIES, EDDY_NORTH, MOVING

BLOCK = 256
"""Rows whose motion is smoothed together, after as many more: the water is known by what follows in 2 or 3 s."""
RING = 3 * BLOCK
_reference_pass = unchecked(reference_pass)


class SmootherPass:
    """One filter to which coefficients, biases and the current are known; only motion and eddies are estimated.

    So its covariance ends where the parameters begin, and these are loaded into the model once, as a pass starts.

    Attributes:
        row: of the history, where it is.
        smoothed_to: the row up to which motion is smoothed.
        reference: the state that is known, (padded,); a pass moves in it what moves.
        path: smoothed motion and eddies before each row up to `smoothed_to`, (RING, states), at the row modulo RING.
    """

    def __init__(self, filters: BankArrays) -> None:
        """Makes room for a reference of these filters."""
        n, width, count = filters.model.first, filters.width, smoothed(filters.model.water)
        self._filters, self._loaded = filters, False
        self.bank: FilterBank = filters.kernel._replace(
            model=without_parameters(filters.kernel.model),
            tuning=filters.tuning._replace(Q=np.zeros(width), learns=np.zeros(width)),
            intensity=np.zeros(1),
            x=np.zeros((1, width)),
            P=zeros(1, n, padded(n)),
            scratch=new_scratch(padded(n)),
            log_likelihood=np.zeros(1),
            weights=np.zeros(1),
        )
        self._filtered, self._predicted = np.zeros((RING, count)), np.zeros((RING, count))
        self._gains = np.zeros((RING, count, count))
        self._scratch, self._moved = np.zeros((count, count)), np.zeros(count)
        self._nis, self._rejected = np.zeros(9), np.zeros(9, dtype=np.int64)
        self.reference, self.path = np.zeros(width), np.zeros((RING, count))
        self.row = self.smoothed_to = 0

    @property
    def row_max(self) -> int:
        """Where it stops until what it knows has been used."""
        return self.smoothed_to + 2 * BLOCK

    def start(self, mean: Array, most_likely: int) -> None:
        """Goes to the start of the history; the state `mean`, (n,), with the eddies of the most likely filter."""
        filters, own = self._filters, self.bank
        own.intensity[0] = filters.intensity[most_likely]
        own.tuning.Q[:], own.tuning.learns[:] = filters.tuning.Q, filters.tuning.learns
        own.tuning.learns[MOVING:] = 0.0
        own.tuning.Q[MOVING:] = 0.0
        self.reference[: len(mean)] = mean
        self.load()
        own.x[0] = self.reference
        own.P[:] = 0.0
        eddies = slice(EDDY_NORTH, EDDY_NORTH + EDDY_STATES)
        for moving in (slice(0, MOVING), eddies)[: 2 if filters.model.water == EDDIES else 1]:
            own.x[0, moving], own.P[0, moving, moving] = (
                filters.x[most_likely, moving],
                filters.P[most_likely, moving, moving],
            )
            own.tuning.learns[moving] = 1.0
        self.row = self.smoothed_to = 0

    def load(self) -> None:
        """Loads the parameters of the reference into the model, of these filters and its own."""
        self._loaded = load_parameters(self._filters.kernel.model, self.reference, self.bank.step)

    def run(self, history: MeasurementHistory, to: int) -> bool:
        """Goes on to that row of the history, no further than `row_max`; False if a number was not finite, or the
        parameters give no mass matrix."""
        first, self.row = self.row, max(self.row, min(to, self.row_max))
        kept = (self._filtered, self._predicted, self._gains, self._scratch, self._nis, self._rejected)
        finite = _reference_pass(self.bank, history, first, self.row, *kept)
        return finite and self._loaded

    def smooth_back(self, whole: bool) -> None:
        """Smooths what it went through: a block, or with `whole` all."""
        kept = (self._filtered, self._predicted, self._gains, self._moved, self.path)
        smooth(self.bank.x[0], self.smoothed_to, self.row, *kept)
        self.smoothed_to = self.row if whole else self.row - BLOCK

    @property
    def arrays(self) -> tuple[Array, ...]:
        """All that it remembers, but for its two rows."""
        return (
            *(self.bank.x, self.bank.P, self.bank.tuning.Q, self.bank.tuning.learns, self.bank.intensity),
            *(self._filtered, self._predicted, self._gains, self.reference, self.path),
        )
