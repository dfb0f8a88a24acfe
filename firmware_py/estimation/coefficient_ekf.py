"""The coefficient filter: an extended Kalman filter of one vehicle's motion, its water and its coefficients.

State: u v w p q r phi theta psi; the current north and east, and eddies about it; what gyros, attitude and DVL read too
much; the coefficients (paper Eq. 12 and 13: they stand still but for a random walk). Depth and position are beside it,
in `navigation`: under water no force depends on them, so they would tell the coefficients nothing.

Turbulence is the process noise of this filter: eddies, an Ornstein-Uhlenbeck process of the water along each axis. A
bank of filters that reckon with different intensities finds the one that the measurements make likely.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from firmware_py.estimation import bank
from firmware_py.estimation.jacobians import Array
from firmware_py.estimation.model import COEFFICIENTS
from firmware_py.estimation.observer_model import GROUPS, MOTIONS, ObserverModel
from firmware_py.estimation.prediction import CURRENT, EDDIES, STILL
from firmware_py.estimation.transition import MOVING, Picks
from firmware_py.params import ParamError, param
from firmware_py.vehicle.vehicle import Vehicle

TEN = ("M_q", "M_ds", "N_r", "N_dr", "N_v", "Z_ds", "Z_q", "Y_dr", "Y_r", "Y_v")
"""The paper's ten, in its order."""
REST = "rest"
"""Among the considered: every coefficient that is not named."""
LEAST_EDDY = 1e-6
"""Intensity of the eddies of a member that reckons with none, m/s: so that its covariance has an inverse too."""
SPEEDS, RATES, ANGLES = MOTIONS[:3], MOTIONS[3:6], MOTIONS[6:8]


@dataclass(frozen=True, slots=True)
class CoefficientParams:
    """What is estimated, and how well it was known before."""

    names: tuple[str, ...] = TEN
    """What is learned: coefficients, C_d0, C_dy, C_dz, or the scale of an equation's added mass, X_dot to N_dot."""
    considered: tuple[str, ...] = ()
    """What is reckoned to be uncertain but not learned; "rest" is every other coefficient."""
    std: float = param(70.0, unit="%", low=0.1, high=1000.0, doc="1 sigma of a learned coefficient, of its size.")
    added_mass_std: float = param(20.0, unit="%", low=0.1, high=100.0, doc="1 sigma of a scale of added mass.")
    drag_std: float = param(20.0, unit="%", low=0.1, high=1000.0, doc="1 sigma of C_dy and C_dz where learned.")
    considered_std: float = param(5.0, unit="%", low=0.1, high=100.0, doc="1 sigma of what is only considered.")
    stds: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    """1 sigma of single names, of their size, where it is another than these."""
    bound: float = param(5.0, low=1.0, high=100.0, doc="How many of these sigmas a value may leave its belief.")
    walk: float = param(0.0, unit="%", low=0.0, high=100.0, doc="Random walk of a learned coefficient, by sqrt(s).")
    current: bool = True
    current_std: float = param(0.3, unit="m/s", low=0.0, high=5.0, doc="1 sigma of the current, north and east.")
    turbulence: tuple[float, ...] = param(
        (0.0,), unit="m/s", low=0.0, high=2.0, doc="Intensities of the eddies, one for each filter of the bank."
    )
    turbulence_time: float = param(10.0, unit="s", low=0.1, high=1000.0, doc="Correlation time of the eddies.")
    memory: float = param(60.0, unit="s", low=1.0, high=1e6, doc="Time over which evidence between filters fades.")
    speed_noise: float = param(1e-5, unit="m/s", low=1e-9, high=1.0, doc="Random walk of u, v, w, by sqrt(s).")
    rate_noise: float = param(1e-4, unit="deg/s", low=1e-9, high=10.0, doc="Random walk of p, q, r, by sqrt(s).")
    speed_bias: float = param(0.0, unit="m/s", low=0.0, high=0.5, doc="1 sigma of the DVL's bias; 0: it has none.")
    rate_bias: float = param(0.0, unit="deg/s", low=0.0, high=5.0, doc="1 sigma of the gyros' bias; 0: none.")
    angle_bias: float = param(0.0, unit="deg", low=0.0, high=10.0, doc="1 sigma of roll's and pitch's bias; 0: none.")
    gate: float = param(5.0, low=2.0, high=100.0, doc="A measurement more sigmas away is not taken in.")

    def __post_init__(self) -> None:
        if not self.names:
            raise ParamError("names is empty; name the coefficients to learn, such as M_q")
        if not self.turbulence:
            raise ParamError("turbulence is empty; write 0 for a filter that reckons with none")


