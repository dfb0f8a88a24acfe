"""What the coefficient filter says, went through, and remembers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.transition import Picks

Flags = NDArray[np.bool_]


class Estimate(NamedTuple):
    """What the bank believes, its filters blended by their probabilities.

    Attributes:
        values: the learned coefficients, (names,); `std` their 1 sigma.
        std: see values.
        covariance: of the whole state, (n, n).
        mean: the whole state, (n,).
        nu: velocity over ground, m/s and rad/s, (6,).
        angles: phi, theta, psi, rad, (3,).
        current: steady current north and east, m/s, (2,); NaN where none is estimated. `current_std` likewise.
        current_std: see current.
        weights: probability of each filter of the bank.
        turbulence: intensity of the eddies, averaged over the bank, m/s.
    """

    values: Array
    std: Array
    covariance: Array
    mean: Array
    nu: Array
    angles: Array
    current: Array
    current_std: Array
    weights: Array
    turbulence: float


class History(NamedTuple):
    """What a run went through.

    Attributes:
        steps: how many were made; fewer than asked if the filter met a number that is not finite.
        x: blended states, (K / every, n); `std` their 1 sigma.
        std: see x.
        nis: normalised innovations squared, (K, 9); NaN where nothing came.
        weights: probabilities of the filters, (K / every, members).
    """

    steps: int
    x: Array
    std: Array
    nis: Array
    weights: Array


class ReviewMemory(NamedTuple):
    """The tape, the banks at its beginning and on their way, what slopes are drawn about, and how far all is."""

    tape: Array
    start: tuple[Array, Array, Array]
    bank: tuple[Array, Array, Array]
    arrays: tuple[Array, ...]
    span: float
    turn: int
    row: int
    scout: tuple[int, int]
    stage: int
    sound: bool
    age: float
    fruitful: bool
    running: bool
    taken: int


class EkfMemory(NamedTuple):
    """All that a bank remembers: states, covariances, evidence, and how many measurements it left out, its age."""

    x: Array
    P: Array
    evidence: Array
    rejected: Picks
    age: float
    begun: Flags
    window: Array
    since: float
    restarts: int
    review: ReviewMemory
