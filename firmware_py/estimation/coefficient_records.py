"""Records of the coefficient filter: its estimate, the history of a run, and what it remembers."""

from __future__ import annotations

from typing import NamedTuple

from firmware_py.compiled import Flags, Indices
from firmware_py.estimation.model.jacobians import Array


class Estimate(NamedTuple):
    """The estimate of the bank, its filters combined by their weights.

    Attributes:
        values: the learned coefficients, (names,); `std` their 1 sigma.
        std: see values.
        covariance: of the whole state, (n, n).
        mean: the whole state, (n,).
        nu: velocity over ground, m/s and rad/s, (6,).
        angles: phi, theta, psi, rad, (3,).
        current: steady current north and east, m/s, (2,); NaN where none is estimated. `current_std` likewise.
        current_std: see current.
        weights: of each filter of the bank; the sum is 1.
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
        x: combined states, (K / every, n); `std` their 1 sigma.
        std: see x.
        nis: normalised innovations squared, (K, 9); NaN where nothing came.
        weights: of the filters, (K / every, filters).
    """

    steps: int
    x: Array
    std: Array
    nis: Array
    weights: Array


class Begun(NamedTuple):
    """A pass that came to the end of the history: what it began with, and how well that explained it.

    Attributes:
        mean: state whose parameters its reference knew, (n,).
        rows: of the history that there were.
        explained: log-likelihood of the reference over them.
        most_likely: the filter that was so at its end, in whose eddies the next one begins.
    """

    mean: Array
    rows: int
    explained: float
    most_likely: int


class IterationMemory(NamedTuple):
    """The measurement history, the banks at its beginning and on their way, the reference, and how far all is."""

    history: tuple[Array, ...]
    start: tuple[Array, Array, Array]
    bank: tuple[Array, Array, Array]
    arrays: tuple[Array, ...]
    span: float
    turn: int
    row: int
    stage: int
    accepted_last: bool
    age: float
    learned: bool
    running: bool
    accepted: int
    rejected: int
    lost: float
    step: tuple[Begun | None, int]


class EkfMemory(NamedTuple):
    """All that a bank remembers: states, covariances, log-likelihoods, rejected measurements, start-up, resets."""

    x: Array
    P: Array
    log_likelihood: Array
    rejected: Indices
    age: float
    begun: Flags
    window: Array
    burst: Array
    since_reset: float
    resets: int
    bursts: int
    iteration: IterationMemory
    iterated: Flags
    shaken: Flags
