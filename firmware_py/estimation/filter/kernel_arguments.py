"""What the kernels of the filter take: the bank with its model, its tuning and its scratch, and what it is given."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from firmware_py.compiled import Cube, Indices, Matrix, Vector
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.kernel_arguments import Linearisation, Model
from firmware_py.estimation.model.state import EQUATIONS, MOVING, WATER, WATER_AXIS

VECTOR = 8
"""Numbers that the processor takes at once, a line of its cache."""
BATCH = 3
"""Measurements that share one pass over the covariance."""
CHANNELS = EQUATIONS + 3
"""Through what all other states act on the motion: a force in each equation, and the water's velocity on each axis."""
CHANNEL_OF_WATER = tuple(EQUATIONS + axis for axis in WATER_AXIS)
"""The channel of each state of the water."""


def padded(n: int) -> int:
    """The least whole number of vectors that holds n states and the columns of Phi."""
    return -(-max(n, WATER + 3) // VECTOR) * VECTOR


def zeros(*shape: int) -> Array:
    """Zeros that begin with a line of the cache; rows of a padded length all do, and are read a third faster."""
    size = math.prod(shape)
    room = np.zeros(size + VECTOR)
    begin = -room.ctypes.data // room.itemsize % VECTOR
    return room[begin : begin + size].reshape(shape)


class Settings(NamedTuple):
    """What does not change in flight.

    Attributes:
        eddy_time: correlation time of the eddies, s.
        likelihood_memory: time over which log-likelihoods fade, s.
        gate: an innovation of more sigmas than this is rejected.
        learning_delay: for so long after the start, s, parameters do not learn.
        startup_time: time constant with which the start-up noise fades, s.
    """

    eddy_time: float
    likelihood_memory: float
    gate: float
    learning_delay: float
    startup_time: float


class Tuning(NamedTuple):
    """Process noise, learning and bounds of each state, (padded,) each. `schedule` sets the first three at each step.

    Attributes:
        Q: process noise, variance by the second.
        Q_eddy: more of it, by the intensity of the eddies times the water's unknown velocity (m/s)^2.
        learns: 1 for states that follow measurements, 0 for those that are only considered (Schmidt 1966).
        Q_final: what Q is once the start-up is over.
        Q_startup: what it is more at the start.
        Q_eddy_startup: Q_eddy at the start.
        may_learn: 1 for states that may learn once the learning delay is over.
        lower: least value of each state.
        upper: greatest value.
    """

    Q: Vector
    Q_eddy: Vector
    learns: Vector
    Q_final: Vector
    Q_startup: Vector
    Q_eddy_startup: Vector
    may_learn: Vector
    lower: Vector
    upper: Vector


class UpdateRows(NamedTuple):
    """A batch of scalar updates that the covariance has not seen yet, (BATCH, padded) each; 0 where there is none.

    Attributes:
        PHt: P H' / sqrt(S) of each.
        K: K sqrt(S) of each: the same, but 0 for states that do not learn.
    """

    PHt: Matrix
    K: Matrix


class Scratch(NamedTuple):
    """Room for one step of one filter.

    Attributes:
        FP: the motion's rows of F* P, (9, padded).
        channels: covariance of each channel with each state, (CHANNELS, padded).
        rows: see there.
    """

    FP: Matrix
    channels: Matrix
    rows: UpdateRows


class FilterBank(NamedTuple):
    """Filters of one vehicle that differ in the intensity of the eddies they assume, and what they share.

    Attributes:
        model: the vehicle.
        step: the last step, linearised.
        tuning: see there.
        settings: see there.
        bias_state: place in the state of the bias of each of the nine sensors, (9,); negative for none.
        intensity: of the eddies, m/s, (filters,).
        x: states, (filters, padded).
        P: covariances, (filters, n, padded).
        log_likelihood: of each filter, fading, (filters,).
        weights: probability of each filter before the measurements of the last step, (filters,).
        scratch: see there.
    """

    model: Model
    step: Linearisation
    tuning: Tuning
    settings: Settings
    bias_state: Indices
    intensity: Vector
    x: Matrix
    P: Cube
    log_likelihood: Vector
    weights: Vector
    scratch: Scratch


class Monitor(NamedTuple):
    """What is kept of a run beside the bank.

    Attributes:
        age: how far the start-up is, s, (1,); see `start_up.schedule`.
        window: exponential windows over the NIS, (3, 3); see `consistency.add_nis`.
        rejected: how many measurements the most likely filter rejected, (9,).
        burst: of the gyros, (3,); see `consistency.add_burst`.
    """

    age: Vector
    window: Matrix
    rejected: Indices
    burst: Vector


class Given(NamedTuple):
    """Rows of what a bank is given, one a step; `nis` is filled.

    Attributes:
        h: step, s.
        inputs: delta_s, delta_r, delta_b (rad), n (rev/s): means over each step, (K, 4).
        z: u v w p q r phi theta psi at its end, (K, 9); NaN where nothing came.
        R: variance of each of the nine, (9,).
        nis: out: normalised innovations squared, averaged over the bank, (K, 9); NaN where nothing came.
    """

    h: float
    inputs: Matrix
    z: Matrix
    R: Vector
    nis: Matrix


class Output(NamedTuple):
    """What a run leaves, a row for every `every` steps.

    Attributes:
        every: see above.
        mean: of the whole state, (K / every, n).
        std: its 1 sigma.
        weights: of the filters as they were combined, (K / every, filters).
    """

    every: int
    mean: Matrix
    std: Matrix
    weights: Matrix


def new_scratch(width: int) -> Scratch:
    """Room for states of that (padded) width."""
    rows = UpdateRows(zeros(BATCH, width), zeros(BATCH, width))
    return Scratch(zeros(MOVING, width), zeros(CHANNELS, width), rows)
