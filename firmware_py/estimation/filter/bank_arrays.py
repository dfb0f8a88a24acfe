"""A bank's model, its rules and its arrays."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from firmware_py.estimation.coefficient_params import ANGLES, RATES, SPEEDS, CoefficientParams, beside, share
from firmware_py.estimation.filter import bank
from firmware_py.estimation.filter.covariance import padded
from firmware_py.estimation.filter.measurement_update import ROOM
from firmware_py.estimation.filter.start_up import BEGINNING, FLOOR, HIGH, LOW, MAY, RULES, STIRRED
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.observer_model import GROUPS, ObserverModel
from firmware_py.estimation.model.prediction import CURRENT, EDDIES, STILL
from firmware_py.estimation.model.transition import MOVING
from firmware_py.params import ParamError
from firmware_py.vehicle.vehicle import Vehicle

LEAST_EDDY = 1e-6
"""Intensity of the eddies of a member that reckons with none, m/s: so that its covariance has an inverse too."""


class BankArrays:
    """Filters that differ in the intensity of the eddies they reckon with.

    Attributes:
        model: theirs; a step leaves in it what it drew its slopes from.
        prior: 1 sigma of each state before anything is measured, (n,); 0 for those that a start is told of.
        rules: (RULES, padded), see `settling`.
        eddies: intensities, m/s, (members,).
        x: states, (members, n), a view of what the kernels pad to whole vectors.
        P: covariances, (members, n, n), likewise.
        evidence: log-likelihoods, (members,).
        weights: their probabilities before the measurements of the last step, (members,).
    """

    def __init__(self, vehicle: Vehicle, params: CoefficientParams) -> None:
        """Makes room.

        Raises:
            ParamError: see `CoefficientEkf`.
        """
        self._params = params
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
        self.prior[MOVING : MOVING + water] = params.current_std
        self.prior[MOVING + water : first] = [bias[name] for name in biases]
        self.prior[first:] = shares * scale
        width = padded(n)
        self.rules = rules = np.zeros((RULES, width))
        rules[FLOOR, :3], rules[FLOOR, 3:6] = params.speed_noise**2, params.rate_noise**2
        rules[FLOOR, first : first + count] = (params.walk * scale[:count]) ** 2
        rules[BEGINNING, :3], rules[BEGINNING, 3:6] = params.speed_settling**2, params.rate_settling**2
        rules[STIRRED, :3], rules[STIRRED, 3:6] = params.speed_stirred**2, params.rate_stirred**2
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
        self.evidence, self.weights = np.zeros(members), np.full(members, 1.0 / members)
        self._room = np.zeros((ROOM, width))

    def take(self, x: Array, P: Array, evidence: Array) -> None:
        """Becomes equal to these."""
        self.x[:], self.P[:], self.evidence[:] = x, P, evidence

    def copy(self) -> tuple[Array, Array, Array]:
        """What `take` takes."""
        return self.x.copy(), self.P.copy(), self.evidence.copy()

    def resume(self, motion: Array, variance: Array) -> None:
        """See `bank.resume`."""
        bank.resume(self._x, self._P, self.eddies, self.model.water, motion, variance)

    def blend(self) -> tuple[Array, Array, Array]:
        """Mean and 1 sigma of the whole state, (n,), and the probabilities of the filters."""
        members, n = self.x.shape
        weights, mean, std = np.zeros(members), np.zeros(n), np.zeros(n)
        bank.blend(self._x, self._P, self.evidence, weights, mean, std)
        return mean, std, weights

    def arguments(self, *more: Any) -> tuple[Any, ...]:
        """Those of `bank.step` that stay the same, and `more`."""
        params = self._params
        return (
            *(*self._model, self.rules, self._bias, params.turbulence_time, params.memory, params.gate),
            *(self.eddies, self._x, self._P, self.evidence, self.weights, *more),
        )

    def alone(self, rules: Array, *more: Any) -> tuple[Any, ...]:
        """Those of `smoother.scout` that a filter has in common with these, its rules, and more."""
        params = self._params
        return (*self._model, rules, self._bias, params.turbulence_time, params.gate, *more)

    @property
    def _model(self) -> tuple[Any, ...]:
        """The model as kernels take it, and the room that they work in."""
        m = self.model
        return m.c, m.inverse, m.picks, m.weight, m.water, m.first, m.heavy, m.work, m.y, self._room
