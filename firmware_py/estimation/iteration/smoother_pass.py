"""The scout: a filter that goes ahead of a review, and tells where the boat and the water went."""

from __future__ import annotations

import numpy as np

from firmware_py.estimation.filter.bank_arrays import BankArrays
from firmware_py.estimation.filter.measurement_update import EDDY
from firmware_py.estimation.filter.start_up import GROWTH, LEARNS
from firmware_py.estimation.iteration.rts_smoother import WAVERING, scout, smooth, smoothed
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.prediction import EDDIES
from firmware_py.estimation.model.transition import MOVING

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

    def __init__(self, members: BankArrays) -> None:
        """Makes room for a scout ahead of `members`."""
        n, width, count = members.x.shape[1], members.rules.shape[1], smoothed(members.model.water)
        self._members = members
        self._x, self._P, self._rules = np.zeros((1, width)), np.zeros((1, n, width)), np.zeros_like(members.rules)
        self._eddy = np.zeros(1)
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
        """Goes to the tape's beginning, where its members are; the state `mean`, (n,), in the eddies of a member."""
        bank = self._members
        self._eddy[0] = bank.eddies[leader]
        self._rules[:] = bank.rules
        self._rules[LEARNS, MOVING:] = 0.0
        self._rules[GROWTH, MOVING:] = 0.0
        self.about[: len(mean)] = mean
        self._x[0] = self.about
        self._P[:] = 0.0
        eddies = slice(EDDY, EDDY + WAVERING)
        for moving in (slice(0, MOVING), eddies)[: 2 if bank.model.water == EDDIES else 1]:
            self._x[0, moving], self._P[0, moving, moving] = bank.x[leader, moving], bank.P[leader, moving, moving]
            self._rules[LEARNS, moving] = 1.0
        self.row = self.known = 0

    def go(self, tape: Array, to: int) -> bool:
        """Goes on to that row of the tape, no further than its goal; False if a number was not finite."""
        begin, self.row = self.row, max(self.row, min(to, self.goal))
        kept = (self._filtered, self._predicted, self._gains, self._scratch, self._nis, self._rejected)
        going: bool = scout(
            *self._members.alone(self._rules, self._eddy, self._x, self._P, tape, begin, self.row, *kept)
        )
        return going

    def look_back(self, whole: bool) -> None:
        """Smooths what it went through: a block, or with `whole` all."""
        kept = (self._filtered, self._predicted, self._gains, self._moved, self.path)
        smooth(self._x[0], self.known, self.row, *kept)
        self.known = self.row if whole else self.row - BLOCK

    @property
    def arrays(self) -> tuple[Array, ...]:
        """All that it remembers, but for its two rows."""
        return (
            *(self._x, self._P, self._rules, self._eddy),
            *(self._filtered, self._predicted, self._gains, self.about, self.path),
        )
