"""The iterated filter: it goes through the flight again, linearised about what has been learned since.

An extended Kalman filter takes its slopes about what it believes at the moment, and while it still learns, that is
wrong: it ends up off, and too sure of it. But what it was given is kept. So when it knows more, another bank begins
where the measurement history does, with all the doubt that there was then, and is given everything again. Its slopes
lie about one motion: the most likely, if coefficients and current are what they are now believed to be; a reference
filter finds it. This is a Gauss-Newton step over the whole flight (Bell and Cathey 1993), and is repeated until it
moves nothing (line_search.py): a few rows of the history with every step, until it has caught up. Then it takes over.

The first pass does not trust the filter. It begins with what was believed in the beginning, and with so much process
noise on the velocities that wrong slopes do little harm; then with less and less of it (continuation).

A pass may diverge and converge all the same, on something that is far from the measurements. So it has to explain the
flight about as well as the running bank does (`EVIDENCE_LOST`), else it is rejected: the bank goes on, nothing that was
learned counts as confirmed any longer, and the iteration begins with its first stage again.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_py.compiled import Flags, unchecked
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.coefficient_records import IterationMemory
from firmware_py.estimation.filter.bank_arrays import BankArrays
from firmware_py.estimation.filter.measurement_history import MeasurementHistory, new_history, record
from firmware_py.estimation.iteration.acceptance import Evidence, Verdict
from firmware_py.estimation.iteration.line_search import ENDLESS, LineSearch, small
from firmware_py.estimation.iteration.reference_filter import ReferenceFilter
from firmware_py.estimation.iteration.relinearised_pass import relinearised_pass
from firmware_py.estimation.iteration.stages import FIRST_INTENSITY, LAST, set_noise
from firmware_py.estimation.model.jacobians import Array

ROWS_PER_STEP = 8
"""Rows of the history that are gone through with every step made."""
RATE_MAX = 150.0
"""Room in the history: so many steps in a second, for as long as the last iteration takes."""
PATIENCE = 1.0
"""A history that is by so many s longer than the learning delay, and in which nothing was learned, begins anew."""
STARTUP_TIMES = 50.0
"""So many of its time constants after its beginning, a bank's start-up is over."""
NO_INPUTS = np.zeros(4)
_relinearised_pass = unchecked(relinearised_pass)


