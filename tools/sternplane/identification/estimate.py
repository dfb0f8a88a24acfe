"""Both estimators over one recording: the filter that flies, and batch maximum likelihood; which to believe.

Maximum likelihood here knows no process noise. If its residuals are white and as small as the sensors' noise, it is
the better of the two, using every measurement for every moment. If they are not, the water was not still, or the model
lacks something; its values may then be far off, beyond even widened intervals, and the filter's are taken, whose bank
reckons with eddies.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from firmware_py.adapters.storage.recorder import LogError
from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.coefficient_records import Estimate, History
from firmware_py.estimation.model.state import MOVING
from sternplane.identification.confidence import Confidence, confidence
from sternplane.identification.likelihood import Fit, fit
from sternplane.identification.recording import Recording
from sternplane.logs.tracking import Array

WHITE = 0.2
"""Successive residuals of a sensor correlate less than this where only its noise is left."""
SPEED_BIAS, RATE_BIAS, ANGLE_BIAS = 0.002, math.radians(0.005), math.radians(0.1)
"""What DVL, gyros and attitude may read too much, 1 sigma (m/s, rad/s, rad): no sensor is taken to be better."""
LARGE = 1.25
"""Residuals this many times the noise that a sensor should have are not its noise alone."""


@dataclass(frozen=True)
class Estimated:
    """Values of the named coefficients, (names,), and their covariance, (names, names)."""

    values: Array
    covariance: Array

    @property
    def std(self) -> Array:
        """1 sigma of each, (names,)."""
        deviations: Array = np.sqrt(np.diag(self.covariance))
        return deviations


@dataclass(frozen=True)
class Identification:
    """Both estimates, and what their residuals say.

    Attributes:
        names: the coefficients; `believed` what the vehicle file says, `prior` (names,) its 1 sigma.
        likelihood: by maximum likelihood; `filtered` by the filter.
        believed: see names.
        prior: see names.
        filtered: see likelihood.
        white: the fit came to rest and its residuals are the sensors' noise: its answer is the one to take.
        current: of the answer that is taken, north and east, m/s, (2,), and its 1 sigma; NaN where none was estimated.
        current_std: see current.
        fit: the fit itself; `confidence` what its residuals say of it; `size` (9,): residuals over sensors' noise.
        confidence: see fit.
        size: see fit.
        widening: (names,): by how much the fit's residuals widened each sigma.
        nis: of the filter: DVL, gyro, attitude; 1 is consistent.
        turbulence: intensity of the eddies, as the filter's bank has it, m/s.
        history: of the filter; `first` the place of the first coefficient in its state.
    """

    names: tuple[str, ...]
    believed: Array
    prior: Array
    likelihood: Estimated
    filtered: Estimated
    white: bool
    current: Array
    current_std: Array
    fit: Fit
    confidence: Confidence
    size: Array
    widening: Array
    nis: tuple[float, float, float]
    turbulence: float
    history: History
    first: int

    @property
    def taken(self) -> Estimated:
        """The estimate that is taken."""
        return self.likelihood if self.white else self.filtered

    @property
    def sizes(self) -> Array:
        """What a share of each is a share of, (names,): its size as it was found."""
        return np.abs(np.where(self.taken.values == 0.0, self.believed, self.taken.values))


def identify(
    recording: Recording, params: CoefficientParams, watch: Callable[[int, float], None] = lambda _step, _gain: None
) -> Identification:
    """Estimate `params.names` from a recording.

    Args:
        recording: see there.
        params: what to estimate, and how well it is known before; as the filter takes them.
        watch: see `likelihood.fit`.

    Raises:
        ParamError: a name that does not exist, or a mass matrix that is not positive definite.
        UsageError: the believed vehicle cannot be flown on the recorded inputs.
        LogError: the filter met a number that is not finite.
    """
    params = dataclasses.replace(
        params,
        speed_bias=max(params.speed_bias, SPEED_BIAS),
        rate_bias=max(params.rate_bias, RATE_BIAS),
        angle_bias=max(params.angle_bias, ANGLE_BIAS),
    )
    alone = CoefficientEkf(recording.vehicle, dataclasses.replace(params, considered=(), turbulence=(0.0,)))
    model, prior = alone.model, alone.prior.copy()
    prior[:MOVING] = np.inf
    found = fit(model, recording, prior, watch)
    sure, learned = confidence(found), slice(model.first, model.size)
    bank = CoefficientEkf(recording.vehicle, params)
    estimate, history = _filtered(bank, recording)
    block = slice(bank.model.first, bank.model.first + len(params.names))
    size = found.std / recording.std
    white = bool(found.found and np.abs(sure.whiteness).max() < WHITE and size.max() < LARGE)
    current, current_std = estimate.current, estimate.current_std
    if white and model.water:
        place = slice(MOVING, MOVING + model.water)
        current, current_std = found.x[place], np.sqrt(np.diag(sure.covariance)[place])
    return Identification(
        names=params.names,
        believed=np.array(model.believed),
        prior=prior[learned],
        likelihood=Estimated(found.x[learned], sure.covariance[learned, learned]),
        filtered=Estimated(estimate.values, estimate.covariance[block, block]),
        white=white,
        current=current,
        current_std=current_std,
        fit=found,
        confidence=sure,
        size=size,
        widening=sure.widening[learned],
        nis=_nis(history),
        turbulence=estimate.turbulence,
        history=history,
        first=block.start,
    )


def _filtered(bank: CoefficientEkf, recording: Recording) -> tuple[Estimate, History]:
    """Return the final estimate of the filter and its history."""
    bank.start(recording.start[:6].tolist(), recording.start[6:].tolist(), recording.std.tolist())
    history = bank.run(recording.h, recording.inputs, recording.z, recording.std**2)
    if history.steps < len(recording.inputs):
        raise LogError(f"the filter met a number that is not finite at {recording.t[history.steps]:.2f} s of the log")
    return bank.estimate(), history


def _nis(history: History) -> tuple[float, float, float]:
    """Means of DVL, gyro and attitude."""
    dvl, gyro, attitude = (float(np.nanmean(history.nis[:, i : i + 3])) for i in (0, 3, 6))
    return dvl, gyro, attitude
