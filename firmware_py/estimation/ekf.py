"""The extended Kalman filter's arithmetic, compiled: how a covariance spreads over a step, how a measurement cuts it.

The state is nine numbers that move, a few that carry them along (the drift, three numbers made of up to five states),
and many that stay and push the moving ones through six channels (paper Eq. 14 to 18; the parameters of Eq. 13).

The covariance P is kept whole, and symmetric to the last bit: every pair of entries is computed once, or by the same
products. A measurement is one number, so nothing is inverted: sequential scalar updates, in what remains of Joseph's
form when every gain is the optimal one or nothing: P - s s', but between two states that do not learn (Schmidt 1966).
What makes P lose its rank is not rounding but a model without noise, in which velocities become functions of the
coefficients; a random walk of 1e-5 m/s by sqrt(s) keeps the least eigenvalue of its correlations above 1e-6.
"""

from __future__ import annotations

import math

from firmware_py.compiled import kernel
from firmware_py.estimation.jacobians import Array
from firmware_py.estimation.transition import MOVING, WATER, Picks

CHANNELS = 6


@kernel("i8(i8)")
def axis(j: int) -> int:
    """Which column of Phi the drift's state j belongs to: the first two are steady, the others waver about them."""
    return WATER + (j if j < 2 else j - 2)


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

    Args:
        P: covariance, (n, n).
        Phi: from `prediction.predict`, as are `response` and y.
        response: see there.
        picks: which state pushes which channel, see there; `weight` likewise.
        weight: see `picks`.
        y: what it pushes by.
        drift: how many states the drift has, behind those that move.
        first: place of the first state that pushes.
        T: scratch, (9, n).
        F: scratch, (6, n).
    """
    n = P.shape[0]
    for r in range(CHANNELS):
        for j in range(n):
            F[r, j] = 0.0
    for k in range(len(weight)):
        push, row, channel = weight[k] * y[picks[k, 1]], first + picks[k, 0], picks[k, 2]
        for j in range(n):
            F[channel, j] += push * P[row, j]
    for i in range(MOVING):
        a_0, a_1, a_2, a_3, a_4 = Phi[i, 0], Phi[i, 1], Phi[i, 2], Phi[i, 3], Phi[i, 4]
        a_5, a_6, a_7, a_8 = Phi[i, 5], Phi[i, 6], Phi[i, 7], Phi[i, 8]
        r_0, r_1, r_2 = response[i, 0], response[i, 1], response[i, 2]
        r_3, r_4, r_5 = response[i, 3], response[i, 4], response[i, 5]
        for j in range(n):
            T[i, j] = (
                a_0 * P[0, j]
                + a_1 * P[1, j]
                + a_2 * P[2, j]
                + a_3 * P[3, j]
                + a_4 * P[4, j]
                + a_5 * P[5, j]
                + a_6 * P[6, j]
                + a_7 * P[7, j]
                + a_8 * P[8, j]
                + r_0 * F[0, j]
                + r_1 * F[1, j]
                + r_2 * F[2, j]
                + r_3 * F[3, j]
                + r_4 * F[4, j]
                + r_5 * F[5, j]
            )
        for d in range(drift):
            a = Phi[i, axis(d)]
            for j in range(n):
                T[i, j] += a * P[MOVING + d, j]

    for i in range(MOVING):
        for j in range(MOVING, n):
            P[i, j] = T[i, j]
            P[j, i] = T[i, j]
        for r in range(CHANNELS):
            F[r, i] = 0.0
        for k in range(len(weight)):
            F[picks[k, 2], i] += weight[k] * y[picks[k, 1]] * T[i, first + picks[k, 0]]
    for i in range(MOVING):
        for j in range(i + 1):
            value = 0.0
            for k in range(MOVING):
                value += T[i, k] * Phi[j, k]
            for r in range(CHANNELS):
                value += F[r, i] * response[j, r]
            for d in range(drift):
                value += T[i, MOVING + d] * Phi[j, axis(d)]
            P[i, j] = value
            P[j, i] = value


@kernel("UniTuple(f8,2)(f8[::1],f8[:,::1],f8[::1],i8,i8,f8,f8,f8,f8[::1],f8[::1])")
def fuse(
    x: Array,
    P: Array,
    learns: Array,
    i: int,
    bias: int,
    innovation: float,
    variance: float,
    gate: float,
    s: Array,
    m: Array,
) -> tuple[float, float]:
    """Takes in one number that measures state i, or the sum of states i and `bias`.

    Args:
        x: state, (n,).
        P: covariance, (n, n).
        learns: 1 for states that follow measurements, 0 for those that are considered only, (n,).
        i: the state that is measured.
        bias: the state that its sensor adds to it; negative for none.
        innovation: what was measured less what was expected.
        variance: of the measurement.
        gate: an innovation of more sigmas than this is not taken in.
        s: scratch, (n,); m too.
        m: see `s`.

    Returns:
        The innovation's square over its variance S (NIS), and log S. It was taken in if the first is <= gate^2.
    """
    n = len(x)
    for j in range(n):
        s[j] = P[i, j]
    S = s[i]
    if bias >= 0:
        for j in range(n):
            s[j] += P[bias, j]
        S = s[i] + s[bias]
    S += variance
    nis = innovation * innovation / S
    if not nis <= gate * gate:
        return nis, math.log(S)
    root = 1.0 / math.sqrt(S)
    step = innovation * root
    for j in range(n):
        s[j] *= root
        m[j] = s[j] * learns[j]
        x[j] += m[j] * step
    for a in range(n):
        if learns[a] != 0.0:
            f = s[a]
            for j in range(n):
                P[a, j] -= f * s[j]
        else:
            f = s[a]
            for j in range(n):
                P[a, j] -= f * m[j]
    return nis, math.log(S)
