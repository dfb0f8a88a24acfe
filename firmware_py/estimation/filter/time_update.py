"""The time update of one filter's covariance, compiled: P = F* P F*' + Q (paper Eq. 15).

The state is nine motion states, a few states of the water, and many that stay and act on the motion through six forces.
So F* is never formed: P = F* P F*' costs two passes of nine rows. Q is the process noise of eddies and start-up.

P is kept whole, and symmetric to the last bit: every pair of entries is computed once, or by the same products. What
makes it lose its rank is not rounding but a model without noise, in which velocities become functions of the
coefficients; a random walk of 1e-5 m/s by sqrt(s) keeps the least eigenvalue of its correlations above 1e-6.

Rows are as wide as whole vectors of the processor make them (`padded`); what is behind the states is 0 and stays 0.
Sums are written out, so that each loop over a row reads it once.
"""

from __future__ import annotations

import math

from firmware_py.compiled import Matrix, Vector, kernel
from firmware_py.estimation.filter.kernel_arguments import CHANNEL_OF_WATER, CHANNELS, FilterBank, Scratch
from firmware_py.estimation.model.kernel_arguments import GROUP, Linearisation, Model
from firmware_py.estimation.model.state import (
    CURRENT_EAST,
    CURRENT_NORTH,
    EDDIES,
    EDDY_EAST,
    EDDY_NORTH,
    EQUATIONS,
    MOVING,
    WATER,
    WATER_END,
)


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
    groups, forces, first = model.groups, step.regressors, model.first
    parameters, regressors, weights, equations = groups.parameter, groups.regressor, groups.weight, groups.equation
    for r in range(CHANNELS):
        for j in range(width):
            channels[r, j] = 0.0
    for g in range(len(equations)):
        k, channel = GROUP * g, equations[g]
        f_0, f_1 = weights[k] * forces[regressors[k]], weights[k + 1] * forces[regressors[k + 1]]
        f_2, f_3 = weights[k + 2] * forces[regressors[k + 2]], weights[k + 3] * forces[regressors[k + 3]]
        a, b = first + parameters[k], first + parameters[k + 1]
        c, d = first + parameters[k + 2], first + parameters[k + 3]
        for j in range(width):
            channels[channel, j] += f_0 * P[a, j] + f_1 * P[b, j] + f_2 * P[c, j] + f_3 * P[d, j]
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
            for i in range(EDDY_NORTH, WATER_END):
                P[j, i] *= decay
        for i in range(EDDY_NORTH, WATER_END):
            P[i, i] += (1.0 - decay * decay) * intensity * intensity
