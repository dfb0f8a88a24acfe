"""The measurement history of a flight: what a filter was given, a row a step; compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from firmware_py.compiled import Matrix, Vector, kernel
from firmware_py.estimation.model.state import MOVING


class MeasurementHistory(NamedTuple):
    """Rows of a flight.

    Attributes:
        h: step, s, (rows,); 0 where the filter was started anew in motion.
        inputs: see `kernel_arguments.Given`, (rows, 4).
        z: the nine measurements, or that motion, (rows, 9).
        R: their variances, (rows, 9).
    """

    h: Vector
    inputs: Matrix
    z: Matrix
    R: Matrix


@kernel()
def record(history: MeasurementHistory, row: int, h: float, inputs: Vector, z: Vector, R: Vector) -> None:
    """Fills a row: a step of h (s) under inputs, (4,), that z, (9,), of variance R, (9,), ended."""
    history.h[row] = h
    for i in range(len(inputs)):
        history.inputs[row, i] = inputs[i]
    for i in range(MOVING):
        history.z[row, i], history.R[row, i] = z[i], R[i]


def new_history(rows: int) -> MeasurementHistory:
    """Room for so many rows."""
    return MeasurementHistory(np.zeros(rows), np.zeros((rows, 4)), np.zeros((rows, MOVING)), np.zeros((rows, MOVING)))
