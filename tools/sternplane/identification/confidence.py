"""How well a fit is known, honestly: white residuals are checked for, and what is not white widens the intervals.

The inverse of the information is the covariance of the estimate if nothing but white noise of the sensors separates
model and log. Turbulence, and whatever the model lacks, leave residuals that hold on for seconds; with N of them there
are fewer than N independent ones. With the residuals' own autocorrelation rho in the place of white noise's (Klein and
Morelli 2006, ch. 5: P sum_i sum_j S_i' rho(i - j) S_j P) the variances grow as they should; none is let shrink.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from firmware_py.estimation.model.state import MOVING
from sternplane.identification.likelihood import Fit, normal, whitened
from sternplane.logs.tracking import Array

LAGS = 0.2
"""Share of the record over which the residuals' autocorrelation is taken, tapered to zero."""


@dataclass(frozen=True)
class Confidence:
    """Of a fit.

    Attributes:
        information: (size, size): the data's alone, without what was known before.
        covariance: (size, size): with it, widened; `widening` (size,) is by what factor each sigma grew.
        whiteness: (9,): autocorrelation of successive residuals: 0 for white noise, 1 for drift.
    """

    information: Array
    covariance: Array
    widening: Array
    whiteness: Array


def confidence(fit: Fit) -> Confidence:
    """What a fit's residuals say about it."""
    information, _ = normal(fit.residuals, fit.slopes, fit.std)
    spread, whiteness = np.diag(fit.prior), np.zeros(MOVING)
    for i in range(MOVING):
        A, e = whitened(fit.residuals, fit.slopes, fit.std, i)
        rho = _autocorrelation(e)
        whiteness[i] = rho[1]
        taper = np.maximum(1.0 - np.arange(len(e)) / (LAGS * len(e)), 0.0)
        spread = spread + np.einsum("ki,kj->ij", A, _filtered(A, rho * taper))
    white = np.linalg.inv(information + np.diag(fit.prior))
    widening = np.sqrt(np.maximum(np.diag(white @ spread @ white) / np.diag(white), 1.0))
    return Confidence(information, white * np.outer(widening, widening), widening, whiteness)


def _autocorrelation(e: Array) -> Array:
    """Of a series (n,), at lags 0 to n - 1; 1 at 0."""
    n = len(e)
    products = np.fft.irfft(np.abs(np.fft.rfft(e, 2 * n)) ** 2)[:n]
    rho: Array = products / products[0]
    return rho


def _filtered(A: Array, rho: Array) -> Array:
    """sum_j rho(|i - j|) A_j for every row i of A (n, m)."""
    n = len(A)
    kernel = np.fft.rfft(np.concatenate((rho, [0.0], rho[:0:-1])))
    filtered: Array = np.fft.irfft(np.fft.rfft(A, 2 * n, axis=0) * kernel[:, None], axis=0)[:n]
    return filtered
