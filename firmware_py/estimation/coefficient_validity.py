"""Whether what was learned may be relied on: excitation, consistency and validity, each with hysteresis.

A coefficient is *excited* when the force that it multiplies moves the vehicle by more than the sensors can resolve. Its
motion is *informative* when it is excited by so much more as it is known better than UNSURE: in closed loop, fins that
hold a straight course move by the noise of the very sensors that are learned from, and slowly teach a wrong value. The
filter is *consistent* when the running means of its normalised innovations squared (NIS; Bar-Shalom, Li and Kirubarajan
2001, 5.4) lie where chance lets them lie. A coefficient is *valid* when the filter is consistent and is certain of it;
it becomes so only while it is excited, and stays so while nothing contradicts it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from firmware_py.compiled import Flags, Matrix, Vector, kernel, unchecked
from firmware_py.estimation.filter.consistency import COUNT, SQUARES, SUM, add_nis
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.kernel_arguments import ForceTerms, first_terms
from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.params import ParamError, param

SENSORS = ("dvl", "gyro", "attitude")
"""Whose measurements u v w, p q r and phi theta psi are."""
COUNT_MIN = 30.0
"""So many recent measurements tell how a sensor's innovations are; fewer do not."""
STAY, ENTER = 3.2905, 1.96
"""Normal quantiles: of the two-sided 99.9 % band, in which consistency stays, and of the 95 % one, where it begins."""
CAREFUL = 2.0
"""A mean may be less by this factor besides: process noise in surge and roll stands for what is not learned there, and
makes the filter careful on purpose. Where it is more than need be sigma is too large, which misleads no law."""
EXCITATION_END = 0.25
"""An excitation ends at this share of the mean square that it begins at: half the acceleration."""
UNSURE = 0.05
"""A coefficient with a greater 1 sigma, as a share of its believed size, is taught by whatever excites it; one with a
smaller sigma only by accelerations that are greater by as much."""


@dataclass(frozen=True, slots=True)
class ValidityParams:
    """When a learned coefficient is to be relied on."""

    valid_std: float = param(
        10.0,
        unit="%",
        low=0.1,
        high=100.0,
        doc="A coefficient becomes valid below this 1 sigma, of its believed size.",
        mav="VALID",
    )
    invalid_std: float = param(
        20.0, unit="%", low=0.1, high=1000.0, doc="It is valid no longer above this one.", mav="INVALID"
    )
    excitation_time: float = param(
        10.0, unit="s", low=0.1, high=1000.0, doc="Window over which excitation is judged.", mav="EXC_TIME"
    )
    speed_gain: float = param(
        0.005,
        unit="m/s",
        low=1e-6,
        high=10.0,
        doc="A force excites its coefficient if by itself it would change the speed by this in a second (RMS).",
        mav="U_GAIN",
    )
    rate_gain: float = param(
        0.1,
        unit="deg/s",
        low=1e-6,
        high=100.0,
        doc="A moment, if it would change the turning rate by this in a second.",
        mav="R_GAIN",
    )
    nis_time: float = param(
        10.0, unit="s", low=0.1, high=1000.0, doc="Window over which innovations are judged.", mav="NIS_TIME"
    )
    nis_slack: float = param(
        20.0,
        unit="%",
        low=0.0,
        high=1000.0,
        doc="How far their mean square may be off, beside what chance explains.",
        mav="SLACK",
    )
    settle: float = param(
        5.0,
        unit="s",
        low=0.0,
        high=1000.0,
        doc="After a reset nothing is valid, and nothing counts as excitation, for so long.",
        mav="SETTLE",
    )

    def __post_init__(self) -> None:
        if not self.invalid_std > self.valid_std:
            raise ParamError("invalid_std must be greater than valid_std, so that validity does not flicker")


class Validity(NamedTuple):
    """What `records.estimate.Learned` says of it: by coefficient, by coefficient, and by SENSORS (NaN unknown)."""

    valid: tuple[bool, ...]
    excited: tuple[bool, ...]
    nis: tuple[float, float, float]


