"""A bank of filters over one vehicle, compiled: what each expects, takes in, and how likely each makes what is heard.

The members differ in one thing, the intensity of the eddies they reckon with; their likelihoods decide between them
(Magill 1965). Nothing is allocated.
"""

from __future__ import annotations

import math

from firmware_py.compiled import kernel
from firmware_py.estimation.ekf import BATCH, CHANNELS, cut, fuse, spread
from firmware_py.estimation.innovations import hear
from firmware_py.estimation.jacobians import Array
from firmware_py.estimation.prediction import EDDIES, RESPONSE, predict
from firmware_py.estimation.settling import GROWTH, HIGH, LEARNS, LOW, WINDOW, lost, revive, settle
from firmware_py.estimation.transition import MOVING, Picks

EDDY = MOVING + 2
"""Where the eddies stand in the state."""
PHI, THETA, PSI = 6, 7, 8
COS_STEEP = 0.1
"""Where cos(theta) is less, phi and psi mean little and are not taken in."""
ROOM = MOVING + CHANNELS + 2 * BATCH
"""Rows of scratch that `ekf.spread` and `ekf.fuse` take, each as wide as the covariance."""

MODEL = "f8[::1],f8[:,::1],i8[:,::1],f8[::1],i8,i8,b1,f8[:,::1],f8[::1]"
BANK = "f8[:,::1],f8[:,::1],i8[::1],f8,f8,f8,f8[::1],f8[:,::1],f8[:,:,::1],f8[::1],f8[::1]"
HEARD = "f8[::1],f8,f8[::1],f8[::1],f8[::1],i8[::1]"


@kernel("f8(f8)")
def wrapped(angle: float) -> float:
    """The angle in [-pi, pi) that points the same way, rad."""
    if -math.pi <= angle < math.pi:
        return angle
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@kernel("i8(f8[::1],f8[::1])")
def shares(evidence: Array, weights: Array) -> int:
    """Fills the members' probabilities from their log-likelihoods, both (members,); returns the likeliest."""
    likeliest, total = 0, 0.0
    for b in range(1, len(evidence)):
        if evidence[b] > evidence[likeliest]:
            likeliest = b
    for b in range(len(evidence)):
        weights[b] = math.exp(evidence[b] - evidence[likeliest])
        total += weights[b]
    for b in range(len(evidence)):
        weights[b] /= total
    return likeliest


@kernel(f"b1({MODEL},{BANK},{HEARD})")
def step(
    c: Array,
    inverse: Array,
    picks: Picks,
    weight: Array,
    water: int,
    first: int,
    heavy: bool,
    work: Array,
    y: Array,
    room: Array,
    rules: Array,
    bias: Picks,
    eddy_time: float,
    memory: float,
    gate: float,
    eddies: Array,
    x: Array,
    P: Array,
    evidence: Array,
    weights: Array,
    inputs: Array,
    h: float,
    z: Array,
    variance: Array,
    nis: Array,
    rejected: Picks,
) -> bool:
    """Moves every member on by h (s), then takes in what was measured there.

    Args:
        c: the model; this and the next eight, to y, are those of `prediction.predict`.
        room: scratch, (ROOM, ekf.padded(n)); every row of a state is so wide here.
        rules: (RULES, padded), see `settling`.
        bias: place in the state of what each sensor reads too much, (9,); negative for none.
        eddy_time: correlation time of the eddies, s.
        memory: time over which evidence fades, s.
        gate: see `ekf.fuse`.
        eddies: intensity that each member reckons with, m/s, (members,).
        x: states, (members, padded).
        P: covariances, (members, n, padded).
        evidence: faded log-likelihoods, (members,).
        weights: out, (members,): how probable each is, before the measurements of this step.
        inputs: delta_s, delta_r, delta_b (rad), n (rev/s): means over the step.
        h: step, s.
        z: u v w p q r phi theta psi as measured, (9,); NaN where nothing came.
        variance: of each, (9,).
        nis: out, (9,): normalised innovations squared, averaged over the members; NaN where nothing came.
        rejected: how many measurements the likeliest member did not take in, (9,); added to.

    Returns:
        False if a member met a number that is not finite: the bank is to be started anew.
    """
    members, width = x.shape
    n = P.shape[1]
    likeliest = shares(evidence, weights)
    for i in range(MOVING):
        nis[i] = math.nan if math.isnan(z[i]) else 0.0
    fade, keep = math.exp(-h / memory), math.exp(-h / eddy_time)
    T, F, S = room[:MOVING], room[MOVING : MOVING + CHANNELS], room[MOVING + CHANNELS :]
    learns = rules[LEARNS]
    Phi, response = work[:MOVING], work[RESPONSE : RESPONSE + MOVING]

    for b in range(members):
        x_b, P_b = x[b], P[b]
        if not predict(c, inverse, picks, weight, water, first, heavy, inputs, x_b, h, work, y):
            return False
        spread(P_b, Phi, response, picks, weight, y, water, first, T, F)
        for i in range(n):
            P_b[i, i] += h * rules[GROWTH, i]
        if water == EDDIES:
            for i in range(EDDY, EDDY + 3):
                x_b[i] *= keep
                for j in range(width):
                    P_b[i, j] *= keep
                for j in range(n):
                    P_b[j, i] *= keep
                P_b[i, i] += (1.0 - keep * keep) * eddies[b] * eddies[b]

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
                if turning and abs(math.cos(x_b[THETA])) < COS_STEEP:
                    continue
                innovation = z[i] - x_b[i]
                if bias[i] >= 0:
                    innovation -= x_b[bias[i]]
                if turning:
                    innovation = wrapped(innovation)
                square, size = fuse(x_b, P_b, learns, i, bias[i], innovation, variance[i], gate, slot, S)
                heard, sizes = True, sizes * size
                if not square <= gate * gate:
                    square = gate * gate
                    if b == likeliest:
                        rejected[i] += 1
                nis[i] += weights[b] * square
                likelihood -= 0.5 * square
            if heard:
                likelihood -= 0.5 * math.log(sizes)
                cut(P_b, learns, S)
        evidence[b] = fade * evidence[b] + likelihood
        x_b[PHI], x_b[PSI] = wrapped(x_b[PHI]), wrapped(x_b[PSI])
        check = evidence[b] * 0.0
        for j in range(n):
            x_b[j] = min(max(x_b[j], rules[LOW, j]), rules[HIGH, j])
            check += (x_b[j] + P_b[j, j]) * 0.0
        if check != 0.0:
            return False
    return True


