"""The coefficient filter: an extended Kalman filter of one vehicle's motion, its water and its coefficients.

State: u v w p q r phi theta psi; the current north and east, and eddies about it; what gyros, attitude and DVL read too
much; the coefficients (paper Eq. 12 and 13: they stand still but for a random walk). Depth and position are beside it,
in `navigation`: under water no force depends on them, so they would tell the coefficients nothing.

Turbulence is the process noise of this filter: eddies, an Ornstein-Uhlenbeck process of the water along each axis. A
bank of filters that reckon with different intensities finds the one that the measurements make likely.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from firmware_py.estimation import bank
from firmware_py.estimation.coefficient_params import ANGLES, RATES, SPEEDS, CoefficientParams, beside, share
from firmware_py.estimation.coefficient_records import EkfMemory, Estimate, Flags, History
from firmware_py.estimation.ekf import padded
from firmware_py.estimation.innovations import hear
from firmware_py.estimation.jacobians import Array
from firmware_py.estimation.observer_model import GROUPS, Floats, ObserverModel
from firmware_py.estimation.prediction import CURRENT, EDDIES, STILL
from firmware_py.estimation.settling import BEGINNING, FLOOR, HIGH, LOW, MAY, RULES, WINDOW, lost, revive, settle
from firmware_py.estimation.transition import MOVING
from firmware_py.params import ParamError
from firmware_py.vehicle.vehicle import Vehicle

ASTRAY = (1.0,) * 3 + (0.2,) * 3 + (0.5, 0.5, math.pi)
"""1 sigma of the motion that a lost filter believes in, m/s, rad/s, rad: wide enough for any sensor to be believed."""
SOON = 15.0
"""Lost again within so many s, it was not the water that had changed."""
LEAST_EDDY = 1e-6
"""Intensity of the eddies of a member that reckons with none, m/s: so that its covariance has an inverse too."""


class CoefficientEkf:
    """The bank of one vehicle. Arrays are its own; ask `estimate`."""

    def __init__(self, vehicle: Vehicle, params: CoefficientParams) -> None:
        """Makes room for a filter of `params.names` over the believed vehicle.

        Raises:
            ParamError: a name is unknown or occurs twice, or a coefficient that is believed to be 0 has no scale.
        """
        self.params = params
        self.names = params.names
        nuisances, considered = beside(vehicle, params)
        bias = {
            **dict.fromkeys(SPEEDS, params.speed_bias),
            **dict.fromkeys(RATES, params.rate_bias),
            **dict.fromkeys(ANGLES, params.angle_bias),
        }
        biases = tuple(name for name, std in bias.items() if std > 0.0)
        water = STILL
        if params.current:
            water = CURRENT if params.turbulence == (0.0,) else EDDIES
        elif params.turbulence != (0.0,):
            raise ParamError("turbulence needs current = true: eddies waver about a current")
        self.model = model = ObserverModel(vehicle, (*params.names, *nuisances, *considered), water, biases)
        n, first, count = model.size, model.first, len(params.names)
        scale = np.abs(np.array(model.believed))
        shares = np.array([share(name, params) for name in model.names])
        for name, size in zip(model.names, scale, strict=True):
            if size == 0.0:
                raise ParamError(f"{name} is believed to be 0 and gives no scale to be uncertain by; leave it out")

        self.prior = np.zeros(n)
        """1 sigma of each state before anything is measured; 0 for those that `start` is told of."""
        self.prior[MOVING : MOVING + water] = params.current_std
        self.prior[MOVING + water : first] = [bias[name] for name in biases]
        self.prior[first:] = shares * scale
        width = padded(n)
        self.rules = rules = np.zeros((RULES, width))
        rules[FLOOR, :3], rules[FLOOR, 3:6] = params.speed_noise**2, params.rate_noise**2
        rules[FLOOR, first : first + count] = (params.walk * scale[:count]) ** 2
        rules[BEGINNING, :3], rules[BEGINNING, 3:6] = params.speed_settling**2, params.rate_settling**2
        rules[MAY] = 1.0
        rules[MAY, first + count + len(nuisances) :] = 0.0
        rules[LOW], rules[HIGH] = -math.inf, math.inf
        reach = params.bound * self.prior[first:]
        rules[LOW, first:n] = np.array(model.believed) - reach
        rules[HIGH, first:n] = np.array(model.believed) + reach
        for k, name in enumerate(model.names):
            if name in GROUPS:  # half to double the believed added mass: no scale makes it negative
                rules[LOW, first + k], rules[HIGH, first + k] = 0.5, 2.0
        self._bias = np.full(MOVING, -1, dtype=np.int64)
        for k, state in enumerate(model.biases):
            self._bias[state] = MOVING + water + k

        members = len(params.turbulence)
        self.eddies = np.maximum(np.array(params.turbulence), LEAST_EDDY)
        self._x, self._P = np.zeros((members, width)), np.zeros((members, n, width))
        self.x, self.P = self._x[:, :n], self._P[:, :, :n]
        """States, (members, n), and covariances, (members, n, n): views of what the kernels pad to whole vectors."""
        self.evidence, self.weights = np.zeros(members), np.full(members, 1.0 / members)
        self.age = np.zeros(1)
        """How long it has been settling, s; see `settling.settle`."""
        self._begun = np.zeros(count, dtype=np.bool_)
        self._window, self._since = np.zeros((3, 3)), math.inf
        """Of `settling.lost`; and for how long it was not lost, s."""
        self.restarts = 0
        """How often it was lost and began anew."""
        self.nis, self.rejected = np.full(MOVING, math.nan), np.zeros(MOVING, dtype=np.int64)
        self._room = np.zeros((bank.ROOM, width))
        settle(rules, self.age, first, 0.0, params.wait, params.settling)

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
        self.P[:] = np.diag(self.prior**2)
        self.evidence[:] = 0.0
        self.rejected[:] = 0
        self.age[:] = 0.0
        self._begun[:] = False
        self._window[:], self._since = 0.0, math.inf
        self.resume(nu, angles, std)

    def resume(self, nu: Floats, angles: Floats, std: Floats) -> None:
        """Begins anew in motion and in the eddies about it; current, biases and coefficients stay as they are known."""
        self.x[:, :MOVING] = (*nu, *angles)
        self._forget(0, MOVING, np.square(std))
        if self.model.water == EDDIES:
            self.x[:, bank.EDDY : bank.EDDY + 3] = 0.0
            self._forget(bank.EDDY, bank.EDDY + 3, np.square(self.eddies)[:, None])

    def _again(self) -> None:
        """The filter is lost. It takes up motion and water anew; if that was tried a moment ago, coefficients too.

        Their values stay, for no others are better known; how uncertain they are is as in the beginning.
        """
        self.restarts += 1
        mean = self.blend()[0]
        self._drift()
        if self._since < SOON:
            self._forget(self.model.first, self.model.size, self.prior[self.model.first :] ** 2)
            self.age[:] = 0.0
        self._since = 0.0
        self._window[:] = 0.0
        self.evidence[:] = 0.0
        self.resume(mean[:6], mean[6:9], ASTRAY)

    def _drift(self) -> None:
        """The current is as unknown as in the beginning."""
        if self.model.water != STILL:
            self.x[:, MOVING : bank.EDDY] = 0.0
            self._forget(MOVING, bank.EDDY, self.prior[MOVING : bank.EDDY] ** 2)

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
        params = self.params
        settle(self.rules, self.age, self.model.first, h, params.wait, params.settling)
        if not bank.step(*self._with(inputs, h, z, variance, self.nis, self.rejected)):
            return False
        if len(self.evidence) > 1:
            revive(self._x, self._P, self.evidence)
        self._since += h
        hear(self.nis, math.exp(-h / WINDOW), self._window)
        if lost(self._window):
            self._again()
        return True

    def run(self, h: float, inputs: Array, z: Array, variance: Array, every: int = 1) -> History:
        """`step` over the rows of inputs, (K, 4), and z, (K, 9), compiled; what it went through at every such row."""
        rows, n, members = len(inputs) // every, self.model.size, len(self.eddies)
        means, stds, weights = np.zeros((rows, n)), np.zeros((rows, n)), np.zeros((rows, members))
        nis = np.full((len(inputs), MOVING), math.nan)
        told = (
            inputs,
            h,
            z,
            variance,
            nis,
            self.rejected,
            self.age,
            self.params.wait,
            self.params.settling,
            self._window,
        )
        steps = 0
        while steps < len(inputs):
            begin, steps = steps, bank.run(*self._with(*told, steps, every, means, stds, weights))
            self._since += h * (steps - begin)
            if not lost(self._window):
                break
            self._again()
        return History(steps, means, stds, nis, weights)

    def blend(self) -> tuple[Array, Array, Array]:
        """Mean and 1 sigma of the whole state, (n,), and the probabilities of the filters: `estimate` in short."""
        members, n = self.x.shape
        weights, mean, std = np.zeros(members), np.zeros(n), np.zeros(n)
        bank.blend(self._x, self._P, self.evidence, weights, mean, std)
        return mean, std, weights

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
        )

    def thaw(self, memory: EkfMemory) -> None:
        """Takes up again what `freeze` gave."""
        self.x[:], self.P[:] = memory.x, memory.P
        self.evidence[:], self.rejected[:] = memory.evidence, memory.rejected
        self.age[:], self._begun[:] = memory.age, memory.begun
        self._window[:], self._since, self.restarts = memory.window, memory.since, memory.restarts

    def _with(self, *more: Any) -> tuple[Any, ...]:
        """The arguments of `bank.step` that stay the same, and `more`."""
        m, params = self.model, self.params
        return (
            *(m.c, m.inverse, m.picks, m.weight, m.water, m.first, m.heavy, m.work, m.y, self._room, self.rules),
            *(self._bias, params.turbulence_time, params.memory, params.gate),
            *(self.eddies, self._x, self._P, self.evidence, self.weights, *more),
        )
