"""The arithmetic of the extended Kalman filter on its covariance, compiled: paper Eq. 15 to 18.

The state is nine motion states, a few states of the water, and many that stay and act on the motion through six forces.
So F* is never formed: P = F* P F*' costs two passes of nine rows.

The covariance P is kept whole, and symmetric to the last bit: every pair of entries is computed once, or by the same
products. A measurement is one number, so nothing is inverted: sequential scalar updates in the form P - K S K', which
is Joseph's when every gain is the optimal one or nothing; between two states that do not learn P stays (Schmidt 1966).
Three share one pass over P, each knowing what those before it took.
What makes P lose its rank is not rounding but a model without noise, in which velocities become functions of the
coefficients; a random walk of 1e-5 m/s by sqrt(s) keeps the least eigenvalue of its correlations above 1e-6.

Rows are as wide as whole vectors of the processor make them (`padded`); what is behind the states is 0 and stays 0.
Sums are written out, so that each loop over a row reads it once.
"""

from __future__ import annotations

import math

from firmware_py.compiled import Matrix, Vector, kernel
from firmware_py.estimation.filter.kernel_arguments import BATCH, CHANNEL_OF_WATER, CHANNELS, Scratch, UpdateRows
from firmware_py.estimation.model.kernel_arguments import Linearisation, Model
from firmware_py.estimation.model.state import EQUATIONS, MOVING, WATER


@kernel()
def channel_covariance(P: Matrix, model: Model, step: Linearisation, width: int, channels: Matrix) -> None:
    """Fills the covariance of each channel, a force or a velocity of the water, with each of the first states.

    Args:
        P: covariance, (n, padded).
        model: says which parameter makes which force.
        step: its regressors say how much.
        width: how many states.
        channels: out, (CHANNELS, width).
    """
    parameters, regressors, equations = model.terms.parameter, model.terms.regressor, model.terms.equation
    weights, forces, first = model.terms.weight, step.regressors, model.first
    for r in range(CHANNELS):
        for j in range(width):
            channels[r, j] = 0.0
    for k in range(len(weights)):
        force = weights[k] * forces[regressors[k]]
        parameter, channel = first + parameters[k], equations[k]
        for j in range(width):
            channels[channel, j] += force * P[parameter, j]
    for d in range(model.water):
        channel = CHANNEL_OF_WATER[d]
        for j in range(width):
            channels[channel, j] += P[MOVING + d, j]


@kernel()
def motion_rows(P: Matrix, step: Linearisation, channels: Matrix, width: int, FP: Matrix) -> None:
    """The motion's rows of F* P, (9, width); `channels` is from `channel_covariance`."""
    Phi, response = step.Phi, step.response
    for i in range(MOVING):
        a_0, a_1, a_2, a_3, a_4, a_5 = Phi[i, 0], Phi[i, 1], Phi[i, 2], Phi[i, 3], Phi[i, 4], Phi[i, 5]
        a_6, a_7, a_8 = Phi[i, 6], Phi[i, 7], Phi[i, 8]
        w_0, w_1, w_2 = Phi[i, WATER], Phi[i, WATER + 1], Phi[i, WATER + 2]
        r_0, r_1, r_2 = response[i, 0], response[i, 1], response[i, 2]
        r_3, r_4, r_5 = response[i, 3], response[i, 4], response[i, 5]
        for j in range(width):
            moved = (
                a_0 * P[0, j]
                + a_1 * P[1, j]
                + a_2 * P[2, j]
                + a_3 * P[3, j]
                + a_4 * P[4, j]
                + a_5 * P[5, j]
                + a_6 * P[6, j]
                + a_7 * P[7, j]
                + a_8 * P[8, j]
            )
            forced = (
                r_0 * channels[0, j]
                + r_1 * channels[1, j]
                + r_2 * channels[2, j]
                + r_3 * channels[3, j]
                + r_4 * channels[4, j]
                + r_5 * channels[5, j]
            )
            carried = w_0 * channels[EQUATIONS, j] + w_1 * channels[EQUATIONS + 1, j] + w_2 * channels[EQUATIONS + 2, j]
            FP[i, j] = moved + forced + carried


@kernel()
def propagate(P: Matrix, model: Model, step: Linearisation, scratch: Scratch) -> None:
    """P = F* P F*' (paper Eq. 15, without Q), P being (n, padded).

    As P = P', that is F* (F* P)': the same twice, the second time for the columns of the motion alone.
    """
    n, width = P.shape
    FP, channels = scratch.FP, scratch.channels
    channel_covariance(P, model, step, width, channels)
    motion_rows(P, step, channels, width, FP)
    for j in range(n):
        for i in range(MOVING):
            P[j, i] = FP[i, j]
    for i in range(MOVING):
        for j in range(MOVING, n):
            P[i, j] = FP[i, j]
    channel_covariance(P, model, step, WATER + 3, channels)
    motion_rows(P, step, channels, WATER + 3, FP)
    for i in range(MOVING):
        for j in range(i + 1):
            P[i, j] = FP[i, j]
            P[j, i] = FP[i, j]


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
) -> tuple[float, float]:
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
        nis = innov^2 / S, and S = H P H' + R. The measurement was taken in if nis <= gate^2.
    """
    PHt, K = rows.PHt, rows.K
    width = len(x)
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
        return nis, S
    root = 1.0 / math.sqrt(S)
    scaled = innov * root
    for j in range(width):
        row = PHt[slot, j] * root
        learned = row * learns[j]
        PHt[slot, j] = row
        K[slot, j] = learned
        x[j] += learned * scaled
    return nis, S


@kernel()
def update_covariance(P: Matrix, learns: Vector, rows: UpdateRows) -> None:
    """P = (I - K H) P for a batch (paper Eq. 18): P - K S K', and P - K H P for states that do not learn."""
    n, width = P.shape
    PHt, K = rows.PHt, rows.K
    for a in range(n):
        f_0, f_1, f_2 = PHt[0, a], PHt[1, a], PHt[2, a]
        if learns[a] != 0.0:
            for j in range(width):
                P[a, j] -= f_0 * PHt[0, j] + f_1 * PHt[1, j] + f_2 * PHt[2, j]
        else:
            for j in range(width):
                P[a, j] -= f_0 * K[0, j] + f_1 * K[1, j] + f_2 * K[2, j]
    clear(rows)
