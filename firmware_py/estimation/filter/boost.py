"""What becomes uncertain when the gyros suddenly contradict the filter: most likely fins were damaged."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from firmware_py.compiled import Flags
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.observer_model import X_G, ObserverModel

FINS = ("ds", "dr", "db")
"""The fins of an axis, as coefficients are named after them: stern planes, rudders, bow planes."""
DRAG = 0.25
"""Part of a boost that the drag of fins gets by itself, beside what it shares with all that the same fins make."""
HULL = 0.1
"""The same of what the hull makes, damping: fins have a part in it."""
TRIM = 0.005
"""The same of x_G: a weight that has shifted contradicts the gyros as damage does."""
LIFT = 0.02
"""The same of what a fin's lift makes: force and moment are one lift, and damage leaves it its lever arm."""


def by_fins(name: str) -> bool:
    """Return whether a coefficient's force is made by a fin."""
    return any(fins in name for fins in FINS)


def by_lift(name: str) -> bool:
    """Return whether a coefficient's force is a fin's lift: not drag, which goes with the angle squared."""
    return by_fins(name) and not name.startswith("X")


def boost_covariance(
    model: ObserverModel,
    names: Sequence[str],
    learns: Flags,
    std: float,
    values: Array,
    withheld: Sequence[str] = (),
) -> Array:
    """Return what a boost adds to the covariance of the parameters, (filters, parameters, parameters).

    What damage does to a fin it does to all that the fins of an axis make, so these share one factor of what they are:
    the pitching moment, which is known within seconds, tells of the force too, as the fin's lift has one lever arm
    before and after. Beside it each that is learned, and the fins' drag, may have changed by itself.

    Args:
        model: says which parameters there are, and their believed size.
        names: the learned ones.
        learns: which of all parameters learn, (parameters,).
        std: 1 sigma of the factor.
        values: of the parameters by now, (filters, parameters).
        withheld: what these, of FINS, make stays as it is.
    """
    size = std * np.array(model.sizes)
    also = [by_fins(name) or name == X_G for name in model.names]
    each = zip(model.names, learns, also, strict=True)
    chosen = [
        (name in names or (bool(own) and one)) and not any(fins in name for fins in withheld) for name, own, one in each
    ]
    alone = [_alone(name) for name in model.names]
    covariance = np.repeat(np.diag(np.where(chosen, np.square(np.array(alone) * size), 0.0))[None], len(values), axis=0)
    for fins in FINS:
        of_axis = [one and fins in name for one, name in zip(chosen, model.names, strict=True)]
        shared = np.where(of_axis, std * values, 0.0)
        covariance += shared[:, :, None] * shared[:, None, :]
    return covariance


def _alone(name: str) -> float:
    if name == X_G:
        return TRIM
    return LIFT if by_lift(name) else DRAG if by_fins(name) else HULL
