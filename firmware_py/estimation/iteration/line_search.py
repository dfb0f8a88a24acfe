"""How far an iteration goes along each of its steps, and when it has come to the end.

A pass is a Gauss-Newton step: from the values about which it took its slopes to those that the flight tells by them.
Where slopes change on the way, the flight may be less likely at the end of a step than at its beginning. The reference
filter knows the values, so its log-likelihood says without any slope what they explain. A step to values that explain
the same rows worse is halved, until they explain more (backtracking line search).

A step is small if it is so in every direction. Sigmas of each value alone do not show this: values that are known far
better together than one by one may all have moved by 4 sigma at most, and be 100 sigma away.
"""

from __future__ import annotations

import numpy as np

from firmware_py.estimation.coefficient_records import Begun
from firmware_py.estimation.iteration.acceptance import EVIDENCE_LOST
from firmware_py.estimation.model.jacobians import Array

CONVERGED = 4.0
"""A pass has converged if no coefficient has moved by so many sigmas, nor all parameters together by as much on average
over all directions; else the history is gone through once more. By what was recorded meanwhile alone, one of ten moves
by 2 or 3. All together, mean square: passes of a hull that holds its course 0 to 4, of one that does not up to 700."""
HALVINGS = 6
"""So often a step is halved; what is left of it, 1/64, is gone."""
VARIANCE_LEAST = 1e-9
"""Of a direction, if each parameter has a variance of 1: less is what rounding leaves."""
ENDLESS = 1 << 40
"""So many steps, or rows, are never made."""


class LineSearch:
    """Compares what each pass of an iteration begins with to what the pass before it began with.

    Attributes:
        explained: log-likelihood of the reference in the pass under way, (1,); the pass adds to it.
        before: the pass before it, of the same stage; None if there is none.
        halvings: how often the step between the two was halved.
    """

    def __init__(self) -> None:
        self.explained = np.zeros(1)
        self.before: Begun | None = None
        self.halvings = 0

    def begin(self) -> None:
        """No pass was made yet."""
        self.before, self.halvings = None, 0

    def step(self, mean: Array, rows: int, most_likely: int) -> None:
        """A pass is over, and another one begins where it ended; see `Begun`."""
        self.before, self.halvings = Begun(mean.copy(), rows, float(self.explained[0]), most_likely), 0

    def ahead(self, row: int) -> int:
        """Return how many rows after that one this pass can be compared with the one before it."""
        return self.before.rows - row if self.before and row < self.before.rows else ENDLESS

    def worse(self, row: int) -> bool:
        """Return whether what this pass began with explains the flight up to that row, where they compare, worse."""
        before = self.before
        if before is None or row != before.rows:
            return False
        return bool(self.explained[0] < before.explained - EVIDENCE_LOST)

    @property
    def may_halve(self) -> bool:
        """Whether there is a step to be halved, and something left of it."""
        return self.before is not None and self.halvings < HALVINGS

    def halve(self, mean: Array) -> tuple[Array, int]:
        """Return what to begin with instead of `mean`, (n,), and in the eddies of which filter."""
        assert self.before is not None
        self.halvings += 1
        return 0.5 * (mean + self.before.mean), self.before.most_likely


def small(moved: Array, std: Array, covariance: Array) -> bool:
    """Return whether a pass ended about where it began.

    Args:
        moved: how far the parameters moved, coefficients first, (k,).
        std: 1 sigma of the coefficients, (names,).
        covariance: of the parameters, (k, k).
    """
    each = np.abs(moved[: len(std)]) <= CONVERGED * std
    return bool(each.all()) and mean_square(moved, covariance) <= CONVERGED**2


def mean_square(moved: Array, covariance: Array) -> float:
    """Return the square of how far something has moved, in sigmas, averaged over all directions.

    Args:
        moved: (k,).
        covariance: (k, k); what has no variance is left out.
    """
    sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    moves = sigma > 0.0
    scale = sigma[moves]
    variances, directions = np.linalg.eigh(covariance[np.ix_(moves, moves)] / np.outer(scale, scale))
    along = directions.T @ (moved[moves] / scale)
    return float(np.sum(along**2 / np.maximum(variances, VARIANCE_LEAST))) / max(len(scale), 1)