class IteratedFilter:
    """Keeps the measurement history, and lets a bank that has gone through it again take over.

    Attributes:
        history: the measurement history; room for the longest that is wanted.
        used: rows of it that are recorded.
        running: whether it records.
        accepted: how often its bank took over.
        rejected: how often it did not.
    """

    def __init__(self, filters: BankArrays, params: CoefficientParams) -> None:
        """Makes room; `filters` are its own, like those that it iterates."""
        self._bank, self._start = filters, filters.copy()
        self._times, self._delay = params.iteration_times, params.learning_delay
        self.startup_over = params.learning_delay + STARTUP_TIMES * params.startup_time
        longest = max(params.iteration_times, default=0.0) * ROWS_PER_STEP / (ROWS_PER_STEP - 1)
        self.history = new_history(math.ceil(longest * RATE_MAX))
        self._none = new_history(0)
        count, n = filters.x.shape
        self._reference = ReferenceFilter(filters)
        self._mean, self._may_learn = np.zeros(n), np.zeros(filters.width)
        """The values that a pass began with, and which states may learn."""
        self._window, self._contradicted = np.zeros((3, 3)), np.zeros(1)
        self._stage, self._accepted_last = LAST, False
        """Of STAGES, where the iteration is; and whether the last one took over."""
        self._evidence, self._search = Evidence(params.likelihood_memory), LineSearch()
        self._deviation = np.zeros((count, filters.width))
        self._nis, self._rejected = np.zeros(9), np.zeros(9, dtype=np.int64)
        self.used, self._span, self._turn, self._row = 0, 0.0, 0, -1
        """Row -1: no pass is under way."""
        self._age, self._learned, self.running, self.accepted, self.rejected = 0.0, False, False, 0, 0

    @property
    def recording(self) -> MeasurementHistory:
        """Where steps are recorded, from row `used` on; without a row when none is wanted."""
        return self.history if self.running else self._none

    def settled(self, age: float) -> bool:
        """Whether a bank of that age (s) has been iterated, or never will be."""
        return not self.running or age >= self.startup_over

    def begin(self, bank: BankArrays, age: float, near: bool = False) -> None:
        """The history begins here; `age` (s) of the bank is that of `start_up.schedule`.

        `near` says that the coefficients are about right already, so that the first pass needs no continuation.
        """
        self.running = len(self.history.h) > 0
        if self.running:
            self._start = bank.copy()
        self._search.begin()
        self.used, self._span, self._turn, self._row = 0, 0.0, 0, -1
        self._age, self._learned, self._accepted_last, self._evidence.lost = age, False, near, 0.0

    def begin_again(self, bank: BankArrays, age: float, believed: Array) -> None:
        """As `begin`, but the parameters are as `believed`, (parameters,), and as uncertain, as in the very beginning.

        For a bank that no pass has confirmed: it goes on, and stays unconfirmed.
        """
        self.begin(bank, age)
        x, P, _ = self._start
        first, size = bank.model.first, bank.model.size
        x[:, first:] = believed
        P[:, first:, :], P[:, :, first:] = 0.0, 0.0
        P[:, range(first, size), range(first, size)] = bank.prior[first:] ** 2

    def evidence_reset(self, log_likelihood: float) -> None:
        """The running bank's log-likelihoods begin at 0 again; the greatest of them was `log_likelihood`."""
        self._evidence.lost += log_likelihood

    def learning(self, bank: BankArrays, age: float) -> None:
        """A coefficient may learn for the first time: a history is wanted, if there is none."""
        if not self.running:
            self.begin(bank, age)

    def motion_reset(self, motion: Array, variance: Array) -> None:
        """The bank began anew in motion, (9,), known to `variance`, (9,)."""
        if self.running and self.used < len(self.history.h):
            record(self.history, self.used, 0.0, NO_INPUTS, motion, variance)
            self.used += 1

    def free_steps(self, h: float) -> int:
        """How many steps of h (s) may be made before `follow` is to be called; `count` is, whenever some were made."""
        if not self.running:
            return ENDLESS
        if self._row >= 0:
            end, compared = self.used - self._row, self._search.ahead(self._row)
            return max(min(-(-end // (ROWS_PER_STEP - 1)), -(-compared // ROWS_PER_STEP)), 1)
        mark = self._times[self._turn] if self._learned else self._delay + PATIENCE
        return max(math.ceil((mark - self._span) / h - 1e-6), 1)

    def count(self, steps: int, h: float, age: float) -> None:
        """Takes note of `steps` steps of h (s), no more than were free, that were recorded; `age` (s) is the bank's."""
        if self.running:
            self.used += steps
            self._span += steps * h
            self._evidence.fade(steps * h)
            self._learned = self._learned or age > max(self._age, self._delay) + h
            self.running = self.used <= len(self.history.h)

    def follow(self, bank: BankArrays, steps: int, h: float, age: Array, begun: Flags) -> Verdict:
        """Follows the last `steps` steps of h (s), which were counted.

        Args:
            bank: which is iterated; changed when the iteration takes over.
            steps: see above.
            h: see above.
            age: (1,), see `start_up.schedule`; changed likewise.
            begun: which of the learned coefficients have had cause to learn, (names,).

        Returns:
            ACCEPTED if the bank was changed.
        """
        if not self.running:
            return Verdict.NONE
        if self._row >= 0:
            return self._catch_up(bank, steps, age, begun)
        elif not self._learned:
            if self._span > self._delay + PATIENCE - 0.5 * h:
                self.begin(bank, age[0])
        elif self._span > self._times[self._turn] - 0.5 * h:
            self._may_learn[:] = bank.tuning.may_learn
            if self._accepted_last:
                self._stage = LAST
                self._rewind(bank.combine()[0], int(bank.log_likelihood.argmax()), begun)
            else:
                self._rewind_to_first_stage(bank, begun)
        return Verdict.NONE

    @property
    def gave_up(self) -> bool:
        """Whether it records no longer, and its last word was no confirmation."""
        return len(self.history.h) > 0 and not self.running and not self._accepted_last

    def permitted(self, count: int) -> Flags:
        """Which of the first `count` coefficients the last pass let learn, (count,)."""
        first = self._bank.model.first
        permitted: Flags = self._bank.tuning.may_learn[first : first + count] > 0.0
        return permitted

    def _catch_up(self, bank: BankArrays, steps: int, age: Array, begun: Flags) -> Verdict:
        """Goes on; at the end of the history, takes over or begins another pass."""
        own = self._bank
        to = min(self._row + ROWS_PER_STEP * steps, self.used)
        finite = self._advance(min(to, self._row + self._search.ahead(self._row)))
        worse = self._search.worse(self._row)
        finite = finite and self._advance(to)
        if (worse or not finite) and self._search.may_halve:
            self._rewind(*self._search.halve(self._mean), begun)
            return Verdict.NONE
        if finite and self._row < self.used:
            return Verdict.NONE
        if finite:
            (mean, std, _), first, most_likely = own.combine(), own.model.first, int(own.log_likelihood.argmax())
            moved, std = (mean - self._mean)[first:], std[first : first + len(begun)]
            converged = small(moved, std, own.P[most_likely, first:, first:])
            if not converged or self._stage < LAST:
                if self._stage == LAST:
                    self._search.step(self._mean, self.used, most_likely)
                self._stage += converged
                self._rewind(mean, most_likely, begun)
                return Verdict.NONE
        again = self._accepted_last
        explains = self._evidence.enough(own.log_likelihood, bank.log_likelihood)
        self._accepted_last = bool(finite and self._contradicted[0] == 0.0 and explains)
        if self._accepted_last:
            bank.take(own.x, own.P, own.log_likelihood)
            self._evidence.lost = 0.0
            age[0] = max(age[0], self.startup_over)
            self.accepted += 1
        else:
            self.rejected += 1
            if again:  # it began with what was known; now with what was believed in the beginning
                self._rewind_to_first_stage(bank, begun)
                return Verdict.REJECTED
        self._row = -1
        self._search.begin()
        while self._turn < len(self._times) and self._times[self._turn] <= self._span:
            self._turn += 1
        self.running = self._turn < len(self._times)
        return Verdict.ACCEPTED if self._accepted_last else Verdict.REJECTED

    def _advance(self, to: int) -> bool:
        """Takes the bank to that row; False if it cannot go on."""
        begin, self._row = self._row, to
        kept = (self._deviation, self._nis, self._rejected, self._window, self._contradicted, self._search.explained)
        own, ref = self._bank.kernel, self._reference
        return ref.loaded and _relinearised_pass(own, ref.bank, self.history, begin, to, *kept)

    def _rewind_to_first_stage(self, bank: BankArrays, begun: Flags) -> None:
        """Starts a pass about what was believed where the history begins, with all the noise of the first stage."""
        self._stage = 0
        self._search.begin()
        self._rewind(self._start[0][0], int(np.abs(bank.intensity - FIRST_INTENSITY).argmin()), begun)

    def _rewind(self, mean: Array, most_likely: int, begun: Flags) -> None:
        """Starts a pass: slopes about the `mean`, (n,), in the eddies of that filter."""
        own, first, tuning = self._bank, self._bank.model.first, self._bank.tuning
        own.take(*self._start)
        names = slice(first, first + len(begun))
        tuning.may_learn[:] = self._may_learn
        tuning.may_learn[names] = np.maximum(self._may_learn[names], begun)
        tuning.learns[:] = tuning.may_learn
        set_noise(tuning, own.scales, self._stage)
        self._reference.start(mean, most_likely)
        self._mean[:] = mean
        self._window[:], self._contradicted[:], self._search.explained[:] = 0.0, 0.0, 0.0
        self._row = 0

    @property
    def _arrays(self) -> tuple[Array, ...]:
        """All that a pass has set; the rest of the tuning follows from parameters, and from what is in doubt."""
        tuning = self._bank.tuning
        own = (self._mean, self._may_learn, self._window, self._contradicted, self._search.explained)
        return (*self._reference.arrays, tuning.Q, tuning.Q_eddy, tuning.learns, tuning.may_learn, *own)

    def freeze(self) -> IterationMemory:
        """All it remembers."""
        return IterationMemory(
            history=tuple(array[: self.used].copy() for array in self.history),
            start=self._start,
            bank=self._bank.copy(),
            arrays=tuple(array.copy() for array in self._arrays),
            span=self._span,
            turn=self._turn,
            row=self._row,
            stage=self._stage,
            accepted_last=self._accepted_last,
            age=self._age,
            learned=self._learned,
            running=self.running,
            accepted=self.accepted,
            rejected=self.rejected,
            lost=self._evidence.lost,
            step=(self._search.before, self._search.halvings),
        )

    def thaw(self, memory: IterationMemory) -> None:
        """Takes up again what `freeze` gave."""
        self.used = len(memory.history[0])
        for own, kept in zip((*self.history,), memory.history, strict=True):
            own[: self.used] = kept
        self._start = memory.start
        self._bank.take(*memory.bank)
        for own, kept in zip(self._arrays, memory.arrays, strict=True):
            own[:] = kept
        self._reference.load()
        self._span, self._turn, self._row = memory.span, memory.turn, memory.row
        self._stage, self._accepted_last = memory.stage, memory.accepted_last
        self._age, self._learned = memory.age, memory.learned
        self.running, self.accepted = memory.running, memory.accepted
        self.rejected, self._evidence.lost = memory.rejected, memory.lost
        self._search.before, self._search.halvings = memory.step
