"""Second sight: a flight gone through again, with slopes drawn about what it has taught.

An extended Kalman filter draws its slopes about what it believes at the moment, and while it still learns, that is
wrong: it ends up off, and too sure of it. But what it was given is on tape. So when it knows more, another bank begins
where the tape does, with all the doubt that there was then, and is given everything again. Its slopes lie about one
motion: the likeliest, if coefficients and current are what they are now believed to be; a scout goes ahead and finds
it. This is a Gauss-Newton step over the whole flight (the iterated filter, Bell and Cathey 1993), and is repeated until
it moves nothing: a few rows of tape with every step, until it has caught up. Then it takes over.

The first review does not trust the filter. It begins with what was believed in the beginning, and with so much noise
on the velocities that wrong slopes do little harm; then it does with less and less of it (continuation).
"""

from __future__ import annotations

import math

import numpy as np

from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.coefficient_records import Flags, ReviewMemory
from firmware_py.estimation.filter.bank_arrays import BankArrays
from firmware_py.estimation.filter.start_up import FLOOR, GROWTH, LEARNS, MAY, STIRRED, STIRS
from firmware_py.estimation.iteration.measurement_history import ROW, write
from firmware_py.estimation.iteration.relinearised_pass import relive
from firmware_py.estimation.iteration.smoother_pass import SmootherPass
from firmware_py.estimation.model.jacobians import Array

PACE = 8
"""Rows of tape that are gone through with every step made."""
DENSE = 150.0
"""Room on the tape: so many steps in a second, for as long as the last review takes."""
PATIENCE = 1.0
"""A tape that is by so many s longer than the bank waits, and on which nothing was learned, begins anew."""
CONVERGED = 4.0
"""A review has come to rest if no coefficient has moved by so many sigmas; else the tape is gone through once more. By
what was written meanwhile alone, one of ten moves by 2 or 3."""
SETTLED = 50.0
"""So many of its time constants after its beginning, a bank is settled."""
STAGES = (1.0, 0.3, 0.1, 0.03, 0.0)
"""Parts of the next two that a review reckons with, one after the other, each until it rests: far from the truth."""
STRAY = 0.05, math.radians(1.0)
"""Random walk of velocities by sqrt(s), m/s and rad/s: about what slopes of coefficients that are half wrong leave."""
LAST = len(STAGES) - 1
REMAINS = 0.1
"""Of what wavering water stirs up in the beginning, so much is left even about the smoothed motion, whose eddies are a
sixth of them off."""
ENDLESS = 1 << 40
BY_ITSELF = np.zeros(4)