class Estimate(NamedTuple):
    """What the bank believes, its filters blended by their probabilities.

    Attributes:
        values: the learned coefficients, (names,); `std` their 1 sigma.
        std: see values.
        covariance: of the whole state, (n, n).
        mean: the whole state, (n,).
        nu: velocity over ground, m/s and rad/s, (6,).
        angles: phi, theta, psi, rad, (3,).
        current: steady current north and east, m/s, (2,); NaN where none is estimated. `current_std` likewise.
        current_std: see current.
        weights: probability of each filter of the bank.
        turbulence: intensity of the eddies, averaged over the bank, m/s.
    """

    values: Array
    std: Array
    covariance: Array
    mean: Array
    nu: Array
    angles: Array
    current: Array
    current_std: Array
    weights: Array
    turbulence: float


class History(NamedTuple):
    """What a run went through.

    Attributes:
        steps: how many were made; fewer than asked if the filter met a number that is not finite.
        x: blended states, (K / every, n); `std` their 1 sigma.
        std: see x.
        nis: normalised innovations squared, (K, 9); NaN where nothing came.
        weights: probabilities of the filters, (K / every, members).
    """

    steps: int
    x: Array
    std: Array
    nis: Array
    weights: Array


class EkfMemory(NamedTuple):
    """All that a bank remembers: states, covariances, evidence, and how many measurements it did not take in."""

    x: Array
    P: Array
    evidence: Array
    rejected: Picks


