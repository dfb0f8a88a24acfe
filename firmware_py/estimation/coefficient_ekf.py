"""The coefficient filter: an extended Kalman filter of one vehicle's motion, its water and its coefficients.

State: u v w p q r phi theta psi; the current north and east, and eddies about it; what gyros, attitude and DVL read too
much; the coefficients (paper Eq. 12 and 13: they stand still but for a random walk). Depth and position are beside it,
in `navigation`: under water no force depends on them, so they would tell the coefficients nothing.

Turbulence is the process noise of this filter: eddies, an Ornstein-Uhlenbeck process of the water along each axis. A
bank of filters that reckon with different intensities finds the one that the measurements make likely.

It begins with care (`settling`), and goes through what it has flown again when it knows more (`review`): that is what
brings it to the Cramer-Rao bound.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.coefficient_records import EkfMemory, Estimate, Flags, History
from firmware_py.estimation.filter import bank
from firmware_py.estimation.filter.bank_arrays import BankArrays
from firmware_py.estimation.filter.measurement_update import EDDY
from firmware_py.estimation.filter.start_up import MAY, lost, settle
from firmware_py.estimation.iteration.iterated_filter import IteratedFilter
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.observer_model import Floats
from firmware_py.estimation.model.prediction import STILL
from firmware_py.estimation.model.transition import MOVING
from firmware_py.vehicle.vehicle import Vehicle

ASTRAY = (1.0,) * 3 + (0.2,) * 3 + (0.5, 0.5, math.pi)
"""1 sigma of the motion that a lost filter believes in, m/s, rad/s, rad: wide enough for any sensor to be believed."""
SOON = 15.0
"""Lost again within so many s, it was not the water that had changed."""
NO_ROWS = np.zeros((0, 0))


class CoefficientEkf:
    """The bank of one vehicle. Arrays are its own; ask `estimate`.

    Attributes:
        params: what it is told.
        names: what it learns.
        bank: the filters.
        model, prior, x, P, evidence, rules: see `BankArrays`.
        age: how long it has been settling, s, (1,); see `settling.settle`.
        nis: normalised innovations squared of the last step, (9,); NaN where nothing came.
        rejected: how many measurements were not taken in, (9,).
        restarts: how often it was lost and began anew.
        review: which goes through the flight again.
    """

    def __init__(self, vehicle: Vehicle, params: CoefficientParams) -> None:
        """Makes room for a filter of `params.names` over the believed vehicle.

        Raises:
            ParamError: a name is unknown or occurs twice, or a coefficient that is believed to be 0 has no scale.
        """
        self.params, self.names = params, params.names
        self.bank = members = BankArrays(vehicle, params)
        self.model, self.prior, self.rules, self.eddies = members.model, members.prior, members.rules, members.eddies
        self.x, self.P, self.evidence = members.x, members.P, members.evidence
        self.age = np.zeros(1)
        self._begun = np.zeros(len(params.names), dtype=np.bool_)
        self._believed = np.array(self.model.believed)
        """What parameters begin with."""
        self._window, self._since = np.zeros((3, 3)), math.inf
        """Of `settling.lost`; and for how long it was not lost, s."""
        self.restarts = 0
        self.nis, self.rejected = np.full(MOVING, math.nan), np.zeros(MOVING, dtype=np.int64)
        settle(self.rules, self.age, self.model.first, 0.0, params.wait, params.settling)
        self.review = IteratedFilter(BankArrays(vehicle, params), params)

    def start(
        self,
        nu: Floats,
        angles: Floats,
        std: Floats,
        values: Mapping[str, float] | None = None,
    ) -> None:
        """Begins anew: at a velocity (m/s, rad/s) and attitude (rad) known to `std`, (9,), in unknown water.

        Coefficients begin as believed, but for those in `values`; how uncertain they are follows from the vehicle
        file in any case.
        """
        x = self.model.state(nu, angles)
        for name, value in (values or {}).items():
            x[self.model.place(name)] = value
        self.x[:] = x
        self._believed = x[self.model.first :]
        self.P[:] = np.diag(self.prior**2)
        self.evidence[:] = 0.0
        self.rejected[:] = 0
        self.age[:] = 0.0
        self._begun[:] = False
        self._window[:], self._since = 0.0, math.inf
        self.resume(nu, angles, std)
        self.review.begin(self.bank, 0.0)

    def resume(self, nu: Floats, angles: Floats, std: Floats) -> None:
        """Begins anew in motion and in the eddies about it; current, biases and coefficients stay as they are known."""
        motion, variance = np.array((*nu, *angles)), np.square(std)
        self.bank.resume(motion, variance)
        self.review.resumed(motion, variance)

    def _again(self) -> None:
        """The filter is lost. It takes up motion and water anew; if that was tried a moment ago, coefficients too.

        They are as uncertain then as in the beginning. Their values stay, for no others are better known; but before a
        review has confirmed them, those of the beginning are.
        """
        self.restarts += 1
        mean = self.blend()[0]
        self._drift()
        settled = self.review.settled(self.age[0])
        if not settled:
            self.x[:, self.model.first :] = self._believed
        if self._since < SOON or not settled:
            self._forget(self.model.first, self.model.size, self.prior[self.model.first :] ** 2)
            self.age[:] = 0.0
        self._since = 0.0
        self._window[:] = 0.0
        self.evidence[:] = 0.0
        self.bank.resume(mean[:9], np.square(ASTRAY))
        if settled:
            self.review.begin(self.bank, self.age[0])

    def _drift(self) -> None:
        """The current is as unknown as in the beginning."""
        if self.model.water != STILL:
            self.x[:, MOVING:EDDY] = 0.0
            self._forget(MOVING, EDDY, self.prior[MOVING:EDDY] ** 2)

    def _forget(self, begin: int, end: int, variance: Array) -> None:
        """Makes these states as uncertain as `variance`, (end - begin,) or a row a member, and alike with no other."""
        self.P[:, begin:end, :] = 0.0
        self.P[:, :, begin:end] = 0.0
        places = np.arange(begin, end)
        self.P[:, places, places] = variance

    def permit(self, learned: Flags) -> None:
        """Says which of the learned coefficients, (names,), may learn; the others neither learn nor become uncertain.

        When one may for the first time, all settles again.
        """
        first, count = self.model.first, len(self.names)
        self.rules[MAY, first : first + count] = learned
        if (learned & ~self._begun).any():
            self._begun |= learned
            self.age[0] = min(self.age[0], self.params.wait)
            self.review.learning(self.bank, self.age[0])

    def step(self, inputs: Array, h: float, z: Array, variance: Array) -> bool:
        """Moves on by h (s), then takes in what was measured there.

        Args:
            inputs: delta_s, delta_r, delta_b (rad), n (rev/s): means over the step, (4,).
            h: step, s.
            z: u v w p q r phi theta psi, (9,); NaN where nothing came.
            variance: of each, (9,).

        Returns:
            False if a number was not finite: call `start`.
        """
        return self._go(h, inputs[None], z[None], variance, self.nis[None], 1 << 40, NO_ROWS, NO_ROWS, NO_ROWS) == 1

    def run(self, h: float, inputs: Array, z: Array, variance: Array, every: int = 1) -> History:
        """`step` over the rows of inputs, (K, 4), and z, (K, 9), compiled; what it went through at every such row."""
        rows, n, members = len(inputs) // every, self.model.size, len(self.eddies)
        means, stds, weights = np.zeros((rows, n)), np.zeros((rows, n)), np.zeros((rows, members))
        nis = np.full((len(inputs), MOVING), math.nan)
        return History(self._go(h, inputs, z, variance, nis, every, means, stds, weights), means, stds, nis, weights)

    def _go(
        self,
        h: float,
        inputs: Array,
        z: Array,
        variance: Array,
        nis: Array,
        every: int,
        means: Array,
        stds: Array,
        weights: Array,
    ) -> int:
        """Steps over rows, see `bank.run`; how many were made."""
        params, review, begin = self.params, self.review, 0
        while begin < len(inputs):
            end = min(len(inputs), begin + review.free(h))
            told = (inputs, h, z, variance, nis, self.rejected, self.age, params.wait, params.settling, self._window)
            where = (review.tape, review.used, begin, end, every)
            came: int = bank.run(*self.bank.arguments(*told, *where, means, stds, weights))
            self._since += h * (came - begin)
            if lost(self._window):
                self._again()
            elif came < end:
                return came
            elif review.passed(self.bank, came - begin, h, self.age, self._begun):
                self._window[:] = 0.0
            begin = came
        return begin

    def blend(self) -> tuple[Array, Array, Array]:
        """Mean and 1 sigma of the whole state, (n,), and the probabilities of the filters: `estimate` in short."""
        return self.bank.blend()

    def estimate(self) -> Estimate:
        """What is believed now."""
        mean, std, weights = self.blend()
        apart = self.x - mean
        apart[:, 6:9] = (apart[:, 6:9] + math.pi) % math.tau - math.pi
        covariance = np.einsum("b,bij->ij", weights, self.P + apart[:, :, None] * apart[:, None, :])
        first, count = self.model.first, len(self.names)
        nan = np.full(2, math.nan)
        flows = self.model.water != STILL
        return Estimate(
            values=mean[first : first + count],
            std=std[first : first + count],
            covariance=covariance,
            mean=mean,
            nu=mean[:6],
            angles=mean[6:9],
            current=mean[9:11] if flows else nan,
            current_std=std[9:11] if flows else nan,
            weights=weights,
            turbulence=float(weights @ np.array(self.params.turbulence)),
        )

    def freeze(self) -> EkfMemory:
        """All it remembers."""
        return EkfMemory(
            self.x.copy(),
            self.P.copy(),
            self.evidence.copy(),
            self.rejected.copy(),
            float(self.age[0]),
            self._begun.copy(),
            self._window.copy(),
            self._since,
            self.restarts,
            self.review.freeze(),
        )

    def thaw(self, memory: EkfMemory) -> None:
        """Takes up again what `freeze` gave."""
        self.bank.take(memory.x, memory.P, memory.evidence)
        self.rejected[:] = memory.rejected
        self.age[:], self._begun[:] = memory.age, memory.begun
        self._window[:], self._since, self.restarts = memory.window, memory.since, memory.restarts
        self.review.thaw(memory.review)
