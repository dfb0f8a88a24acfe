"""The arrays of a bank of filters: its model, its tuning, its states and covariances."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from firmware_py.compiled import unchecked
from firmware_py.estimation.coefficient_params import (
    ANGLES,
    RATES,
    SPEEDS,
    CoefficientParams,
    nuisances_and_considered,
    relative_std,
)
from firmware_py.estimation.filter.bank import reset_motion
from firmware_py.estimation.filter.kernel_arguments import FilterBank, Settings, Tuning, new_scratch, padded, zeros
from firmware_py.estimation.filter.vehicle_scales import FIN_HOLD, VehicleScales, vehicle_scales
from firmware_py.estimation.filter.weighting import combine
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.observer_model import GROUPS, ObserverModel
from firmware_py.estimation.model.state import (
    ANGULAR,
    CURRENT,
    EDDIES,
    EDDY_NORTH,
    LINEAR,
    MOTIONS,
    MOVING,
    STILL,
    WATER_END,
)
from firmware_py.params import ParamError
from firmware_py.vehicle.vehicle import Vehicle

FIN_DRIVEN = tuple(MOTIONS.index(name) for name in "vwqr")
"""The motion states that fins drive, as `VehicleScales.fin_noise` has them."""
U, P_RATE = MOTIONS.index("u"), MOTIONS.index("p")
NEAR = 0.5
"""Of its sigma before anything is learned: what is known as well needs no start-up."""
INTENSITY_MIN = 1e-6
"""Intensity of the eddies of a filter that assumes none, m/s: so that its covariance has an inverse too."""
_combine = unchecked(combine)


class Constants(NamedTuple):
    """What each filter of a bank knows of k states that stand still, or nearly so: current, biases and parameters.

    Attributes:
        values: (filters, k).
        covariance: (filters, k, k).
        log_likelihood: (filters,).
    """

    values: Array
    covariance: Array
    log_likelihood: Array


class BankArrays:
    """Filters that differ in the intensity of the eddies they assume.

    Attributes:
        model: theirs; a step leaves in it how it was linearised.
        scales: of the vehicle, by which process noise is told.
        prior: 1 sigma of each state before anything is measured, (n,); 0 for those that a start is told of.
        learned, learning: how many parameters are learned, and how many with the nuisances; they come first.
        width: of a row of states, padded to whole vectors.
        kernel: what the kernels take; the next six are views of it.
        tuning: process noise, learning and bounds, see `Tuning`.
        intensity: of the eddies, m/s, (filters,).
        x: states, (filters, n).
        P: covariances, (filters, n, n).
        log_likelihood: (filters,).
        weights: their probabilities before the measurements of the last step, (filters,).
    """

    def __init__(self, vehicle: Vehicle, params: CoefficientParams) -> None:
        """Makes room.

        Raises:
            ParamError: see `CoefficientEkf`.
        """
        nuisances, considered = nuisances_and_considered(vehicle, params)
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
            raise ParamError("turbulence needs current = true: eddies are added to a current")
        self.model = model = ObserverModel(vehicle, (*params.names, *nuisances, *considered), water, biases)
        n, first = model.size, model.first
        self.learned, self.learning = len(params.names), len(params.names) + len(nuisances)
        scale = np.array(model.sizes)
        shares = np.array([relative_std(name, params) for name in model.names])
        for name, size in zip(model.names, scale, strict=True):
            if size == 0.0:
                key = "names" if name in params.names else "nuisances" if name in nuisances else "considered"
                why = f"{name} is 0 in the vehicle file, which gives no scale to be uncertain by"
                raise ParamError(f"{why}; write its size there, or leave {name} out of {key} here")

        self.prior = np.zeros(n)
        self.prior[MOVING : MOVING + water] = params.current_std
        self.prior[MOVING + water : first] = [bias[name] for name in biases]
        self.prior[first:] = shares * scale
        self.width = width = padded(n)
        self.scales = vehicle_scales(vehicle)
        self.tuning = _tuning(model, params, self.scales, self.prior, len(nuisances), width)
        self._sound_fins = self.tuning.Q_final[list(FIN_DRIVEN)]
        bias_state = np.full(MOVING, -1, dtype=np.int64)
        for k, state in enumerate(model.biases):
            bias_state[state] = MOVING + water + k

        filters = len(params.turbulence)
        self.kernel = kernel = FilterBank(
            model=model.arrays,
            step=model.linearisation,
            tuning=self.tuning,
            settings=Settings(
                eddy_time=params.turbulence_time,
                likelihood_memory=params.likelihood_memory,
                gate=params.gate,
                learning_delay=params.learning_delay,
                startup_time=params.startup_time,
            ),
            bias_state=bias_state,
            intensity=np.maximum(np.array(params.turbulence), INTENSITY_MIN),
            x=zeros(filters, width),
            P=zeros(filters, n, width),
            log_likelihood=np.zeros(filters),
            weights=np.full(filters, 1.0 / filters),
            scratch=new_scratch(width),
        )
        self.x, self.P = kernel.x[:, :n], kernel.P[:, :, :n]
        eddies = range(EDDY_NORTH, WATER_END if self.model.water == EDDIES else EDDY_NORTH)
        self._constant = np.array([i for i in range(MOVING, n) if i not in eddies])
        self.intensity, self.log_likelihood, self.weights = kernel.intensity, kernel.log_likelihood, kernel.weights

    def take(self, x: Array, P: Array, log_likelihood: Array) -> None:
        """Becomes equal to these."""
        self.x[:], self.P[:], self.log_likelihood[:] = x, P, log_likelihood

    def copy(self) -> tuple[Array, Array, Array]:
        """What `take` takes."""
        return self.x.copy(), self.P.copy(), self.log_likelihood.copy()

    def restore(self, names: tuple[str, ...], values: Array, covariance: Array) -> bool:
        """Gives every filter parameters that are known from elsewhere, without correlation with any other state.

        Args:
            names: theirs, (k,).
            values: (k,).
            covariance: (k, k), positive definite.

        Returns:
            Whether all that is learned is known to NEAR of its prior sigma.
        """
        places = [self.model.place(name) for name in names]
        self.x[:, places] = values
        self.P[:, places, :], self.P[:, :, places] = 0.0, 0.0
        self.P[np.ix_(range(len(self.P)), places, places)] = covariance
        learned = np.arange(self.model.first, self.model.first + self.learned)
        return bool((np.sqrt(self.P[0, learned, learned]) <= NEAR * self.prior[learned]).all())

    def constants(self) -> Constants:
        """Return what each filter knows of all but the motion and the eddies."""
        block = self._constant
        return Constants(self.x[:, block].copy(), self.P[:, block[:, None], block].copy(), self.log_likelihood.copy())

    def put_constants(self, known: Constants, *, current: bool) -> None:
        """Know what `constants` returned, without correlation with motion and eddies; the current is open if not so."""
        block, now = self._constant, self.x[:, MOVING:EDDY_NORTH].copy()
        self.x[:, block] = known.values
        self.P[:, block, :], self.P[:, :, block] = 0.0, 0.0
        self.P[:, block[:, None], block] = known.covariance
        self.log_likelihood[:] = known.log_likelihood
        if not current and self.model.water != STILL:
            self.reset_current()
            self.x[:, MOVING:EDDY_NORTH] = now

    def reset_current(self) -> None:
        """Know no more of the current than in the beginning."""
        if self.model.water != STILL:
            self.x[:, MOVING:EDDY_NORTH] = 0.0
            self.forget(MOVING, EDDY_NORTH, self.prior[MOVING:EDDY_NORTH] ** 2)

    def forget_sensors(self) -> None:
        """Know no more of the biases of sensors, and of the current that they tell of, than in the beginning."""
        begin, end = MOVING + self.model.water, self.model.first
        self.x[:, begin:end] = 0.0
        self.forget(begin, end, self.prior[begin:end] ** 2)
        self.reset_current()

    def forget(self, begin: int, end: int, variance: Array) -> None:
        """Give these states a variance, (end - begin,) or a row a filter, and no correlation with any other."""
        self.P[:, begin:end, :] = 0.0
        self.P[:, :, begin:end] = 0.0
        places = np.arange(begin, end)
        self.P[:, places, places] = variance

    def forget_axis(self, letters: str, believed: Array) -> None:
        """Be as uncertain as in the beginning of coefficients with these first letters, and of all that is not learned.

        The values of the first stay, for no others are better known; the rest is as `believed`, (parameters,).
        """
        first, rest = self.model.first, self.model.first + self.learned
        self.x[:, rest:] = believed[rest - first :]
        of_axis = [i for i, name in enumerate(self.model.names[: self.learned], first) if name[0] in letters]
        for i in (*of_axis, *range(rest, self.model.size)):
            self.forget(i, i + 1, self.prior[i] ** 2)

    def doubt_fins(self, planes: float, rudders: float) -> None:
        """Take delta_s and delta_r to be off by 1 sigma of these, rad, for `FIN_HOLD` at a time: process noise."""
        axes = zip(self.scales.fins, (rudders, planes, planes, rudders), strict=True)
        walks = [acceleration * std for acceleration, std in axes]
        self.tuning.Q_final[list(FIN_DRIVEN)] = self._sound_fins + np.square(walks) * FIN_HOLD

    def let_current_change(self, walk: float) -> None:
        """Take the current for a random walk, north and east, of this, m/s by sqrt(s); 0: it is steady."""
        if self.model.water != STILL:
            self.tuning.Q_final[MOVING:EDDY_NORTH] = walk * walk

    def reset_motion(self, motion: Array, variance: Array) -> None:
        """See `bank.reset_motion`."""
        reset_motion(self.kernel, motion, variance)

    def combine(self) -> tuple[Array, Array, Array]:
        """Mean and 1 sigma of the whole state, (n,), and the weights of the filters."""
        filters, n = self.x.shape
        weights, mean, std = np.zeros(filters), np.zeros(n), np.zeros(n)
        _combine(self.kernel, weights, mean, std)
        return mean, std, weights


def _tuning(
    model: ObserverModel, params: CoefficientParams, scales: VehicleScales, prior: Array, nuisances: int, width: int
) -> Tuning:
    """The tuning at the start: what learns, its process noise, and its bounds."""
    n, first, count = model.size, model.first, len(params.names)
    believed = np.array(model.believed)
    tuning = Tuning(*zeros(len(Tuning._fields), width))
    tuning.Q_final[LINEAR], tuning.Q_final[ANGULAR] = params.speed_noise**2, params.rate_noise**2
    tuning.Q_final[first : first + count] = (params.walk * np.array(model.sizes[:count])) ** 2
    for state, noise in zip(FIN_DRIVEN, scales.fin_noise(params.fin_resolution), strict=True):
        tuning.Q_final[state] += noise**2
    tuning.Q_final[U] += (params.surge_noise * scales.speed_noise) ** 2
    tuning.Q_final[P_RATE] += (params.roll_noise * scales.rate_noise) ** 2
    tuning.Q_startup[LINEAR] = (params.startup_speed_noise * scales.speed_noise) ** 2
    tuning.Q_startup[ANGULAR] = (params.startup_rate_noise * scales.rate_noise) ** 2
    tuning.Q_eddy_startup[LINEAR] = (params.eddy_speed_noise * scales.eddy_speed_noise) ** 2
    tuning.Q_eddy_startup[ANGULAR] = (params.eddy_rate_noise * scales.eddy_rate_noise) ** 2
    tuning.may_learn[:] = 1.0
    tuning.may_learn[first + count + nuisances :] = 0.0
    tuning.lower[:], tuning.upper[:] = -math.inf, math.inf
    reach = params.bound * prior[first:]
    tuning.lower[first:n], tuning.upper[first:n] = believed - reach, believed + reach
    for k, name in enumerate(model.names):
        if name in GROUPS:  # half to double the believed added mass: no scale makes it negative
            tuning.lower[first + k], tuning.upper[first + k] = 0.5, 2.0
    return tuning