class CoefficientEkf:
    """The bank of one vehicle. Arrays are its own; ask `estimate`."""

    def __init__(self, vehicle: Vehicle, params: CoefficientParams) -> None:
        """Makes room for a filter of `params.names` over the believed vehicle.

        Raises:
            ParamError: a name is unknown or occurs twice, or a coefficient that is believed to be 0 has no scale.
        """
        self.params = params
        self.names = params.names
        considered = _considered(vehicle, params)
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
        self.model = model = ObserverModel(vehicle, (*params.names, *considered), water, biases)
        n, first, count = model.size, model.first, len(params.names)
        scale = np.abs(np.array(model.believed))
        shares = np.array([_share(name, params, k < count) for k, name in enumerate(model.names)])
        for name, size in zip(model.names, scale, strict=True):
            if size == 0.0:
                raise ParamError(f"{name} is believed to be 0 and gives no scale to be uncertain by; leave it out")

        self.prior = np.zeros(n)
        """1 sigma of each state before anything is measured; 0 for those that `start` is told of."""
        self.prior[MOVING : MOVING + water] = params.current_std
        self.prior[MOVING + water : first] = [bias[name] for name in biases]
        self.prior[first:] = shares * scale
        self.rules = np.zeros((4, n))
        self.rules[bank.GROWTH, :3], self.rules[bank.GROWTH, 3:6] = params.speed_noise**2, params.rate_noise**2
        self.rules[bank.GROWTH, first : first + count] = (params.walk * scale[:count]) ** 2
        self.rules[bank.LEARNS] = 1.0
        self.rules[bank.LEARNS, first + count :] = 0.0
        self.rules[bank.LOW], self.rules[bank.HIGH] = -math.inf, math.inf
        reach = params.bound * self.prior[first:]
        self.rules[bank.LOW, first:] = np.array(model.believed) - reach
        self.rules[bank.HIGH, first:] = np.array(model.believed) + reach
        for k, name in enumerate(model.names):
            if name in GROUPS:  # half to double the believed added mass: no scale makes it negative
                self.rules[bank.LOW, first + k], self.rules[bank.HIGH, first + k] = 0.5, 2.0
        self._bias = np.full(MOVING, -1, dtype=np.int64)
        for k, state in enumerate(model.biases):
            self._bias[state] = MOVING + water + k

        members = len(params.turbulence)
        self.eddies = np.maximum(np.array(params.turbulence), LEAST_EDDY)
        self.x, self.P = np.zeros((members, n)), np.zeros((members, n, n))
        self.evidence, self.weights = np.zeros(members), np.full(members, 1.0 / members)
        self.nis, self.rejected = np.full(MOVING, math.nan), np.zeros(MOVING, dtype=np.int64)
        self._room = np.zeros((bank.ROOM, n))

    def start(
        self,
        nu: Sequence[float],
        angles: Sequence[float],
        std: Sequence[float] | Array,
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
        self.resume(nu, angles, std)

    def resume(self, nu: Sequence[float], angles: Sequence[float], std: Sequence[float] | Array) -> None:
        """Begins anew in motion and in the eddies about it; current, biases and coefficients stay as they are known."""
        forgotten = [*range(MOVING), *(range(bank.EDDY, bank.EDDY + 3) if self.model.water == EDDIES else ())]
        self.x[:, forgotten] = 0.0
        self.x[:, :MOVING] = (*nu, *angles)
        self.P[:, forgotten, :] = 0.0
        self.P[:, :, forgotten] = 0.0
        for i in range(MOVING):
            self.P[:, i, i] = std[i] ** 2
        for i in forgotten[MOVING:]:
            self.P[:, i, i] = self.eddies**2

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
        return bank.step(*self._with(inputs, h, z, variance, self.nis, self.rejected))

    def run(self, h: float, inputs: Array, z: Array, variance: Array, every: int = 1) -> History:
        """`step` over the rows of inputs, (K, 4), and z, (K, 9), compiled; what it went through at every such row."""
        rows, n, members = len(inputs) // every, self.model.size, len(self.eddies)
        means, stds, weights = np.zeros((rows, n)), np.zeros((rows, n)), np.zeros((rows, members))
        nis = np.full((len(inputs), MOVING), math.nan)
        steps = bank.run(*self._with(inputs, h, z, variance, nis, self.rejected, every, means, stds, weights))
        return History(steps, means, stds, nis, weights)

    def estimate(self) -> Estimate:
        """What is believed now."""
        members, n = self.x.shape
        weights, mean, std = np.zeros(members), np.zeros(n), np.zeros(n)
        bank.blend(self.x, self.P, self.evidence, weights, mean, std)
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
        return EkfMemory(self.x.copy(), self.P.copy(), self.evidence.copy(), self.rejected.copy())

    def thaw(self, memory: EkfMemory) -> None:
        """Takes up again what `freeze` gave."""
        self.x[:], self.P[:] = memory.x, memory.P
        self.evidence[:], self.rejected[:] = memory.evidence, memory.rejected

    def _with(self, *more: Any) -> tuple[Any, ...]:
        """The arguments of `bank.step` that stay the same, and `more`."""
        m, params = self.model, self.params
        return (
            *(m.c, m.inverse, m.picks, m.weight, m.water, m.first, m.heavy, m.work, m.y, self._room, self.rules),
            *(self._bias, params.turbulence_time, params.memory, params.gate),
            *(self.eddies, self.x, self.P, self.evidence, self.weights, *more),
        )


def _considered(vehicle: Vehicle, params: CoefficientParams) -> tuple[str, ...]:
    """The names to consider, "rest" spelled out: without those believed to be 0, which nothing scales."""
    if REST not in params.considered:
        return params.considered
    known = {**dataclasses.asdict(vehicle.coefficients), "C_d0": vehicle.propeller.C_d0}
    known |= {"C_dy": vehicle.hull.C_dy, "C_dz": vehicle.hull.C_dz}
    named = tuple(name for name in params.considered if name != REST)
    taken = {member for name in (*params.names, *named) for member in GROUPS.get(name, (name,))}
    return (*named, *(name for name in COEFFICIENTS if name not in taken and known[name] != 0.0))


def _share(name: str, params: CoefficientParams, learned: bool) -> float:
    """1 sigma of a parameter, of its size."""
    if name in params.stds:
        return params.stds[name]
    if not learned:
        return params.considered_std
    if name in GROUPS:
        return params.added_mass_std
    return params.drag_std if name in ("C_dy", "C_dz") else params.std
