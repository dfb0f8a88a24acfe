"""Where the vehicle and the water went, as far as it can be known afterwards, compiled (Rauch, Tung and Striebel 1965).

Of the eddies a filter knows the present from the past alone. What they did is told by what follows: the vehicle answers
to a change of the water within seconds. The states smoothed here: the nine that move and, where there are such, the
eddies; all else is taken to be known.
"""

from __future__ import annotations

import math

from firmware_py.compiled import Cube, Indices, Matrix, Vector, kernel
from firmware_py.estimation.filter.bank import reset_motion
from firmware_py.estimation.filter.kernel_arguments import FilterBank
from firmware_py.estimation.filter.measurement_history import MeasurementHistory
from firmware_py.estimation.filter.measurement_update import start_nis, update, wrapped
from firmware_py.estimation.filter.time_update import predict_covariance
from firmware_py.estimation.model.prediction import predict
from firmware_py.estimation.model.state import EDDIES, EDDY_NORTH, MOVING, PHI, PSI, WATER

EDDY_STATES = 3
"""Eddies north, east and down."""
SMOOTHED = MOVING + EDDY_STATES


@kernel()
def place(j: int) -> int:
    """Where the j-th of the smoothed states stands in a filter's state."""
    return j if j < MOVING else EDDY_NORTH + j - MOVING


@kernel()
def factored(C: Matrix) -> bool:
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


@kernel()
def divide(L: Matrix, G: Matrix) -> None:
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


@kernel()
def gain(Phi: Matrix, P: Matrix, Q: Vector, decay: float, kick: float, h: float, C: Matrix, G: Matrix) -> None:
    """The smoother's gain of a step, transposed: G = P_after^-1 F P.

    Args:
        Phi: of the step; all of F but the eddies' own rows.
        P: covariance before the step, (n, padded).
        Q: variance that each state gains by the second, (padded,).
        decay: what is left of an eddy after the step.
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
                    moved += Phi[i, k] * P[k, column]
                for k in range(MOVING, states):
                    moved += Phi[i, WATER + k - MOVING] * P[place(k), column]
                G[i, j] = moved
            else:
                G[i, j] = decay * P[place(i), column]
    for i in range(states):
        for j in range(i + 1):
            if j < MOVING:
                moved = 0.0
                for k in range(MOVING):
                    moved += G[i, k] * Phi[j, k]
                for k in range(MOVING, states):
                    moved += G[i, k] * Phi[j, WATER + k - MOVING]
                C[i, j] = moved
            else:
                C[i, j] = decay * G[i, j]
        C[i, i] += h * Q[place(i)] + (kick if i >= MOVING else 0.0)
    if factored(C):
        divide(C, G)
    else:
        G[:] = 0.0


@kernel()
def reference_pass(
    bank: FilterBank,
    history: MeasurementHistory,
    begin: int,
    end: int,
    filtered: Matrix,
    predicted: Matrix,
    gains: Cube,
    C: Matrix,
    nis: Vector,
    rejected: Indices,
) -> bool:
    """Takes one filter through rows of the history, and keeps what `smooth` needs.

    Args:
        bank: of one filter.
        history: what it is given.
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
    x, P, intensity = bank.x[0], bank.P[0], bank.intensity[0]
    for k in range(begin, end):
        r = k % ring
        h, z, R = history.h[k], history.z[k], history.R[k]
        for j in range(states):
            filtered[r, j] = x[place(j)]
        if h == 0.0:
            gains[r] = 0.0
            predicted[r] = 0.0
            reset_motion(bank, z, R)
            continue
        if not predict(bank.model, history.inputs[k], h, x, bank.step):
            return False
        decay = math.exp(-h / bank.settings.eddy_time)
        gain(bank.step.Phi, P, bank.tuning.Q, decay, (1.0 - decay * decay) * intensity * intensity, h, C, gains[r])
        for j in range(states):
            predicted[r, j] = x[place(j)] * (decay if j >= MOVING else 1.0)
        start_nis(z, nis)
        predict_covariance(bank, intensity, x, P, h)
        if update(bank, x, P, 0.0, z, R, nis, rejected, False) * 0.0 != 0.0:
            return False
    return True


@kernel()
def smooth(
    x: Vector, begin: int, end: int, filtered: Matrix, predicted: Matrix, gains: Cube, moved: Vector, path: Matrix
) -> None:
    """Goes back over the rows from `end`, where the state is x, to `begin`: x_s = x_f + G (x_s after - x_p after).

    Args:
        x: state of the filter at the end, (padded,).
        begin: of `reference_pass`, as are the next four to gains.
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
