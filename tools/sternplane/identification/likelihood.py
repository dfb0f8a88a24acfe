"""Batch maximum likelihood, in output-error form (Klein and Morelli 2006, ch. 6): one flight of the model, fitted.

The model is flown from an initial state, without process noise, on the inputs that were recorded; what it does is
compared with all that was measured. Initial velocity and attitude, current, biases of the sensors and coefficients are
one vector, the observer model's state at the start, so that its transition matrices carry every slope (`simulation`).

The noise of each sensor is not assumed: it is what the residuals have. For given noise the step is Gauss and Newton's
with Levenberg and Marquardt's damping. The vehicle file counts as a measurement of each coefficient, a weak one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.estimation.model.state import MOVING
from firmware_py.run.usage_error import UsageError
from sternplane.identification.recording import Recording
from sternplane.identification.simulation import Trajectory, simulate
from sternplane.logs.tracking import Array

STEPS_MAX = 30
ENOUGH = 1e-4
"""The fit is found when Newton's step, squared and over its covariance, is shorter: a hundredth of a sigma."""
DAMPING, DAMPING_MAX = 1e-4, 1e8
"""What is added to the information, each number over its own sigma: at first, and at the most."""
STD_MIN = 1e-9
"""Residuals of data without noise are taken to be no smaller (m/s, rad/s, rad)."""


@dataclass(frozen=True)
class Fit:
    """The most likely initial state and all that follows from it.

    Attributes:
        x: (size,): the model's state at the start: velocity, attitude, current, biases, coefficients.
        residuals: (K, 9), NaN where nothing was measured.
        slopes: (K, 9, size), see `Trajectory`.
        std: (9,): of the residuals.
        prior: (size,): what was known before, 1 / sigma^2.
        steps: how many were taken.
        found: it is at rest; else it is the best that was met in `STEPS_MAX` steps.
    """

    x: Array
    residuals: Array
    slopes: Array
    std: Array
    prior: Array
    steps: int
    found: bool


def fit(
    model: ObserverModel,
    recording: Recording,
    prior_std: Array,
    watch: Callable[[int, float], None] = lambda _step, _gain: None,
) -> Fit:
    """Return the state at the start that makes the recording most likely.

    Args:
        model: with the water, biases and names that are to be found; believed values are where the search begins.
        recording: see there.
        prior_std: (size,): 1 sigma of what is known of each before, inf for nothing; around the model's own values.
        watch: is told after each step how many were made, and what the last one gained.

    Raises:
        UsageError: the search cannot begin.
    """
    believed = model.state(recording.start[:6].tolist(), recording.start[6:].tolist())
    prior = prior_std**-2.0
    x, trajectory = believed, simulate(model, recording, believed)
    if trajectory is None:
        raise UsageError("the believed vehicle cannot be flown on the log's inputs: its motion becomes non-finite")
    damping, found, step = DAMPING, False, 0
    while not found and step < STEPS_MAX and damping < DAMPING_MAX:
        std, cost = spread(trajectory.residuals), _cost(trajectory, x - believed, prior)
        information, slope = normal(trajectory.residuals, trajectory.slopes, std)
        information += np.diag(prior)
        slope -= prior * (x - believed)
        scale = np.sqrt(np.diag(information))
        found = bool(slope @ np.linalg.solve(information, slope) < ENOUGH)
        while not found and damping < DAMPING_MAX:
            bent = information / np.outer(scale, scale) + damping * np.eye(len(x))
            ahead = x + np.linalg.solve(bent, slope / scale) / scale
            tried = simulate(model, recording, ahead)
            gain = -math.inf if tried is None else cost - _cost(tried, ahead - believed, prior)
            if tried is not None and gain > 0.0:
                x, trajectory, damping, step = ahead, tried, 0.1 * damping, step + 1
                watch(step, gain)
                break
            damping *= 10.0
    return Fit(x, trajectory.residuals, trajectory.slopes, spread(trajectory.residuals), prior, step, found)


def spread(residuals: Array) -> Array:
    """Root mean square of each column, NaN left out."""
    std: Array = np.maximum(np.sqrt(np.nanmean(residuals**2, axis=0)), STD_MIN)
    return std


def normal(residuals: Array, slopes: Array, std: Array) -> tuple[Array, Array]:
    """The data's information (size, size), and the slope of the logarithm of the likelihood (size,)."""
    size = slopes.shape[2]
    information, slope = np.zeros((size, size)), np.zeros(size)
    for i in range(MOVING):
        A, e = whitened(residuals, slopes, std, i)
        information += np.einsum("ki,kj->ij", A, A)  # BLAS would share these out among threads, and not always alike
        slope += np.einsum("ki,k->i", A, e)
    return information, slope


def whitened(residuals: Array, slopes: Array, std: Array, i: int) -> tuple[Array, Array]:
    """Slopes (n, size) and residuals (n,) of the measurements of one motion, over their sigma."""
    measured = np.isfinite(residuals[:, i])
    return slopes[measured, i] / std[i], residuals[measured, i] / std[i]


def _cost(trajectory: Trajectory, away: Array, prior: Array) -> float:
    """Less the logarithm of the likelihood, the noise being what the residuals have."""
    count = np.isfinite(trajectory.residuals).sum(axis=0)
    return float(count @ np.log(spread(trajectory.residuals)) + 0.5 * prior @ away**2)
