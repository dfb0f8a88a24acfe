"""The time update of one filter's covariance, compiled: paper Eq. 15 with the process noise of eddies and start-up."""

from __future__ import annotations

import math

from firmware_py.compiled import Matrix, Vector, kernel
from firmware_py.estimation.filter.covariance import propagate
from firmware_py.estimation.filter.kernel_arguments import FilterBank
from firmware_py.estimation.model.state import (
    CURRENT_EAST,
    CURRENT_NORTH,
    EDDIES,
    EDDY_EAST,
    EDDY_NORTH,
    MOVING,
    WATER_END,
)


@kernel()
def water_variance(P: Matrix, water: int) -> float:
    """Variance of the water's velocity, all axes together, (m/s)^2; P is a covariance, (n, padded)."""
    variance = 0.0
    for i in range(MOVING, MOVING + water):
        variance += P[i, i]
    if water == EDDIES:
        variance += 2.0 * (P[CURRENT_NORTH, EDDY_NORTH] + P[CURRENT_EAST, EDDY_EAST])
    return variance


@kernel()
def predict_covariance(bank: FilterBank, intensity: float, x: Vector, P: Matrix, h: float) -> None:
    """P = F* P F*' + Q over a step that `prediction.predict` has made with x; eddies in x and P decay.

    Args:
        bank: of the filter: model, linearised step, tuning, settings and scratch are used.
        intensity: of the eddies that the filter assumes, m/s: an Ornstein-Uhlenbeck process on each axis.
        x: state, (padded,).
        P: covariance, (n, padded).
        h: step, s.
    """
    n, width = P.shape
    Q, Q_eddy, model = bank.tuning.Q, bank.tuning.Q_eddy, bank.model
    eddy_noise = intensity * math.sqrt(water_variance(P, model.water))
    propagate(P, model, bank.step, bank.scratch)
    for i in range(n):
        P[i, i] += h * (Q[i] + eddy_noise * Q_eddy[i])
    if model.water == EDDIES:
        decay = math.exp(-h / bank.settings.eddy_time)
        for i in range(EDDY_NORTH, WATER_END):
            x[i] *= decay
            for j in range(width):
                P[i, j] *= decay
            for j in range(n):
                P[j, i] *= decay
            P[i, i] += (1.0 - decay * decay) * intensity * intensity
