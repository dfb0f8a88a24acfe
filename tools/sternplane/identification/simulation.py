"""Simulation of the model from an initial state, with the sensitivity of the trajectory to that state: S = Phi S."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from firmware_py.compiled import Cube, Matrix, Vector, kernel
from firmware_py.estimation.model.kernel_arguments import Linearisation, Model
from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.estimation.model.prediction import predict
from firmware_py.estimation.model.state import CURRENT, MOTIONS, MOVING
from firmware_py.run.usage_error import UsageError
from sternplane.identification.cramer_rao_bound import carry
from sternplane.identification.recording import Recording
from sternplane.logs.tracking import Array

YAW = MOTIONS.index("psi")


class Trajectory(NamedTuple):
    """The trajectory of the model from one initial state."""

    residuals: Array
    """(K, 9): measured less predicted; NaN where nothing was measured."""
    slopes: Array
    """(K, 9, size): of the predictions by the state at the start."""


def simulate(model: ObserverModel, recording: Recording, x: Array) -> Trajectory | None:
    """Simulate the model from the state x (size,) at the start; None if it becomes non-finite.

    Raises:
        UsageError: the model's water has eddies; what they do is process noise, and this flight has none.
    """
    if model.water > CURRENT:
        raise UsageError("a flight without process noise needs still or steady water (0 or 2 states)")
    inputs, S = np.ascontiguousarray(recording.inputs), np.zeros((MOVING, model.size))
    S[:, :MOVING] = np.eye(MOVING)
    predicted, slopes = np.empty((len(inputs), MOVING)), np.empty((len(inputs), MOVING, model.size))
    if not _shoot(model.arrays, inputs, recording.h, x.copy(), model.linearisation, S, predicted, slopes):
        return None
    for i, place in enumerate(model.biases):
        at = MOVING + model.water + i
        predicted[:, place] += x[at]
        slopes[:, place, at] += 1.0
    residuals = recording.z - predicted
    residuals[:, YAW] = (residuals[:, YAW] + math.pi) % math.tau - math.pi
    return Trajectory(residuals, slopes) if np.isfinite(slopes[-1]).all() else None


@kernel()
def _shoot(
    model: Model, inputs: Matrix, h: float, x: Vector, step: Linearisation, S: Matrix, predicted: Matrix, slopes: Cube
) -> bool:
    """Fills `predicted`, (K, 9), and `slopes`, (K, 9, size), step by step; False if a step becomes non-finite.

    Args:
        model: see `prediction.predict`, as for step and h (s).
        inputs: of all the steps, (K, 4).
        h: see model.
        x: at the start; at the end where it came to.
        step: see model.
        S: slopes at the start, (9, size): the identity's rows.
        predicted: out.
        slopes: out.
    """
    for k in range(len(inputs)):
        if not predict(model, inputs[k], h, x, step):
            return False
        carry(model, step, S if k == 0 else slopes[k - 1], slopes[k])
        for i in range(MOVING):
            predicted[k, i] = x[i]
    return True
