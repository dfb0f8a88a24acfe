"""What was not learned: coefficients, and combinations of them, that are as unknown as before."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firmware_py.estimation.model.jacobians import Array
from firmware_py.records.event import Cause, Event, EventKind, event
from firmware_py.records.learning_text import combination

NOT_LEARNED = 0.95
"""A direction whose sigma is more than this part of what it was before has not been learned."""
BY_ITSELF = 0.97
"""A coefficient that lies so far within what was not learned was not learned by itself, not only in a combination."""
WEIGHT_MIN = 0.15
"""With less weight than this a coefficient takes no part in a direction."""


class Direction(NamedTuple):
    """A combination of parameters and how well it is known."""

    sigma: float
    """1 sigma, in the units that the parameters were scaled by."""
    weights: Array
    """Of the scaled parameters, their squares' sum 1."""
    shares: tuple[float, ...]
    """The weights of at least `WEIGHT_MIN`, and whose they are."""
    names: tuple[str, ...]

    @property
    def words(self) -> str:
        """Such as "0.3 Y_dr + 0.9 Y_r + 0.3 Y_v"."""
        return combination(self.shares, self.names)


class Identifiability(NamedTuple):
    """What is as unknown as it was before."""

    alone: tuple[str, ...]
    """Parameters that are so each by itself."""
    mixed: tuple[Direction, ...]
    """Combinations of the others, each over its sigma before."""
    unknown: tuple[str, ...]
    """All of `alone`, and those that take part in `mixed`."""


class LearnedState(NamedTuple):
    """What a filter knows of the coefficients that it learns: (count,) each, but for the covariance (count, count)."""

    names: Sequence[str]
    covariance: Array
    prior_std: Array
    sizes: Array
    """What each is measured in where it is uncertain: its believed size, of x_G the vehicle's length."""
    valid: NDArray[np.bool_]
    excited: NDArray[np.bool_]
    ever: NDArray[np.bool_]
    """Which were excited at any time since the filter began."""


def directions(covariance: Array, names: Sequence[str], scales: Sequence[float] | Array) -> list[Direction]:
    """The principal directions of a covariance (n, n) of parameters, the worst known first.

    Args:
        covariance: of the parameters alone, (n, n), finite.
        names: of the parameters.
        scales: what each is measured in: its believed size for shares of it, its prior sigma for what was learned.
    """
    return [_direction(sigma, vector, names) for sigma, vector in _principal(covariance, scales)]


def unlearned(covariance: Array, names: Sequence[str], prior_std: Sequence[float] | Array) -> list[Direction]:
    """The directions that a flight tells nothing of: their sigma has hardly come below the prior's."""
    return [_direction(*one, names) for one in _principal(covariance, prior_std) if one[0] > NOT_LEARNED]


def identifiability(covariance: Array, names: Sequence[str], prior_std: Sequence[float] | Array) -> Identifiability:
    """What is as unknown as `prior_std`, (n,), had it; `covariance`, (n, n), is finite."""
    lost = [vector for sigma, vector in _principal(covariance, prior_std) if sigma > NOT_LEARNED]
    if not lost:
        return Identifiability((), (), ())
    within = np.sqrt(np.square(lost).sum(axis=0)).tolist()
    alone = [name for name, share in zip(names, within, strict=True) if share > BY_ITSELF]
    rest = [i for i, name in enumerate(names) if name not in alone]
    left, prior = [names[i] for i in rest], np.asarray(prior_std)[rest]
    mixed = unlearned(covariance[np.ix_(rest, rest)], left, prior) if rest else []
    parts = {name for one in mixed for name, w in zip(left, one.weights.tolist(), strict=True) if abs(w) >= WEIGHT_MIN}
    return Identifiability(tuple(alone), tuple(mixed), tuple(name for name in names if name in alone or name in parts))


def report(known: LearnedState) -> tuple[Event, ...]:
    """Return what was learned and what was not, as events of a learning report; `event_text` has the sentence.

    All is learned where every coefficient is identifiable, valid and excited. Sigma is that of the worst known of what
    was learned, of its size.
    """
    names, count = list(known.names), len(known.names)
    with np.errstate(all="ignore"):  # what is too large for a number is told below
        scaled = known.covariance / np.outer(known.prior_std, known.prior_std)
        sizes = np.sqrt(known.covariance.diagonal()) / known.sizes
    if not (np.isfinite(scaled).all() and np.isfinite(sizes).all()):
        return (reported(Cause.NOT_FINITE, (float(count),)),)
    try:
        weak = identifiability(scaled, names, np.ones(count))
    except np.linalg.LinAlgError:  # finite, but as good as not: 1e195 beside 1
        return (reported(Cause.NOT_FINITE, (float(count),)),)
    learned = [i for i, name in enumerate(names) if name not in weak.unknown]
    calm = [names[i] for i in learned if not known.excited[i]]
    valid = sum(bool(known.valid[i]) for i in learned)
    worst = [max(learned, key=lambda i: float(sizes[i]))] if learned else []
    sigma, whose = tuple(float(sizes[i]) for i in worst), [names[i] for i in worst]
    if valid == count and not calm:
        parts = [reported(Cause.LEARNED_ALL, (float(count), *sigma), whose)]
    else:
        parts = [reported(Cause.LEARNED, (float(len(learned)), float(count), float(valid), *sigma), whose)]
    never = [name for name in weak.alone if not known.ever[names.index(name)]]
    alone = [name for name in weak.alone if name not in never]
    if never:
        parts.append(reported(Cause.NEVER_EXCITED, (), never))
    if alone:
        parts.append(reported(Cause.NOT_IDENTIFIABLE, (), alone))
    parts += [reported(Cause.COMBINATION, one.shares, one.names) for one in weak.mixed]
    if calm:
        parts.append(reported(Cause.NOT_EXCITED_AT_END, (), calm))
    return tuple(parts)


def reported(cause: Cause, numbers: tuple[float, ...] = (), names: Sequence[str] = ()) -> Event:
    """Return one part of a learning report."""
    return event(EventKind.LEARNING_REPORT, cause, numbers, tuple(names))


def _principal(covariance: Array, scales: Sequence[float] | Array) -> list[tuple[float, Array]]:
    """Sigma and unit vector of each principal direction of the scaled covariance, the worst known first."""
    scale = np.abs(np.asarray(scales, dtype=np.float64))
    variances, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    return [*zip(np.sqrt(np.maximum(variances, 0.0)).tolist()[::-1], vectors.T[::-1], strict=True)]


def _direction(sigma: float, vector: Array, names: Sequence[str]) -> Direction:
    """Return the direction with the parameters that count in it, its greatest weight positive."""
    vector = vector * np.sign(vector[np.argmax(np.abs(vector))])
    parts = [i for i, weight in enumerate(vector.tolist()) if abs(weight) >= WEIGHT_MIN]
    return Direction(sigma, vector, tuple(vector[parts].tolist()), tuple(names[i] for i in parts))
