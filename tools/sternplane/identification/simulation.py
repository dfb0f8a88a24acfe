"""Simulation of the model from an initial state, with the sensitivity of the trajectory to that state: S = Phi S."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.estimation.model.state import CURRENT, MOTIONS, MOVING
from firmware_py.run.usage_error import UsageError
from sternplane.identification.recording import Recording
from sternplane.identification.sensitivity import shoot
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
    if not shoot(model.arrays, inputs, recording.h, x.copy(), model.linearisation, S, predicted, slopes):
        return None
    for i, place in enumerate(model.biases):
        at = MOVING + model.water + i
        predicted[:, place] += x[at]
        slopes[:, place, at] += 1.0
    residuals = recording.z - predicted
    residuals[:, YAW] = (residuals[:, YAW] + math.pi) % math.tau - math.pi
    return Trajectory(residuals, slopes) if np.isfinite(slopes[-1]).all() else None
