"""The extended Kalman filter's arithmetic, compiled: how a covariance spreads over a step, how measurements cut it.

The state is nine numbers that move, a few that carry them along (the drift, three numbers made of up to five states),
and many that stay and push the moving ones through six forces (paper Eq. 14 to 18; the parameters of Eq. 13).

The covariance P is kept whole, and symmetric to the last bit: every pair of entries is computed once, or by the same
products. A measurement is one number, so nothing is inverted: sequential scalar updates, in what remains of Joseph's
form when every gain is the optimal one or nothing: P - s s', but between two states that do not learn (Schmidt 1966).
Three share one pass over P, each knowing what those before it took.
What makes P lose its rank is not rounding but a model without noise, in which velocities become functions of the
coefficients; a random walk of 1e-5 m/s by sqrt(s) keeps the least eigenvalue of its correlations above 1e-6.

Rows are as wide as whole vectors of the processor make them (`padded`); what is behind the states is 0 and stays 0.
Sums are written out, so that each loop over a row reads it once.
"""

from __future__ import annotations

import math

from firmware_py.compiled import kernel
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.transition import MOVING, WATER, Picks

FORCES = 6
CHANNELS = 9
"""Through what all others push the moving states: a force in each equation, then the drift along each axis."""
VECTOR = 4
"""Numbers that the processor takes at once."""
BATCH = 3
"""Measurements that are taken in before they cut the covariance, all at once."""


