"""What becomes uncertain when the gyros suddenly contradict the filter: most likely fins were damaged."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from firmware_py.compiled import Flags
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.observer_model import ObserverModel

FINS = ("ds", "dr", "db")
"""The fins of an axis, as coefficients are named after them: stern planes, rudders, bow planes."""
SINGLE = 0.25
"""Part of a boost that a coefficient gets by itself, beside what it shares with all that the same fins make."""


def by_fins(name: str) -> bool:
    """Return whether a coefficient's force is made by a fin."""
    return any(fins in name for fins in FINS)


def boost_covariance(model: ObserverModel, names: Sequence[str], learns: Flags, std: float) -> Array:
    """Return what a boost adds to the covariance of the parameters, (parameters, parameters).

    What damage does to a fin it does to all that the fins of an axis make, so these share one factor: the pitching
    moment, which is known within seconds, tells of the force too. Beside it each of them, and each that is learned, may
    have changed by itself.

    Args:
        model: says which parameters there are, and their believed size.
        names: the learned ones.
        learns: which of all parameters learn, (parameters,).
        std: 1 sigma of the factor.
    """
    size = std * np.array(model.believed)
    chosen = [name in names or (bool(own) and by_fins(name)) for name, own in zip(model.names, learns, strict=True)]
    covariance = np.diag(np.where(chosen, np.square(SINGLE * size), 0.0))
    for fins in FINS:
        of_axis = [one and fins in name for one, name in zip(chosen, model.names, strict=True)]
        shared = np.where(of_axis, size, 0.0)
        covariance += np.outer(shared, shared)
    return covariance