@kernel("void(f8[:,::1],f8[:,:,::1],f8[::1],f8[::1],f8[::1],f8[::1])")
def blend(x: Array, P: Array, evidence: Array, weights: Array, mean: Array, std: Array) -> None:
    """The members as one: their probabilities, and mean and 1 sigma of each state.

    Args:
        x: states, (members, padded); an angle is averaged about the first member's.
        P: covariances, (members, n, padded).
        evidence: (members,).
        weights: out, (members,).
        mean: out, (n,).
        std: out, (n,).
    """
    members, n = len(x), len(mean)
    shares(evidence, weights)
    for i in range(n):
        mean[i], std[i] = 0.0, 0.0
    for i in range(n):
        origin = x[0, i]
        for b in range(members):
            apart = x[b, i] - origin
            if i in (PHI, PSI):
                apart = wrapped(apart)
            mean[i] += weights[b] * apart
            std[i] += weights[b] * (P[b, i, i] + apart * apart)
        std[i] = math.sqrt(max(std[i] - mean[i] * mean[i], 0.0))
        mean[i] += origin
        if i in (PHI, PSI):
            mean[i] = wrapped(mean[i])


@kernel(
    f"i8({MODEL},{BANK},f8[:,::1],f8,f8[:,::1],f8[::1],f8[:,::1],i8[::1],"
    "f8[::1],f8,f8,f8[:,::1],i8,i8,f8[:,::1],f8[:,::1],f8[:,::1])"
)
def run(
    c: Array,
    inverse: Array,
    picks: Picks,
    weight: Array,
    water: int,
    first: int,
    heavy: bool,
    work: Array,
    y: Array,
    room: Array,
    rules: Array,
    bias: Picks,
    eddy_time: float,
    memory: float,
    gate: float,
    eddies: Array,
    x: Array,
    P: Array,
    evidence: Array,
    weights: Array,
    inputs: Array,
    h: float,
    z: Array,
    variance: Array,
    nis: Array,
    rejected: Picks,
    age: Array,
    wait: float,
    settling: float,
    window: Array,
    begin: int,
    every: int,
    means: Array,
    stds: Array,
    history: Array,
) -> int:
    """`step` after `step` over K rows, with its arguments but for these.

    Args:
        c: see `step`.
        inputs: one row a step, (K, 4).
        z: one row a step, (K, 9).
        nis: out, (K, 9).
        age: see `settling.settle`, as for `wait` and `settling` (there: fade).
        window: see `settling.lost`.
        begin: the row to begin with.
        every: how many steps apart the members are blended.
        means: out, (K / every, n).
        stds: out, (K / every, n).
        history: out, (K / every, members): the weights.

    Returns:
        The row it came to: less than K if a number was not finite, or the filter was lost (`window` tells).
    """
    for k in range(begin, len(inputs)):
        settle(rules, age, first, h, wait, settling)
        if not step(
            c, inverse, picks, weight, water, first, heavy, work, y, room, rules, bias, eddy_time, memory, gate,
            eddies, x, P, evidence, weights, inputs[k], h, z[k], variance, nis[k], rejected,
        ):  # fmt: skip
            return k
        revive(x, P, evidence)
        if (k + 1) % every == 0:
            row = k // every
            blend(x, P, evidence, history[row], means[row], stds[row])
        hear(nis[k], math.exp(-h / WINDOW), window)
        if lost(window):
            return k + 1
    return len(inputs)
