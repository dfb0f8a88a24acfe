"""What a bank of filters believes: their states, combined by their weights."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from firmware_py.estimation.coefficient_records import Estimate
from firmware_py.estimation.filter.bank_arrays import BankArrays
from firmware_py.estimation.model.state import CURRENT_EAST, CURRENT_NORTH, MOVING, PHI, STILL


def combined_estimate(filters: BankArrays, turbulence: Sequence[float]) -> Estimate:
    """Return the estimate of filters that take eddies for as intense as `turbulence`, m/s, (filters,)."""
    mean, std, weights = filters.combine()
    off = filters.x - mean
    off[:, PHI:MOVING] = (off[:, PHI:MOVING] + math.pi) % math.tau - math.pi
    covariance = np.einsum("b,bij->ij", weights, filters.P + off[:, :, None] * off[:, None, :])
    learned = slice(filters.model.first, filters.model.first + filters.learned)
    nan, current = np.full(2, math.nan), slice(CURRENT_NORTH, CURRENT_EAST + 1)
    flows = filters.model.water != STILL
    return Estimate(
        values=mean[learned],
        std=std[learned],
        covariance=covariance,
        mean=mean,
        nu=mean[:PHI],
        angles=mean[PHI:MOVING],
        current=mean[current] if flows else nan,
        current_std=std[current] if flows else nan,
        weights=weights,
        turbulence=float(weights @ np.array(turbulence)),
    )
