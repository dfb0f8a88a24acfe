"""A bank of filters over one vehicle, compiled: what each expects, takes in, and how likely each makes what is heard.

The members differ in one thing, the intensity of the eddies they reckon with; their likelihoods decide between them
(Magill 1965). Nothing is allocated.
"""

from __future__ import annotations

import math

from firmware_py.compiled import kernel
from firmware_py.estimation.filter.consistency import hear
from firmware_py.estimation.filter.measurement_update import EDDY, PHI, PSI, observe, wrapped
from firmware_py.estimation.filter.start_up import WINDOW, leader, lost, revive, settle
from firmware_py.estimation.iteration.measurement_history import write
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.prediction import EDDIES, predict
from firmware_py.estimation.model.transition import MOVING, Picks

MODEL = "f8[::1],f8[:,::1],i8[:,::1],f8[::1],i8,i8,b1,f8[:,::1],f8[::1]"
BANK = "f8[:,::1],f8[:,::1],i8[::1],f8,f8,f8,f8[::1],f8[:,::1],f8[:,:,::1],f8[::1],f8[::1]"
HEARD = "f8[::1],f8,f8[::1],f8[::1],f8[::1],i8[::1]"


@kernel("i8(f8[::1],f8[::1])")
def shares(evidence: Array, weights: Array) -> int:
    """Fills the members' probabilities from their log-likelihoods, both (members,); returns the likeliest."""
    likeliest, total = leader(evidence), 0.0
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
    likeliest = shares(evidence, weights)
    for i in range(MOVING):
        nis[i] = math.nan if math.isnan(z[i]) else 0.0
    fade, keep = math.exp(-h / memory), math.exp(-h / eddy_time)
    for b in range(len(x)):
        if not predict(c, inverse, picks, weight, water, first, heavy, inputs, x[b], h, work, y):
            return False
        likelihood = observe(
            picks, weight, water, first, work, y, room, rules, bias, keep, gate, eddies[b], x[b], P[b], weights[b],
            h, z, variance, nis, rejected, b == likeliest,
        )  # fmt: skip
        evidence[b] = fade * evidence[b] + likelihood
        if evidence[b] * 0.0 != 0.0:
            return False
    return True


@kernel("void(f8[:,::1],f8[:,:,::1],f8[::1],i8,f8[::1],f8[::1])")
def resume(x: Array, P: Array, eddies: Array, water: int, motion: Array, variance: Array) -> None:
    """Lets every member begin anew in motion, (9,), known to `variance`, (9,), and in the eddies about it.

    The current, biases and coefficients stay as they are known; shapes as in `step`.
    """
    last = EDDY + 3 if water == EDDIES else MOVING
    for b in range(len(x)):
        for i in range(last):
            if i < MOVING or i >= EDDY:
                x[b, i] = motion[i] if i < MOVING else 0.0
                for j in range(x.shape[1]):
                    P[b, i, j] = 0.0
                for j in range(P.shape[1]):
                    P[b, j, i] = 0.0
                P[b, i, i] = variance[i] if i < MOVING else eddies[b] * eddies[b]


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
    "f8[::1],f8,f8,f8[:,::1],f8[:,::1],i8,i8,i8,i8,f8[:,::1],f8[:,::1],f8[:,::1])"
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
    tape: Array,
    used: int,
    begin: int,
    end: int,
    every: int,
    means: Array,
    stds: Array,
    history: Array,
) -> int:
    """`step` after `step` over rows, with its arguments but for these.

    Args:
        c: see `step`.
        inputs: one row a step, (K, 4).
        z: one row a step, (K, 9).
        nis: out, (K, 9).
        age: see `settling.settle`, as for `wait` and `settling` (there: fade).
        window: see `settling.lost`.
        tape: see `tape.write`; the row of the first step is `used`, and no more are written than there is room for.
        used: see tape.
        begin: the row to begin with; `end` is behind the last.
        end: see begin.
        every: how many steps apart the members are blended.
        means: out, (K / every, n).
        stds: out, (K / every, n).
        history: out, (K / every, members): the weights.

    Returns:
        The row it came to: less than `end` if a number was not finite, or the filter was lost (`window` tells).
    """
    for k in range(begin, end):
        if used + k - begin < len(tape):
            write(tape, used + k - begin, h, inputs[k], z[k], variance)
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
    return end
