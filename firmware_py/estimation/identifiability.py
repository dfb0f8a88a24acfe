"""What was not learned: coefficients, and combinations of them, that are as unknown as before, in words for people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firmware_py.estimation.model.jacobians import Array

NOTHING = 0.95
"""A direction whose sigma is more than this part of what it was before has not been learned."""
ALONE = 0.97
"""A coefficient that lies so far within what was not learned was not learned by itself, not only in a combination."""
PART = 0.15
"""With less weight than this a coefficient takes no part in a direction."""


class Direction(NamedTuple):
    """A combination of parameters and how well it is known."""

    sigma: float
    """1 sigma, in the units that the parameters were scaled by."""
    weights: Array
    """Of the scaled parameters, their squares' sum 1."""
    words: str
    """Such as "0.3 Y_dr + 0.9 Y_r + 0.3 Y_v"."""


class Identifiability(NamedTuple):
    """What is as unknown as it was before."""

    alone: tuple[str, ...]
    """Parameters that are so each by itself."""
    mixed: tuple[Direction, ...]
    """Combinations of the others, each over its sigma before."""
    unknown: tuple[str, ...]
    """All of `alone`, and those that take part in `mixed`."""


class Known(NamedTuple):
    """What a filter knows of the coefficients that it learns: (count,) each, but for the covariance (count, count)."""

    names: Sequence[str]
    covariance: Array
    prior_std: Array
    believed: Array
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
    return [_direction(*one, names) for one in _principal(covariance, prior_std) if one[0] > NOTHING]


def identifiability(covariance: Array, names: Sequence[str], prior_std: Sequence[float] | Array) -> Identifiability:
    """What is as unknown as `prior_std`, (n,), had it; `covariance`, (n, n), is finite."""
    lost = [vector for sigma, vector in _principal(covariance, prior_std) if sigma > NOTHING]
    if not lost:
        return Identifiability((), (), ())
    within = np.sqrt(np.square(lost).sum(axis=0)).tolist()
    alone = [name for name, share in zip(names, within, strict=True) if share > ALONE]
    rest = [i for i, name in enumerate(names) if name not in alone]
    left, prior = [names[i] for i in rest], np.asarray(prior_std)[rest]
    mixed = unlearned(covariance[np.ix_(rest, rest)], left, prior) if rest else []
    parts = {name for one in mixed for name, w in zip(left, one.weights.tolist(), strict=True) if abs(w) >= PART}
    return Identifiability(tuple(alone), tuple(mixed), tuple(name for name in names if name in alone or name in parts))


def sentence(known: Known) -> str:
    """What was learned and what was not, such as "learned 8 of 10, 7 valid, 1 sigma up to 12 % (N_r); not identifiable:
    N_v, Y_v (never excited)", or "learned all 10, 1 sigma up to 2 % (Y_r)" where all are excited and valid too.

    Sigma is that of the worst known of what was learned, of its believed size.
    """
    names, count = list(known.names), len(known.names)
    with np.errstate(all="ignore"):  # what is too large for a number is told below
        scaled = known.covariance / np.outer(known.prior_std, known.prior_std)
        sizes = np.sqrt(known.covariance.diagonal()) / np.abs(known.believed)
    if not (np.isfinite(scaled).all() and np.isfinite(sizes).all()):
        return f"learned 0 of {count}: the filter's numbers are not finite"
    weak = identifiability(scaled, names, np.ones(count))
    learned = [i for i, name in enumerate(names) if name not in weak.unknown]
    calm = [names[i] for i in learned if not known.excited[i]]
    valid = sum(bool(known.valid[i]) for i in learned)
    best = valid == count and not calm
    parts = [f"learned all {count}" if best else f"learned {len(learned)} of {count}, {valid} valid"]
    if learned:
        worst = max(learned, key=lambda i: float(sizes[i]))
        parts[0] += f", 1 sigma up to {100.0 * sizes[worst]:.3g} % ({names[worst]})"
    if weak.unknown:
        never = [name for name in weak.alone if not known.ever[names.index(name)]]
        groups = [f"{', '.join(never)} (never excited)"] if never else []
        groups += [name for name in weak.alone if name not in never]
        groups += [one.words for one in weak.mixed]
        parts.append(f"not identifiable: {' and '.join(groups)}")
    if calm:
        parts.append(f"not excited at the end: {', '.join(calm)}")
    return "; ".join(parts)


def _principal(covariance: Array, scales: Sequence[float] | Array) -> list[tuple[float, Array]]:
    """Sigma and unit vector of each principal direction of the scaled covariance, the worst known first."""
    scale = np.abs(np.asarray(scales, dtype=np.float64))
    variances, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    return [*zip(np.sqrt(np.maximum(variances, 0.0)).tolist()[::-1], vectors.T[::-1], strict=True)]


def _direction(sigma: float, vector: Array, names: Sequence[str]) -> Direction:
    """The direction with its words, its greatest weight positive."""
    vector = vector * np.sign(vector[np.argmax(np.abs(vector))])
    return Direction(sigma, vector, _words(vector, names))


def _words(vector: Array, names: Sequence[str]) -> str:
    """The members that count, with their weights to one digit."""
    parts = [(f"{abs(w):.1f} {name}", w < 0.0) for name, w in zip(names, vector, strict=True) if abs(w) >= PART]
    text = "".join(f" {'-' if minus else '+'} {part}" for part, minus in parts)
    return text[3:] if text.startswith(" + ") else text[1:].replace("- ", "-", 1)
