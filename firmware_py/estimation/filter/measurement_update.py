"""The measurement update of one filter, compiled: innovation, gating, gain, log-likelihood (paper Eq. 16 to 18)."""

from __future__ import annotations

import math

from firmware_py.compiled import Indices, Matrix, Vector, kernel
from firmware_py.estimation.filter.covariance import clear, update_covariance, update_state
from firmware_py.estimation.filter.kernel_arguments import BATCH, FilterBank
from firmware_py.estimation.model.state import MOVING, PHI, PSI, THETA

COS_STEEP = 0.1
"""Where cos(theta) is less, phi and psi mean little and are not taken in."""


@kernel()
def wrapped(angle: float) -> float:
    """The angle in [-pi, pi) that points the same way, rad."""
    if -math.pi <= angle < math.pi:
        return angle
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@kernel()
def update(
    bank: FilterBank,
    x: Vector,
    P: Matrix,
    weight: float,
    z: Vector,
    R: Vector,
    nis: Vector,
    rejected: Indices,
    counts: bool,
) -> float:
    """Takes in what was measured, one number after the other, and keeps the state within its bounds.

    Args:
        bank: of the filter: tuning, settings, biases and scratch are used.
        x: state, (padded,).
        P: covariance, (n, padded).
        weight: how probable the filter is.
        z: u v w p q r phi theta psi as measured, (9,).
        R: variance of each, (9,).
        nis: (9,): normalised innovations squared are added to, times the weight; NaN where nothing came.
        rejected: how many measurements were rejected, (9,); added to if this filter `counts`.
        counts: see rejected.

    Returns:
        The log-likelihood of the measurements, -1/2 sum(nis + ln S), but for a constant; NaN if a number is not finite.
    """
    rows, gate, bias_state = bank.scratch.rows, bank.settings.gate, bank.bias_state
    learns, lower, upper = bank.tuning.learns, bank.tuning.lower, bank.tuning.upper
    log_likelihood = 0.0
    clear(rows)
    for start in range(0, MOVING, BATCH):
        taken, product_of_S = False, 1.0
        for slot in range(BATCH):
            i = start + slot
            if math.isnan(nis[i]):
                continue
            if i in (PHI, PSI) and abs(math.cos(x[THETA])) < COS_STEEP:
                continue
            innov, bias = z[i] - x[i], bias_state[i]
            if bias >= 0:
                innov -= x[bias]
            if i in (PHI, PSI):
                innov = wrapped(innov)
            square, S = update_state(x, P, learns, i, bias, innov, R[i], gate, slot, rows)
            taken, product_of_S = True, product_of_S * S
            if not square <= gate * gate:
                square = gate * gate
                if counts:
                    rejected[i] += 1
            nis[i] += weight * square
            log_likelihood -= 0.5 * square
        if taken:
            log_likelihood -= 0.5 * math.log(product_of_S)
            update_covariance(P, learns, rows)
    x[PHI], x[PSI] = wrapped(x[PHI]), wrapped(x[PSI])
    check = log_likelihood * 0.0
    for j in range(len(P)):
        x[j] = min(max(x[j], lower[j]), upper[j])
        check += (x[j] + P[j, j]) * 0.0
    return log_likelihood + check


@kernel()
def expect(z: Vector, nis: Vector) -> None:
    """Makes the NIS of a step 0 where a measurement came, NaN where none did, (9,) both."""
    for i in range(MOVING):
        nis[i] = math.nan if math.isnan(z[i]) else 0.0
