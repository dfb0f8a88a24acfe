"""The measurement update of one filter, compiled: innovation, gate, gain, log-likelihood (paper Eq. 16 to 18).

A measurement is one number, so nothing is inverted: sequential scalar updates in the form P - K S K', which is Joseph's
when every gain is the optimal one or nothing; between two states that do not learn P stays (Schmidt 1966). Three share
one pass over P, each knowing what those before it took.
"""

from __future__ import annotations

import math

from firmware_py.compiled import Indices, Matrix, Vector, kernel
from firmware_py.estimation.filter.kernel_arguments import BATCH, FilterBank, UpdateRows
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
def clear(rows: UpdateRows) -> None:
    """Makes the batch empty."""
    for k in range(BATCH):
        for j in range(rows.K.shape[1]):
            rows.PHt[k, j] = 0.0
            rows.K[k, j] = 0.0


@kernel()
def update_state(
    x: Vector,
    P: Matrix,
    learns: Vector,
    i: int,
    bias: int,
    innov: float,
    R: float,
    gate: float,
    slot: int,
    rows: UpdateRows,
) -> tuple[float, float, bool]:
    """Updates x by one number, x += K innov (paper Eq. 16 and 17), and leaves P to `update_covariance`.

    Args:
        x: state, (padded,).
        P: covariance, (n, padded), before this batch.
        learns: see `Tuning`.
        i: the state that is measured: H has a 1 there, and one at the sensor's bias.
        bias: place of the sensor's bias; negative for none.
        innov: innovation, what was measured less what was expected.
        R: variance of the measurement.
        gate: an innovation of more sigmas than this is rejected.
        slot: which of its batch this is.
        rows: the batch.

    Returns:
        nis = innov^2 / S, S = H P H' + R, and whether the gate let the measurement in.
    """
    PHt, K = rows.PHt, rows.K
    width = P.shape[1]
    f_0, f_1 = PHt[0, i], PHt[1, i]
    if bias >= 0:
        f_0, f_1 = f_0 + PHt[0, bias], f_1 + PHt[1, bias]
        for j in range(width):
            PHt[slot, j] = P[i, j] + P[bias, j] - f_0 * PHt[0, j] - f_1 * PHt[1, j]
        S = PHt[slot, i] + PHt[slot, bias] + R
    else:
        for j in range(width):
            PHt[slot, j] = P[i, j] - f_0 * PHt[0, j] - f_1 * PHt[1, j]
        S = PHt[slot, i] + R
    nis = innov * innov / S
    if not nis <= gate * gate:
        for j in range(width):
            PHt[slot, j] = 0.0
        return nis, S, False
    root = 1.0 / math.sqrt(S)
    scaled = innov * root
    for j in range(width):
        row = PHt[slot, j] * root
        learned = row * learns[j]
        PHt[slot, j] = row
        K[slot, j] = learned
        x[j] += learned * scaled
    return nis, S, True


@kernel()
def update_covariance(P: Matrix, learns: Vector, rows: UpdateRows) -> None:
    """P = (I - K H) P for a batch (paper Eq. 18): P - K S K', and P - K H P for states that do not learn.

    Of states that learn two rows are done at once: so what both need is read once.
    """
    n, width = P.shape
    PHt, K = rows.PHt, rows.K
    a = 0
    while a < n:
        f_0, f_1, f_2 = PHt[0, a], PHt[1, a], PHt[2, a]
        if learns[a] == 0.0:
            for j in range(width):
                P[a, j] -= f_0 * K[0, j] + f_1 * K[1, j] + f_2 * K[2, j]
            a += 1
        elif a + 1 == n or learns[a + 1] == 0.0:
            for j in range(width):
                P[a, j] -= f_0 * PHt[0, j] + f_1 * PHt[1, j] + f_2 * PHt[2, j]
            a += 1
        else:
            b = a + 1
            g_0, g_1, g_2 = PHt[0, b], PHt[1, b], PHt[2, b]
            for j in range(width):
                P[a, j] -= f_0 * PHt[0, j] + f_1 * PHt[1, j] + f_2 * PHt[2, j]
                P[b, j] -= g_0 * PHt[0, j] + g_1 * PHt[1, j] + g_2 * PHt[2, j]
            a += 2
    clear(rows)


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
            square, S, accepted = update_state(x, P, learns, i, bias, innov, R[i], gate, slot, rows)
            taken, product_of_S = True, product_of_S * S
            if not accepted:
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
def start_nis(z: Vector, nis: Vector) -> None:
    """Makes the NIS of a step 0 where a measurement came, NaN where none did, (9,) both."""
    for i in range(MOVING):
        nis[i] = math.nan if math.isnan(z[i]) else 0.0
