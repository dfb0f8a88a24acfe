"""What explains failures and errors: how outcomes go with each varied key, and what chance alone would show.

Flights of one sample share their values: they are taken together, so that n independent samples stand behind each
figure, however many laws and seeds flew them.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np

from sternplane.logs.tracking import Array
from sternplane.sweep.worst import Row

CHANCE = 0.05
"""How probable it may be that chance alone shows anything in the whole table."""
FEWEST = 8
"""Samples below which nothing is said."""


class Association(NamedTuple):
    """How an outcome goes with a key.

    Attributes:
        key: what was varied.
        rho: Spearman's rank correlation with the outcome, -1 to 1; NaN where either does not vary.
        bound: what |rho| stays below by chance in 95 % of all sweeps, of all keys and outcomes together.
        n: samples with such a key.
    """

    key: str
    rho: float
    bound: float
    n: int

    @property
    def beyond_chance(self) -> bool:
        """Return whether it is more than chance would show."""
        return abs(self.rho) > self.bound


def associations(
    rows: Sequence[Row], keys: Sequence[str], outcome: Mapping[int, float], outcomes: int = 1
) -> list[Association]:
    """Return how an outcome goes with each key, the strongest first.

    Args:
        rows: flights.
        keys: those with numbers.
        outcome: of each flight by its number; one that is left out counts for nothing.
        outcomes: how many are shown in one table, this one among them.
    """
    found = []
    for key in keys:  # a law may not have it
        values, means = samples_of([row for row in rows if row[key] is not None], key, outcome)
        n = len(means)
        found.append(Association(key, spearman(values, means), chance_bound(n, outcomes * len(keys)), n))
    return sorted(found, key=lambda one: -abs(one.rho) if math.isfinite(one.rho) else 1.0)


def samples_of(rows: Sequence[Row], key: str, outcome: Mapping[int, float]) -> tuple[Array, Array]:
    """Return (n,) the value of each sample, and (n,) the mean outcome of its flights."""
    found: dict[int, tuple[float, list[float]]] = {}
    for row in rows:
        if row["flight"] in outcome:
            _, those = found.setdefault(row["sample"], (float(row[key]), []))
            those.append(outcome[row["flight"]])
    values = np.array([value for value, _ in found.values()])
    return values, np.array([float(np.mean(those)) for _, those in found.values()])


def spearman(a: Array, b: Array) -> float:
    """Return the correlation of ranks, equal values sharing theirs (Spearman 1904); NaN where one does not vary."""
    if len(a) < FEWEST:
        return math.nan
    x, y = ranks(a) - 0.5 * (len(a) - 1), ranks(b) - 0.5 * (len(b) - 1)
    size = math.sqrt(float(x @ x) * float(y @ y))
    return float(x @ y) / size if size > 0.0 else math.nan


def ranks(values: Array) -> Array:
    """Return the rank of each value from 0 on; equal ones have the mean of theirs."""
    _, inverse, counts = np.unique(values, return_inverse=True, return_counts=True)
    first = np.cumsum(counts) - counts
    found: Array = (first + 0.5 * (counts - 1))[inverse]
    return found


def chance_bound(n: int, count: int) -> float:
    """Return what `count` values of |rho| all stay below by chance with probability 1 - `CHANCE`.

    For n independent samples rho scatters by 1 / sqrt(n - 1); the probabilities of all are added (Bonferroni).
    """
    if n < FEWEST or not count:
        return math.inf
    return min(NormalDist().inv_cdf(1.0 - 0.5 * CHANCE / count) / math.sqrt(n - 1.0), 1.0)


def design_effect(rows: Sequence[Row]) -> float:
    """Return how many flights tell no more of the share that is completed than one of a sample of its own (Kish 1965).

    It is the variance of the share, by how the samples differ, over that of as many independent flights: 1 where each
    flight is a sample, up to all flights of a sample. Where all or none were completed nothing shows how alike those of
    a sample are: they count as one. A single sample is not held against others: its share is that of its seeds.
    """
    flights = Counter(row["sample"] for row in rows)
    done = Counter(row["sample"] for row in rows if row["completed"])
    n, k, samples = len(rows), done.total(), len(flights)
    if samples in (1, n):
        return 1.0
    most = sum(m * m for m in flights.values()) / n
    if k in (0, n):
        return most
    p = k / n
    squares = sum((done[sample] - p * m) ** 2 for sample, m in flights.items())
    effect = samples / (samples - 1.0) * (n - 1.0) / n * squares / (n * p * (1.0 - p))
    return min(max(effect, 1.0), most)


def success_interval(k: int, n: int, effect: float = 1.0) -> tuple[float, float]:
    """Return the 95 % interval of a probability of which k of n were seen (Wilson 1927).

    `effect`: how many of the n count as one, see `design_effect`.
    """
    if n == 0:
        return 0.0, 1.0
    z, p = NormalDist().inv_cdf(0.975), k / n
    size = n / effect
    middle, wide = p + 0.5 * z * z / size, z * math.sqrt(p * (1.0 - p) / size + 0.25 * (z / size) ** 2)
    return max((middle - wide) / (1.0 + z * z / size), 0.0), min((middle + wide) / (1.0 + z * z / size), 1.0)


class Part(NamedTuple):
    """Flights whose values of a key are near each other, or equal.

    Attributes:
        at: where they are.
        n: how many.
        completed: how many succeeded.
        effect: see `design_effect`.
    """

    at: Any
    n: int
    completed: int
    effect: float


def parts(rows: Sequence[Row], key: str, most: int = 8) -> list[Part]:
    """Return flights by their value of a key: every value where there are few, else equal numbers of flights."""
    listed = [row[key] if not isinstance(row[key], list) else str(row[key]) for row in rows]
    if len(set(listed)) <= most or not all(isinstance(value, int | float) for value in listed):
        groups = [
            (value, [row for row, own in zip(rows, listed, strict=True) if own == value]) for value in _order(listed)
        ]
    else:
        ordered = sorted(rows, key=lambda row: row[key])
        pieces = [ordered[i * len(rows) // most : (i + 1) * len(rows) // most] for i in range(most)]
        groups = [(float(np.mean([row[key] for row in piece])), piece) for piece in pieces if piece]
    return [
        Part(at, len(those), sum(bool(row["completed"]) for row in those), design_effect(those)) for at, those in groups
    ]


def _order(values: Sequence[Any]) -> list[Any]:
    unique = list(dict.fromkeys(values))
    return sorted(unique) if all(isinstance(value, int | float) for value in unique) else unique
