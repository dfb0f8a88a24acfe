"""The values of each sample of a sweep: a Latin hypercube, or a grid."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from sternplane.sweep.axes import Axis

_STREAM = b"sweep"


def latin_hypercube(n: int, axes: Sequence[Axis], seed: int) -> Iterator[tuple[Any, ...]]:
    """Yield n samples: of the n equal parts of each axis's range each has one sample (McKay et al. 1979).

    Args:
        n: how many.
        axes: what is varied.
        seed: of the order of the parts, axis by axis, and of the place in each.
    """
    generator = np.random.default_rng([seed, *_STREAM])
    shares = [(generator.permutation(n) + generator.random(n)) / n for _ in axes]
    for k in range(n):
        yield tuple([axis.at(float(share[k])) for axis, share in zip(axes, shares, strict=True)])


def grid(n: int, axes: Sequence[Axis]) -> Iterator[tuple[Any, ...]]:
    """Yield every combination of n values of each range, and of all values of each list; the last axis runs first."""
    yield from itertools.product(*(axis.grid(n) for axis in axes))
