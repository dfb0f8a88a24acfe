"""The Bayesian Cramér-Rao bound: how well anybody can know a state from measurements of a flight and what was believed.

It is computed in information form, along the true motion, with nothing of the filter's covariance recursion: the
sensitivity of the moving states to the state at the start is carried along, S = Phi S, and each measurement adds
S' H' R^-1 H S to the information (Van Trees 1968, part I, section 2.4). The motion is taken to be deterministic: there
is no process noise, so a sea with eddies is not covered.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.estimation.model.state import CURRENT, MOVING
from firmware_py.run.usage_error import UsageError
from sternplane.identification.sensitivity import carry, inform
from sternplane.logs.tracking import Array

_SINGULAR = 1e-13
"""Eigenvalues of normalised information below this part of the largest are rounding."""


def bounds(
    model: ObserverModel,
    x: Array,
    inputs: Array,
    h: float,
    measured: NDArray[np.bool_],
    std: Array,
    prior_std: Array,
    at: Sequence[int],
) -> Array:
    """The bound after each number of steps in `at`, which rises: covariances, (len(at), size, size).

    Args:
        model: the observer's; its water steady or still.
        x: true states, (K + 1, size).
        inputs: (K, 4), means over each step.
        h: step, s.
        measured: (K, 9), which of u v w p q r phi theta psi came at the end of each step.
        std: (9,) of their noise.
        prior_std: (size,) of what is believed at the start; 0 is known exactly, inf not at all.
        at: numbers of steps.

    Returns:
        Of the state at those times; without bound (up to 1e300) along what neither flight nor belief tells.

    Raises:
        UsageError: water with eddies, or a true motion that the model cannot follow.
    """
    if model.water > CURRENT:
        raise UsageError("the bound knows no process noise: give a model with steady water (0 or 2 states)")
    size = model.size
    S, T, J, s = np.zeros((MOVING, size)), np.zeros((MOVING, size)), np.zeros((size, size)), np.zeros(size)
    S[:, :MOVING] = np.eye(MOVING)
    bias = np.full(MOVING, -1, dtype=np.int64)
    for i, state in enumerate(model.biases):
        bias[state] = MOVING + model.water + i
    came, noise = np.ascontiguousarray(measured), np.ascontiguousarray(std, dtype=np.float64)
    found: list[Array] = []
    rows = list(at)
    for k in range(rows[-1]):
        if not model.advance(x[k].copy(), inputs[k], h):
            raise UsageError(f"the model cannot follow the motion at step {k}: a number is not finite")
        S, T = T, S
        carry(model.arrays, model.linearisation, T, S)
        if came[k].any():
            inform(S, bias, came[k], noise, s, J)
        if k + 1 == rows[len(found)]:
            whole = np.tril(J) + np.tril(J, -1).T
            start = _inverse(whole, prior_std)
            move = np.eye(size)
            move[:MOVING] = S
            found.append(move @ start @ move.T)
    return np.array(found)


def bound(
    model: ObserverModel,
    x: Array,
    inputs: Array,
    h: float,
    measured: NDArray[np.bool_],
    std: Array,
    prior_std: Array,
) -> Array:
    """The bound after the whole flight, (size, size); see `bounds`."""
    covariance: Array = bounds(model, x, inputs, h, measured, std, prior_std, (len(inputs),))[0]
    return covariance


def true_states(
    model: ObserverModel,
    moving: Array,
    current: Sequence[float] | Array = (0.0, 0.0),
    values: Sequence[float] | Array | None = None,
) -> Array:
    """The states of `model` along a motion, (K + 1, size).

    Args:
        model: the observer's.
        moving: u v w p q r phi theta psi, (K + 1, 9).
        current: of steady water, north and east, m/s.
        values: of the parameters; None is as believed.
    """
    x = np.zeros((len(moving), model.size))
    x[:, :MOVING] = moving
    x[:, MOVING : MOVING + model.water] = tuple(current)[: model.water]
    x[:, model.first :] = model.believed if values is None else values
    return x


def _inverse(J: Array, prior_std: Array) -> Array:
    """The inverse of J with the prior's information added; rows of what is known exactly are 0.

    It is scaled to a unit diagonal first: the states have many units. What nothing tells of comes out as 1e300.
    """
    free = np.flatnonzero(prior_std > 0.0)
    total = J[np.ix_(free, free)] + np.diag(1.0 / prior_std[free] ** 2)
    diagonal = np.diag(total)
    scale = np.where(diagonal > 0.0, 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0)), 1.0)
    values, vectors = np.linalg.eigh(total * np.outer(scale, scale))
    told = values > _SINGULAR * values[-1]
    inverse = np.where(told, 1.0 / np.where(told, values, 1.0), 1e300)
    out = np.zeros_like(J)
    out[np.ix_(free, free)] = (vectors * inverse) @ vectors.T * np.outer(scale, scale)
    return out
