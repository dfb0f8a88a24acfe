"""One flight of the model from an initial state, and the slopes of all it does by that state: S = Phi S."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from firmware_py.compiled import kernel
from firmware_py.estimation.model.observer_model import MOTIONS, ObserverModel
from firmware_py.estimation.model.prediction import CURRENT, predict
from firmware_py.estimation.model.transition import MOVING, Picks
from firmware_py.run.errors import UsageError
from sternplane.identification.cramer_rao_bound import carry
from sternplane.identification.recording import Recording
from sternplane.logs.tracking import Array

YAW = MOTIONS.index("psi")


class Flown(NamedTuple):
    """The model's flight from one initial state."""

    residuals: Array
    """(K, 9): measured less predicted; NaN where nothing was measured."""
    slopes: Array
    """(K, 9, size): of the predictions by the state at the start."""


def fly(model: ObserverModel, recording: Recording, x: Array) -> Flown | None:
    """The model's flight from the state x (size,) at the start; None if it leaves the numbers.

    Raises:
        UsageError: the model's water has eddies; what they do is process noise, and this flight has none.
    """
    if model.water > CURRENT:
        raise UsageError("a flight without process noise needs still or steady water (0 or 2 states)")
    inputs, S = np.ascontiguousarray(recording.inputs), np.zeros((MOVING, model.size))
    S[:, :MOVING] = np.eye(MOVING)
    predicted, slopes = np.empty((len(inputs), MOVING)), np.empty((len(inputs), MOVING, model.size))
    m, start = model, x.copy()
    vehicle = (m.c, m.inverse, m.picks, m.weight, m.water, m.first, m.heavy)
    if not _shoot(*vehicle, inputs, start, recording.h, m.work, m.y, S, predicted, slopes):
        return None
    for i, place in enumerate(model.biases):
        at = MOVING + model.water + i
        predicted[:, place] += x[at]
        slopes[:, place, at] += 1.0
    residuals = recording.z - predicted
    residuals[:, YAW] = (residuals[:, YAW] + math.pi) % math.tau - math.pi
    return Flown(residuals, slopes) if np.isfinite(slopes[-1]).all() else None


@kernel(
    "b1(f8[::1],f8[:,::1],i8[:,::1],f8[::1],i8,i8,b1,f8[:,::1],f8[::1],f8,f8[:,::1],f8[::1],f8[:,::1],f8[:,::1],"
    "f8[:,:,::1])"
)
def _shoot(
    c: Array,
    inverse: Array,
    picks: Picks,
    weight: Array,
    water: int,
    first: int,
    heavy: bool,
    inputs: Array,
    x: Array,
    h: float,
    work: Array,
    y: Array,
    S: Array,
    predicted: Array,
    slopes: Array,
) -> bool:
    """Fills `predicted`, (K, 9), and `slopes`, (K, 9, size), step by step; False if a step leaves the numbers.

    Args:
        c: as `prediction.predict` has it, as are all up to y; `inputs` are of all the steps, (K, 4).
        inverse: see c.
        picks: see c.
        weight: see c.
        water: see c.
        first: see c.
        heavy: see c.
        inputs: see c.
        x: at the start; at the end where it came to.
        h: see c.
        work: see c.
        y: see c.
        S: slopes at the start, (9, size): the identity's rows.
        predicted: out.
        slopes: out.
    """
    for k in range(len(inputs)):
        if not predict(c, inverse, picks, weight, water, first, heavy, inputs[k], x, h, work, y):
            return False
        carry(work, y, picks, weight, water, first, S if k == 0 else slopes[k - 1], slopes[k])
        for i in range(MOVING):
            predicted[k, i] = x[i]
    return True
