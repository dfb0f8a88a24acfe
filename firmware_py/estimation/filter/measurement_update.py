"""What one filter of a bank does with a step's measurements, compiled; nothing is allocated."""

from __future__ import annotations

import math

from firmware_py.compiled import kernel
from firmware_py.estimation.filter.covariance import BATCH, CHANNELS, cut, fuse, spread
from firmware_py.estimation.filter.start_up import GROWTH, HIGH, LEARNS, LOW, STIRS
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.prediction import EDDIES, RESPONSE
from firmware_py.estimation.model.transition import MOVING, Picks

EDDY = MOVING + 2
"""Where the eddies stand in the state."""
PHI, THETA, PSI = 6, 7, 8
COS_STEEP = 0.1
"""Where cos(theta) is less, phi and psi mean little and are not taken in."""
ROOM = MOVING + CHANNELS + 2 * BATCH
"""Rows of scratch that `ekf.spread` and `ekf.fuse` take, each as wide as the covariance."""


@kernel("f8(f8)")
def wrapped(angle: float) -> float:
    """The angle in [-pi, pi) that points the same way, rad."""
    if -math.pi <= angle < math.pi:
        return angle
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@kernel("f8(f8[:,::1],i8)")
def unknown(P: Array, water: int) -> float:
    """Variance of the water's velocity, all axes together, (m/s)^2; P is a covariance, (n, padded)."""
    variance = 0.0
    for i in range(MOVING, MOVING + water):
        variance += P[i, i]
    if water == EDDIES:
        variance += 2.0 * (P[MOVING, EDDY] + P[MOVING + 1, EDDY + 1])
    return variance


@kernel(
    "f8(i8[:,::1],f8[::1],i8,i8,f8[:,::1],f8[::1],f8[:,::1],f8[:,::1],i8[::1],f8,f8,f8,f8[::1],f8[:,::1],"
    "f8,f8,f8[::1],f8[::1],f8[::1],i8[::1],b1)"
)
def observe(
    picks: Picks,
    weight: Array,
    water: int,
    first: int,
    work: Array,
    y: Array,
    room: Array,
    rules: Array,
    bias: Picks,
    keep: float,
    gate: float,
    eddy: float,
    x: Array,
    P: Array,
    share: float,
    h: float,
    z: Array,
    variance: Array,
    nis: Array,
    rejected: Picks,
    counts: bool,
) -> float:
    """Moves a member's covariance on by h (s), its state being there already, and takes in what was measured.

    Args:
        picks: of the model, as the next five to y, which `prediction.predict` left behind.
        weight: see picks.
        water: see picks.
        first: see picks.
        work: see picks.
        y: see picks.
        room: scratch, (ROOM, padded).
        rules: (RULES, padded), see `settling`.
        bias: place in the state of what each sensor reads too much, (9,); negative for none.
        keep: what is left of an eddy after the step.
        gate: see `ekf.fuse`.
        eddy: intensity of the eddies that it reckons with, m/s.
        x: state, (padded,).
        P: covariance, (n, padded).
        share: how probable the member is.
        h: step, s.
        z: u v w p q r phi theta psi as measured, (9,); NaN where nothing came.
        variance: of each, (9,).
        nis: (9,), its normalised innovations squared are added to, times `share`; NaN where nothing came.
        rejected: how many measurements were not taken in, (9,); added to if this member `counts`.
        counts: see rejected.

    Returns:
        The log-likelihood of the measurements; NaN if a number is not finite.
    """
    n, width = P.shape
    T, F, S = room[:MOVING], room[MOVING : MOVING + CHANNELS], room[MOVING + CHANNELS :]
    learns = rules[LEARNS]
    stir = eddy * math.sqrt(unknown(P, water))
    spread(P, work[:MOVING], work[RESPONSE : RESPONSE + MOVING], picks, weight, y, water, first, T, F)
    for i in range(n):
        P[i, i] += h * (rules[GROWTH, i] + stir * rules[STIRS, i])
    if water == EDDIES:
        for i in range(EDDY, EDDY + 3):
            x[i] *= keep
            for j in range(width):
                P[i, j] *= keep
            for j in range(n):
                P[j, i] *= keep
            P[i, i] += (1.0 - keep * keep) * eddy * eddy

    likelihood = 0.0
    for k in range(2 * BATCH):
        for j in range(width):
            S[k, j] = 0.0
    for start in range(0, MOVING, BATCH):
        heard, sizes = False, 1.0
        for slot in range(BATCH):
            i = start + slot
            if math.isnan(nis[i]):
                continue
            turning = i in (PHI, PSI)
            if turning and abs(math.cos(x[THETA])) < COS_STEEP:
                continue
            innovation = z[i] - x[i]
            if bias[i] >= 0:
                innovation -= x[bias[i]]
            if turning:
                innovation = wrapped(innovation)
            square, size = fuse(x, P, learns, i, bias[i], innovation, variance[i], gate, slot, S)
            heard, sizes = True, sizes * size
            if not square <= gate * gate:
                square = gate * gate
                if counts:
                    rejected[i] += 1
            nis[i] += share * square
            likelihood -= 0.5 * square
        if heard:
            likelihood -= 0.5 * math.log(sizes)
            cut(P, learns, S)
    x[PHI], x[PSI] = wrapped(x[PHI]), wrapped(x[PSI])
    check = likelihood * 0.0
    for j in range(n):
        x[j] = min(max(x[j], rules[LOW, j]), rules[HIGH, j])
        check += (x[j] + P[j, j]) * 0.0
    return likelihood + check