class IteratedFilter:
    """Keeps the tape, and lets a bank that has gone through it again take over.

    Attributes:
        used: rows of the tape that are written.
        running: whether it keeps a tape.
        taken: how often its bank took over.
    """

    def __init__(self, members: BankArrays, params: CoefficientParams) -> None:
        """Makes room; `members` are its own, like those that it reviews."""
        self._bank, self._start = members, members.copy()
        self._ages, self._wait, self._settled = params.reviews, params.wait, params.wait + SETTLED * params.settling
        longest = max(params.reviews, default=0.0) * PACE / (PACE - 1)
        self._tape = np.zeros((math.ceil(longest * DENSE), ROW))
        (count, n), width = members.x.shape, members.rules.shape[1]
        self._scout = SmootherPass(members)
        self._mean, self._may = np.zeros(n), np.zeros(width)
        """The values that it began with, and which states may learn."""
        self._window, self._poor = np.zeros((3, 3)), np.zeros(1)
        self._stage, self._sound = LAST, False
        """Of STAGES, where the review is; and whether the last one ended well."""
        self._apart, self._nis, self._rejected = np.zeros((count, width)), np.zeros(9), np.zeros(9, dtype=np.int64)
        self.used, self._span, self._turn, self._row = 0, 0.0, 0, -1
        self._age, self._fruitful, self.running, self.taken = 0.0, False, False, 0

    @property
    def tape(self) -> Array:
        """What steps are written on, from row `used` on; without a row when none is kept."""
        return self._tape if self.running else self._tape[:0]

    def settled(self, age: float) -> bool:
        """Whether a bank of that age (s) has been reviewed, or never will be."""
        return not self.running or age >= self._settled

    def begin(self, bank: BankArrays, age: float) -> None:
        """The tape begins here; `age` (s) of the bank is that of `settling.settle`."""
        self.running = len(self._tape) > 0
        if self.running:
            self._start = bank.copy()
        self.used, self._span, self._turn, self._row = 0, 0.0, 0, -1
        self._age, self._fruitful, self._sound = age, False, False

    def learning(self, bank: BankArrays, age: float) -> None:
        """A coefficient may learn for the first time: a tape is wanted, if there is none."""
        if not self.running:
            self.begin(bank, age)

    def resumed(self, motion: Array, variance: Array) -> None:
        """The bank began anew in motion, (9,), known to `variance`, (9,)."""
        if self.running and self.used < len(self._tape):
            write(self._tape, self.used, 0.0, BY_ITSELF, motion, variance)
            self.used += 1

    def free(self, h: float) -> int:
        """How many steps of h (s) may be made before `passed` is to be told."""
        if not self.running:
            return ENDLESS
        if self._row >= 0:
            scout = self._scout
            ahead = min(_over(scout.goal - scout.row, PACE), _over(self.used - scout.row, PACE - 1))
            return max(_over(scout.known - self._row, PACE), ahead, 1)
        mark = self._ages[self._turn] if self._fruitful else self._wait + PATIENCE
        return max(math.ceil((mark - self._span) / h - 1e-6), 1)

    def passed(self, bank: BankArrays, steps: int, h: float, age: Array, begun: Flags) -> bool:
        """Follows `steps` steps of h (s), no more than were free.

        Args:
            bank: which is reviewed; changed when its review takes over.
            steps: see above.
            h: see above.
            age: (1,), see `settling.settle`; changed likewise.
            begun: which of the learned coefficients have had cause to learn, (names,).

        Returns:
            Whether the bank was changed.
        """
        if not self.running:
            return False
        self.used += steps
        self._span += steps * h
        if self.used > len(self._tape):
            self.running = False
        elif self._row >= 0:
            return self._catch_up(bank, steps, age, begun)
        elif not self._fruitful:
            self._fruitful = age[0] > max(self._age, self._wait) + h
            if not self._fruitful and self._span > self._wait + PATIENCE - 0.5 * h:
                self.begin(bank, age[0])
        elif self._span > self._ages[self._turn] - 0.5 * h:
            self._may[:] = bank.rules[MAY]
            if self._sound:
                self._stage = LAST
                self._rewind(bank.blend()[0], int(bank.evidence.argmax()), begun)
            else:
                self._stage = 0
                self._rewind(self._start[0][0], int(bank.eddies.argmax()), begun)
        return False

    def _catch_up(self, bank: BankArrays, steps: int, age: Array, begun: Flags) -> bool:
        """Goes on; at the end of the tape, takes over or begins again."""
        mine, scout, far = self._bank, self._scout, PACE * steps
        going = self._go(min(self._row + far, scout.known)) and scout.go(self._tape, min(scout.row + far, self.used))
        at_end = scout.row == self.used
        if going and self._row == scout.known and (at_end or scout.row == scout.goal):
            scout.look_back(whole=at_end)
            if self.used - self._row <= PACE:
                going = self._go(self.used)
        if going and self._row < self.used:
            return False
        if going:
            mean, std, _ = mine.blend()
            first = mine.model.first
            learned = slice(first, first + len(begun))
            rests = bool((np.abs(mean - self._mean)[learned] <= CONVERGED * std[learned]).all())
            if not rests or self._stage < LAST:
                self._stage += rests
                self._rewind(mean, int(mine.evidence.argmax()), begun)
                return False
            going = self._poor[0] == 0.0
        if going:
            bank.take(mine.x, mine.P, mine.evidence)
            age[0] = max(age[0], self._settled)
            self.taken += 1
        self._sound = going
        self._row = -1
        while self._turn < len(self._ages) and self._ages[self._turn] <= self._span:
            self._turn += 1
        self.running = self._turn < len(self._ages)
        return going

    def _go(self, to: int) -> bool:
        """Takes the bank to that row, up to which the scout knows the motion; False if it cannot go on."""
        scout, begin, self._row = self._scout, self._row, to
        told = (scout.path, scout.about, self._apart, self._nis, self._rejected, self._window, self._poor)
        going: bool = relive(*self._bank.arguments(self._tape, begin, to, *told))
        return going

    def _rewind(self, mean: Array, leader: int, begun: Flags) -> None:
        """Goes back to where the tape begins, to draw slopes about the `mean`, (n,), in the eddies of that member."""
        mine, first = self._bank, self._bank.model.first
        mine.take(*self._start)
        names = slice(first, first + len(begun))
        mine.rules[MAY] = self._may
        mine.rules[MAY, names] = np.maximum(self._may[names], begun)
        mine.rules[LEARNS] = mine.rules[MAY]
        mine.rules[GROWTH] = mine.rules[FLOOR] * mine.rules[MAY]
        mine.rules[STIRS] = REMAINS**2 * mine.rules[STIRRED]
        for moving, walk in zip((slice(0, 3), slice(3, 6)), STRAY, strict=True):
            mine.rules[GROWTH, moving] += (STAGES[self._stage] * walk) ** 2
        self._scout.begin(mean, leader)
        self._mean[:] = mean
        self._window[:], self._poor[:] = 0.0, 0.0
        self._row = 0

    @property
    def _arrays(self) -> tuple[Array, ...]:
        return (*self._scout.arrays, self._bank.rules, self._mean, self._may, self._window, self._poor)

    def freeze(self) -> ReviewMemory:
        """All it remembers."""
        return ReviewMemory(
            self._tape[: self.used].copy(),
            self._start,
            self._bank.copy(),
            tuple(array.copy() for array in self._arrays),
            self._span,
            self._turn,
            self._row,
            (self._scout.row, self._scout.known),
            self._stage,
            self._sound,
            self._age,
            self._fruitful,
            self.running,
            self.taken,
        )

    def thaw(self, memory: ReviewMemory) -> None:
        """Takes up again what `freeze` gave."""
        self.used = len(memory.tape)
        self._tape[: self.used] = memory.tape
        self._start = memory.start
        self._bank.take(*memory.bank)
        for mine, its in zip(self._arrays, memory.arrays, strict=True):
            mine[:] = its
        self._span, self._turn, self._row = memory.span, memory.turn, memory.row
        self._scout.row, self._scout.known = memory.scout
        self._stage, self._sound = memory.stage, memory.sound
        self._age, self._fruitful = memory.age, memory.fruitful
        self.running, self.taken = memory.running, memory.taken


def _over(rows: int, pace: int) -> int:
    """How many steps those rows take."""
    return -(-rows // pace)