def padded(n: int) -> int:
    """The least whole number of vectors that holds n states and the columns of Phi."""
    return -(-max(n, WATER + 3) // VECTOR) * VECTOR


@kernel("void(f8[:,::1],i8[:,::1],f8[::1],f8[::1],i8,i8,i8,f8[:,::1])")
def gather(P: Array, picks: Picks, weight: Array, y: Array, drift: int, first: int, width: int, F: Array) -> None:
    """Fills F, (CHANNELS, width), with the rows of P that push, each times what it pushes by; see `spread`."""
    for r in range(CHANNELS):
        for j in range(width):
            F[r, j] = 0.0
    for k in range(len(weight)):
        push, row, channel = weight[k] * y[picks[k, 1]], first + picks[k, 0], picks[k, 2]
        for j in range(width):
            F[channel, j] += push * P[row, j]
    for d in range(drift):  # the first two are steady, the others waver about them
        channel = FORCES + (d if d < 2 else d - 2)
        for j in range(width):
            F[channel, j] += P[MOVING + d, j]


@kernel("void(f8[:,::1],f8[:,::1],f8[:,::1],f8[:,::1],i8,f8[:,::1])")
def carry(P: Array, Phi: Array, response: Array, F: Array, width: int, T: Array) -> None:
    """T = Phi P, the rows that move, (9, width); F is from `gather`."""
    for i in range(MOVING):
        a_0, a_1, a_2, a_3, a_4, a_5 = Phi[i, 0], Phi[i, 1], Phi[i, 2], Phi[i, 3], Phi[i, 4], Phi[i, 5]
        a_6, a_7, a_8, w_0, w_1, w_2 = Phi[i, 6], Phi[i, 7], Phi[i, 8], Phi[i, 9], Phi[i, 10], Phi[i, 11]
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
            pushed = r_0 * F[0, j] + r_1 * F[1, j] + r_2 * F[2, j] + r_3 * F[3, j] + r_4 * F[4, j] + r_5 * F[5, j]
            T[i, j] = moved + pushed + (w_0 * F[6, j] + w_1 * F[7, j] + w_2 * F[8, j])


@kernel("void(f8[:,::1],f8[:,::1],f8[:,::1],i8[:,::1],f8[::1],f8[::1],i8,i8,f8[:,::1],f8[:,::1])")
def spread(
    P: Array,
    Phi: Array,
    response: Array,
    picks: Picks,
    weight: Array,
    y: Array,
    drift: int,
    first: int,
    T: Array,
    F: Array,
) -> None:
    """P = Phi P Phi', the transition being Phi for what moves, `response` times what pushes, and the identity.

    As P = P', that is Phi (Phi P)': the same twice, the second time for the columns that move alone.

    Args:
        P: covariance, (n, padded).
        Phi: from `prediction.predict`, as are `response` and y.
        response: see there.
        picks: which state pushes which channel, see there; `weight` likewise.
        weight: see `picks`.
        y: what it pushes by.
        drift: how many states the drift has, behind those that move.
        first: place of the first state that pushes.
        T: scratch, (9, padded).
        F: scratch, (CHANNELS, padded).
    """
    n, width = P.shape
    gather(P, picks, weight, y, drift, first, width, F)
    carry(P, Phi, response, F, width, T)
    for j in range(n):
        for i in range(MOVING):
            P[j, i] = T[i, j]
    for i in range(MOVING):
        for j in range(MOVING, n):
            P[i, j] = T[i, j]
    gather(P, picks, weight, y, drift, first, WATER + 3, F)
    carry(P, Phi, response, F, WATER + 3, T)
    for i in range(MOVING):
        for j in range(i + 1):
            P[i, j] = T[i, j]
            P[j, i] = T[i, j]


@kernel("UniTuple(f8,2)(f8[::1],f8[:,::1],f8[::1],i8,i8,f8,f8,f8,i8,f8[:,::1])")
def fuse(
    x: Array,
    P: Array,
    learns: Array,
    i: int,
    bias: int,
    innovation: float,
    variance: float,
    gate: float,
    slot: int,
    S: Array,
) -> tuple[float, float]:
    """Takes in one number that measures state i, or the sum of states i and `bias`: moves x, and leaves P to `cut`.

    Args:
        x: state, (padded,).
        P: covariance, (n, padded), before this batch.
        learns: 1 for states that follow measurements, 0 for those that are considered only, (padded,).
        i: the state that is measured.
        bias: the state that its sensor adds to it; negative for none.
        innovation: what was measured less what was expected.
        variance: of the measurement.
        gate: an innovation of more sigmas than this is not taken in.
        slot: which of its batch this is.
        S: the batch, (2 BATCH, padded): what each takes from P's square root, in all, then in states that learn; rows
            of slots that are not (yet) taken are 0.

    Returns:
        The innovation's square over its variance (NIS), and its variance. It was taken in if the first is <= gate^2.
    """
    width = len(x)
    f_0, f_1 = S[0, i], S[1, i]
    if bias >= 0:
        f_0, f_1 = f_0 + S[0, bias], f_1 + S[1, bias]
        for j in range(width):
            S[slot, j] = P[i, j] + P[bias, j] - f_0 * S[0, j] - f_1 * S[1, j]
        size = S[slot, i] + S[slot, bias] + variance
    else:
        for j in range(width):
            S[slot, j] = P[i, j] - f_0 * S[0, j] - f_1 * S[1, j]
        size = S[slot, i] + variance
    nis = innovation * innovation / size
    if not nis <= gate * gate:
        for j in range(width):
            S[slot, j] = 0.0
        return nis, size
    root = 1.0 / math.sqrt(size)
    step = innovation * root
    for j in range(width):
        s = S[slot, j] * root
        m = s * learns[j]
        S[slot, j] = s
        S[BATCH + slot, j] = m
        x[j] += m * step
    return nis, size


@kernel("void(f8[:,::1],f8[::1],f8[:,::1])")
def cut(P: Array, learns: Array, S: Array) -> None:
    """Takes a batch of `fuse` out of P, and makes the batch 0."""
    n, width = P.shape
    for a in range(n):
        f_0, f_1, f_2 = S[0, a], S[1, a], S[2, a]
        if learns[a] != 0.0:
            for j in range(width):
                P[a, j] -= f_0 * S[0, j] + f_1 * S[1, j] + f_2 * S[2, j]
        else:
            for j in range(width):
                P[a, j] -= f_0 * S[3, j] + f_1 * S[4, j] + f_2 * S[5, j]
    for k in range(2 * BATCH):
        for j in range(width):
            S[k, j] = 0.0
