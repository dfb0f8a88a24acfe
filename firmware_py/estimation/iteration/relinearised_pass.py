"""A tape gone through by a bank, all its slopes drawn about one motion and one set of coefficients, compiled."""

from __future__ import annotations

import math

from firmware_py.compiled import kernel
from firmware_py.estimation.filter.bank import BANK, MODEL, resume, shares
from firmware_py.estimation.filter.consistency import hear
from firmware_py.estimation.filter.measurement_update import PHI, PSI, observe, wrapped
from firmware_py.estimation.filter.start_up import WINDOW, lost
from firmware_py.estimation.iteration.measurement_history import INPUTS, ROW, VARIANCE, H, Z
from firmware_py.estimation.iteration.rts_smoother import place
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.prediction import RESPONSE, predict
from firmware_py.estimation.model.transition import MOVING, WATER, Picks

FLOW = (0, 1, 0, 1, 2)
"""Along which axis each state of the water flows."""


@kernel("void(f8[:,::1],f8[::1],i8[:,::1],f8[::1],i8,i8,f8[::1],f8[::1],f8[::1])")
def follow(
    work: Array, y: Array, picks: Picks, weight: Array, water: int, first: int, about: Array, apart: Array, x: Array
) -> None:
    """Moves the nine of x on: `about` after a step, and what became of `apart`, by which x was off it before.

    Args:
        work: as `prediction.predict` leaves it for `about`, as are y and the rest.
        y: see work.
        picks: see work.
        weight: see work.
        water: see work.
        first: see work.
        about: state after the step, (padded,).
        apart: x less `about` before it, (padded,).
        x: changed.
    """
    for i in range(MOVING):
        moved = about[i]
        for j in range(MOVING):
            moved += work[i, j] * apart[j]
        for j in range(water):
            moved += work[i, WATER + FLOW[j]] * apart[MOVING + j]
        for k in range(len(weight)):
            moved += work[RESPONSE + i, picks[k, 2]] * (weight[k] * y[picks[k, 1]] * apart[first + picks[k, 0]])
        x[i] = moved


@kernel(f"b1({MODEL},{BANK},f8[:,::1],i8,i8,f8[:,::1],f8[::1],f8[:,::1],f8[::1],i8[::1],f8[:,::1],f8[::1])")
def relive(
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
    tape: Array,
    begin: int,
    end: int,
    path: Array,
    about: Array,
    apart: Array,
    nis: Array,
    rejected: Picks,
    window: Array,
    poor: Array,
) -> bool:
    """Takes a bank through rows of a tape, all members by the slopes of one state.

    Args:
        c: this and all before tape are those of `bank.step`.
        tape: (rows, ROW).
        begin: the row to begin with; `end` is behind the last.
        end: see begin.
        path: motion and eddies that slopes are drawn about, before each row, as `smoother.smooth` leaves them.
        about: the rest of that state, (padded,); changed where it moves.
        apart: scratch, (members, padded).
        nis: scratch, (9,).
        rejected: scratch, (9,).
        window: see `settling.lost`.
        poor: out, (1,): becomes 1 where the measurements contradict the bank.

    Returns:
        False if a number is not finite.
    """
    members, width = x.shape
    ring, states = path.shape
    for k in range(begin, end):
        row = tape[k]
        h, z, variance = row[H], row[Z:VARIANCE], row[VARIANCE:ROW]
        if h == 0.0:
            resume(x, P, eddies, water, z, variance)
            continue
        for j in range(states):
            about[place(j)] = path[k % ring, j]
        for i in range(MOVING):
            nis[i] = math.nan if math.isnan(z[i]) else 0.0
        for b in range(members):
            for j in range(width):
                apart[b, j] = x[b, j] - about[j]
            apart[b, PHI], apart[b, PSI] = wrapped(apart[b, PHI]), wrapped(apart[b, PSI])
        shares(evidence, weights)
        if not predict(c, inverse, picks, weight, water, first, heavy, row[INPUTS:Z], about, h, work, y):
            return False
        fade, keep = math.exp(-h / memory), math.exp(-h / eddy_time)
        for b in range(members):
            follow(work, y, picks, weight, water, first, about, apart[b], x[b])
            likelihood = observe(
                picks, weight, water, first, work, y, room, rules, bias, keep, gate, eddies[b], x[b], P[b], weights[b],
                h, z, variance, nis, rejected, False,
            )  # fmt: skip
            evidence[b] = fade * evidence[b] + likelihood
            if evidence[b] * 0.0 != 0.0:
                return False
        hear(nis, math.exp(-h / WINDOW), window)
        if lost(window):
            poor[0] = 1.0
    return True
