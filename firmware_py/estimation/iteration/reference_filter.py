"""The reference filter of an iterated pass: about its motion the slopes are taken.

It knows at each row what was measured up to there, and nothing of what follows. A smoothed motion would be nearer to
the true one, but it must not be: what the eddies did is known afterwards by how the vehicle answered, so slopes about
them would tell a coefficient what it has to explain. Where little but eddies moves the vehicle, coefficients of the
flow then grow and eddies shrink, in every pass more, and weaker eddies than there are become the most likely
(README.md).
"""

from __future__ import annotations

import numpy as np

from firmware_py.estimation.filter.bank_arrays import BankArrays
from firmware_py.estimation.filter.kernel_arguments import FilterBank, new_scratch, padded, zeros
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.kernel_arguments import without_parameters
from firmware_py.estimation.model.prediction import load_parameters
from firmware_py.estimation.model.state import EDDIES, EDDY_NORTH, MOVING, WATER_END


class ReferenceFilter:
    """One filter to which coefficients, biases and the current are known; only motion and eddies are estimated.

    So its covariance ends where the parameters begin, and these are loaded into the model once, as a pass starts.

    Attributes:
        bank: the filter, for `relinearised_pass`; its model and its linearised step are those of the filters.
        loaded: whether its parameters give a mass matrix.
    """

    def __init__(self, filters: BankArrays) -> None:
        """Makes room for a reference of these filters."""
        n, width = filters.model.first, filters.width
        self._filters, self.loaded = filters, False
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

    def start(self, mean: Array, most_likely: int) -> None:
        """Goes to the start of the history; the state `mean`, (n,), with the eddies of the most likely filter."""
        filters, own = self._filters, self.bank
        own.intensity[0] = filters.intensity[most_likely]
        own.tuning.Q[:], own.tuning.learns[:] = filters.tuning.Q, filters.tuning.learns
        own.tuning.learns[MOVING:] = 0.0
        own.tuning.Q[MOVING:] = 0.0
        own.x[0, : len(mean)] = mean
        self.load()
        own.P[:] = 0.0
        eddies = slice(EDDY_NORTH, WATER_END)
        for moving in (slice(0, MOVING), eddies)[: 2 if filters.model.water == EDDIES else 1]:
            own.x[0, moving], own.P[0, moving, moving] = (
                filters.x[most_likely, moving],
                filters.P[most_likely, moving, moving],
            )
            own.tuning.learns[moving] = 1.0

    def load(self) -> None:
        """Loads its parameters into the model, of these filters and its own."""
        self.loaded = load_parameters(self._filters.kernel.model, self.bank.x[0], self.bank.step)

    @property
    def arrays(self) -> tuple[Array, ...]:
        """All that it remembers."""
        return self.bank.x, self.bank.P, self.bank.tuning.Q, self.bank.tuning.learns, self.bank.intensity
