"""Where the boat and the water went, as far as it can be known afterwards, compiled (Rauch, Tung and Striebel 1965).

Of the eddies a filter knows the present from the past alone. What they did is told by what follows: the boat answers
to a change of the water within seconds. The states smoothed here: the nine that move and, where there are such, the
eddies; all else is taken to be known.
"""

from __future__ import annotations

import math

from firmware_py.compiled import kernel
from firmware_py.estimation.filter.bank import MODEL, resume
from firmware_py.estimation.filter.measurement_update import EDDY, PHI, PSI, observe, wrapped
from firmware_py.estimation.filter.start_up import GROWTH
from firmware_py.estimation.iteration.measurement_history import INPUTS, ROW, VARIANCE, H, Z
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.prediction import EDDIES, predict
from firmware_py.estimation.model.transition import MOVING, WATER, Picks

WAVERING = 3
"""Eddies north, east and down."""
SMOOTHED = MOVING + WAVERING


@kernel("i8(i8)")
def place(j: int) -> int:
    """Where the j-th of the smoothed states stands in a filter's state."""
    return j if j < MOVING else EDDY + j - MOVING


@kernel("b1(f8[:,::1])")
def factored(C: Array) -> bool:
    """Turns C, the lower half of a positive definite matrix, into its Cholesky factor; False if it has none."""
    for j in range(len(C)):
        for k in range(j):
            for i in range(j, len(C)):
                C[i, j] -= C[i, k] * C[j, k]
        if not 0.0 < C[j, j] < math.inf:
            return False
        root = math.sqrt(C[j, j])
        for i in range(j, len(C)):
            C[i, j] /= root
    return True


@kernel("void(f8[:,::1],f8[:,::1])")
def divide(L: Array, G: Array) -> None:
    """G = (L L')^-1 G."""
    states = len(G)
    for i in range(states):
        for k in range(i):
            for j in range(states):
                G[i, j] -= L[i, k] * G[k, j]
        for j in range(states):
            G[i, j] /= L[i, i]
    for i in range(states - 1, -1, -1):
        for k in range(i + 1, states):
            for j in range(states):
                G[i, j] -= L[k, i] * G[k, j]
        for j in range(states):
            G[i, j] /= L[i, i]


@kernel("void(f8[:,::1],f8[:,::1],f8[::1],f8,f8,f8,f8[:,::1],f8[:,::1])")
def gain(work: Array, P: Array, growth: Array, keep: float, kick: float, h: float, C: Array, G: Array) -> None:
    """The smoother's gain of a step, transposed: G = P_after^-1 F P.

    Args:
        work: as `prediction.predict` leaves it: F, but for the eddies' own row.
        P: covariance before the step, (n, padded).
        growth: variance that each state gains by the second, (padded,).
        keep: what is left of an eddy after the step.
        kick: variance that it gains.
        h: step, s.
        C: scratch, (states, states).
        G: out, (states, states); 0 if the covariance after the step has no inverse.
    """
    states = len(G)
    for i in range(states):
        for j in range(states):
            column = place(j)
            if i < MOVING:
                moved = 0.0
                for k in range(MOVING):
                    moved += work[i, k] * P[k, column]
                for k in range(MOVING, states):
                    moved += work[i, WATER + k - MOVING] * P[place(k), column]
                G[i, j] = moved
            else:
                G[i, j] = keep * P[place(i), column]
    for i in range(states):
        for j in range(i + 1):
            if j < MOVING:
                moved = 0.0
                for k in range(MOVING):
                    moved += G[i, k] * work[j, k]
                for k in range(MOVING, states):
                    moved += G[i, k] * work[j, WATER + k - MOVING]
                C[i, j] = moved
            else:
                C[i, j] = keep * G[i, j]
        C[i, i] += h * growth[place(i)] + (kick if i >= MOVING else 0.0)
    if factored(C):
        divide(C, G)
    else:
        G[:] = 0.0