class ValidityMemory(NamedTuple):
    """Everything that is remembered; see `CoefficientValidity`."""

    valid: tuple[bool, ...]
    excited: tuple[bool, ...]
    level: tuple[float, ...]
    informative: tuple[bool, ...]
    window: tuple[tuple[float, ...], ...]
    consistent: bool
    wait: float


class CoefficientValidity:
    """Judges the first `count` parameters of a model, step by step."""

    def __init__(self, params: ValidityParams, model: ObserverModel, count: int) -> None:
        """Begins as after a reset. Inertia and the sizes of the coefficients are as believed, whatever is learned; that
        of x_G, which is believed to be 0, is the vehicle's length.
        """
        self._params = params
        self._scale = np.array(model.sizes[:count], dtype=np.float64)
        self._terms = first_terms(model.arrays.terms, count)
        seen = np.array((params.speed_gain,) * 3 + (params.rate_gain,) * 3)
        parameter, equation, weight = self._terms.parameter, self._terms.equation, self._terms.weight
        inertia = np.diag(model.arrays.inverse_mass)[equation]
        self._gain = weight * self._scale[parameter] * inertia / seen[equation]
        self._valid, self.excited = np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_)
        self.informative = np.zeros(count, dtype=np.bool_)
        self._level = np.zeros(count)
        """Mean square of the acceleration that each force would make, over the one that can be seen."""
        self._window = np.zeros((len(SENSORS), 3))
        self._consistent = False
        self._wait = params.settle
        """Until the filter has settled, s."""

    def update(self, dt: float, std: Array, regressors: Array, nis: Array) -> bool:
        """Judges a step of the filter.

        Args:
            dt: the step, s.
            std: 1 sigma of the coefficients, (count,) or longer; one that is not finite is no certainty.
            regressors: the force that a unit of each coefficient makes, see `Linearisation`.
            nis: of u v w p q r phi theta psi, (9,), those of rejected measurements too; NaN where nothing came.

        Returns:
            Whether what is excited, or informative, has changed.
        """
        params = self._params
        self._wait = max(0.0, self._wait - dt)
        _add_nis(nis, math.exp(-dt / params.nis_time), self._window)
        self._consistent = _inside(self._window, STAY if self._consistent else ENTER, 1.0 + params.nis_slack)
        settled = self._wait == 0.0
        share = -math.expm1(-dt / params.excitation_time) if settled else 0.0
        changed = _excite(self._terms, self._gain, regressors, share, self._level, self.excited)
        changed |= _inform(std, self._scale, self._level, self.informative)
        trusted = self._consistent and settled
        _judge(std, self._scale, params.valid_std, params.invalid_std, trusted, self.excited, self._valid)
        return changed

    def reset(self) -> None:
        """The filter begins anew: nothing is valid, and its innovations are yet to be judged.

        What is excited stays so; but until the flow is known that the motion makes, nothing adds to it.
        """
        self._valid[:] = False
        self._window[:] = 0.0
        self._consistent, self._wait = False, self._params.settle

    @property
    def trusted(self) -> bool:
        """Return whether the filter has settled and its innovations are what they should be."""
        return self._consistent and self._wait == 0.0

    @property
    def surprised(self) -> bool:
        """Return whether innovations of a sensor are greater than they should be, and not less, as in a start-up."""
        slack = 1.0 + self._params.nis_slack
        return any(
            n >= COUNT_MIN and s / n > slack * band(n * n / squares, STAY)[1] for s, n, squares in self._window.tolist()
        )

    @property
    def verdict(self) -> Validity:
        """What is to be said of it."""
        dvl, gyro, attitude = (s / n if n >= COUNT_MIN else math.nan for s, n, _ in self._window.tolist())
        return Validity(tuple(self._valid.tolist()), tuple(self.excited.tolist()), (dvl, gyro, attitude))

    def sure(self, std: Sequence[float]) -> list[bool]:
        """Return what is valid, and certain by these 1 sigma too, (count,): those of all filters, which may differ."""
        sure: list[bool] = (self._valid & (np.array(std) <= self._params.invalid_std * self._scale)).tolist()
        return sure

    def freeze(self) -> ValidityMemory:
        """All that is remembered."""
        return ValidityMemory(
            tuple(self._valid.tolist()),
            tuple(self.excited.tolist()),
            tuple(self._level.tolist()),
            tuple(self.informative.tolist()),
            tuple(map(tuple, self._window.tolist())),
            self._consistent,
            self._wait,
        )

    def thaw(self, memory: ValidityMemory) -> None:
        """Goes on from there."""
        self._valid[:], self.excited[:], self._level[:] = memory.valid, memory.excited, memory.level
        self.informative[:], self._window[:] = memory.informative, memory.window
        self._consistent, self._wait = memory.consistent, memory.wait