@kernel(
    f"b1({MODEL},f8[:,::1],f8[:,::1],i8[::1],f8,f8,f8[::1],f8[:,::1],f8[:,:,::1],"
    "f8[:,::1],i8,i8,f8[:,::1],f8[:,::1],f8[:,:,::1],f8[:,::1],f8[::1],i8[::1])"
)
def scout(
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
    gate: float,
    eddies: Array,
    x: Array,
    P: Array,
    tape: Array,
    begin: int,
    end: int,
    filtered: Array,
    predicted: Array,
    gains: Array,
    C: Array,
    nis: Array,
    rejected: Picks,
) -> bool:
    """Takes one filter through rows of a tape, and keeps what `smooth` needs.

    Args:
        c: this and all before tape are those of `bank.step`, of one filter and as far as it needs them.
        tape: (rows, ROW).
        begin: the row to begin with; `end` is behind the last.
        end: see begin.
        filtered: out, (ring, states): the state before each row; a row's place is its number modulo the ring's length.
        predicted: out, (ring, states): the state that was expected after it.
        gains: out, (ring, states, states), see `gain`.
        C: scratch, (states, states).
        nis: scratch, (9,).
        rejected: scratch, (9,).

    Returns:
        False if a number is not finite.
    """
    ring, states = filtered.shape
    for k in range(begin, end):
        row, r = tape[k], k % ring
        h, z, variance = row[H], row[Z:VARIANCE], row[VARIANCE:ROW]
        for j in range(states):
            filtered[r, j] = x[0, place(j)]
        if h == 0.0:
            gains[r] = 0.0
            predicted[r] = 0.0
            resume(x, P, eddies, water, z, variance)
            continue
        if not predict(c, inverse, picks, weight, water, first, heavy, row[INPUTS:Z], x[0], h, work, y):
            return False
        keep = math.exp(-h / eddy_time)
        gain(work, P[0], rules[GROWTH], keep, (1.0 - keep * keep) * eddies[0] * eddies[0], h, C, gains[r])
        for j in range(states):
            predicted[r, j] = x[0, place(j)] * (keep if j >= MOVING else 1.0)
        for i in range(MOVING):
            nis[i] = math.nan if math.isnan(z[i]) else 0.0
        likelihood = observe(
            picks, weight, water, first, work, y, room, rules, bias, keep, gate, eddies[0], x[0], P[0], 0.0,
            h, z, variance, nis, rejected, False,
        )  # fmt: skip
        if likelihood * 0.0 != 0.0:
            return False
    return True


@kernel("void(f8[::1],i8,i8,f8[:,::1],f8[:,::1],f8[:,:,::1],f8[::1],f8[:,::1])")
def smooth(
    x: Array, begin: int, end: int, filtered: Array, predicted: Array, gains: Array, moved: Array, path: Array
) -> None:
    """Goes back over the rows from `end`, where the state is x, to `begin`: x_s = x_f + G (x_s after - x_p after).

    Args:
        x: state of the scout, (padded,).
        begin: of `scout`'s rows, as are the next four to gains.
        end: see begin.
        filtered: see begin.
        predicted: see begin.
        gains: see begin.
        moved: scratch, (states,).
        path: out, (ring, states): the smoothed state before each row.
    """
    ring, states = filtered.shape
    for j in range(states):
        moved[j] = x[place(j)]
    for k in range(end - 1, begin - 1, -1):
        r = k % ring
        for j in range(states):
            path[r, j] = filtered[r, j]
        for i in range(states):
            off = moved[i] - predicted[r, i]
            if i in (PHI, PSI):
                off = wrapped(off)
            for j in range(states):
                path[r, j] += gains[r, i, j] * off
        for j in range(states):
            moved[j] = path[r, j]


def smoothed(water: int) -> int:
    """How many states are smoothed in such water."""
    return SMOOTHED if water == EDDIES else MOVING