@kernel()
def band(freedom: float, z: float) -> tuple[float, float]:
    """Where a chi-square over its degrees of freedom lies, but for tails beyond -z and z (Wilson and Hilferty 1931)."""
    spread = 2.0 / (9.0 * freedom)
    low, high = 1.0 - spread - z * math.sqrt(spread), 1.0 - spread + z * math.sqrt(spread)
    return max(low, 0.0) ** 3, high**3


@kernel()
def inside(window: Matrix, z: float, slack: float) -> bool:
    """Whether the mean of every sensor that is heard lies in its band, and one is heard.

    A weighted mean has the variance of one over COUNT^2 / SQUARES measurements that count alike. See CAREFUL for its
    lower edge.
    """
    heard = False
    for sensor in range(3):
        count = window[sensor, COUNT]
        if count >= COUNT_MIN:
            heard = True
            low, high = band(count * count / window[sensor, SQUARES], z)
            if not low / (slack * CAREFUL) <= window[sensor, SUM] / count <= high * slack:
                return False
    return heard


@kernel()
def lasts(level: float, was: bool) -> bool:
    """Whether an excitation of this mean square begins, or goes on if there `was` one."""
    return level >= (EXCITATION_END if was else 1.0)


@kernel()
def excite(terms: ForceTerms, gain: Vector, regressors: Vector, share: float, level: Vector, excited: Flags) -> bool:
    """Takes the forces of a step into the excitation of each coefficient: in the equation where it does most.

    A force that is not finite excites nothing. Returns whether what is excited has changed.
    """
    k, changed = 0, False
    for i in range(len(level)):
        most = 0.0
        while k < len(gain) and terms.parameter[k] == i:
            equation, force = terms.equation[k], 0.0
            while k < len(gain) and terms.parameter[k] == i and terms.equation[k] == equation:
                force += gain[k] * regressors[terms.regressor[k]]
                k += 1
            square = force * force
            if most < square < math.inf:
                most = square
        level[i] += share * (most - level[i])
        was = excited[i]
        excited[i] = lasts(level[i], was)
        changed = changed or excited[i] != was
    return changed


@kernel()
def inform(std: Vector, scale: Vector, level: Vector, informative: Flags) -> bool:
    """Says of each coefficient whether its excitation tells more than is known. Returns whether that has changed."""
    changed = False
    for i in range(len(level)):
        known, was = UNSURE * scale[i], informative[i]
        unsure = std[i] / known if std[i] < known else 1.0
        informative[i] = lasts(level[i] * unsure * unsure, was)
        changed = changed or informative[i] != was
    return changed


@kernel()
def judge(std: Vector, scale: Vector, enter: float, leave: float, trusted: bool, excited: Flags, valid: Flags) -> None:
    """Says of each coefficient whether it is valid; `enter` and `leave` are shares of `scale`."""
    for i in range(len(valid)):
        certain = std[i] <= (leave if valid[i] else enter) * scale[i]
        valid[i] = trusted and certain and (valid[i] or excited[i])


_add_nis, _inside = unchecked(add_nis), unchecked(inside)
_excite, _inform, _judge = unchecked(excite), unchecked(inform), unchecked(judge)
