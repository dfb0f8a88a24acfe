"""What the coefficient filter begins with of an earlier flight: checked, and less certain than it was.

Between two flights a vehicle is trimmed, its fins are mounted anew, it is fouled and cleaned. So to each variance a
share of that before any flight is added: what was learned has to be learned anew before a law may rely on it, but is so
near that no start-up is needed.
"""

from __future__ import annotations

import numpy as np

from firmware_py.error_text import quoted
from firmware_py.estimation.filter.bank_arrays import BankArrays
from firmware_py.estimation.model.equations import COEFFICIENTS
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.observer_model import SCALED, X_G
from firmware_py.params import ParamError
from firmware_py.records.passport import LearnedModel, Restored

STD_LEAST = 1e-4
"""Of the 1 sigma before any flight: no flight tells more; an hour of learning leaves a hundredth."""
_EIGENVALUE_LEAST = 1e-10
"""Of the correlation matrix."""
_NAMES = frozenset((*COEFFICIENTS, *SCALED, X_G))
"""Whatever any filter can learn."""
_LEVERS = (("M_ds", "Z_ds"), ("N_dr", "Y_dr"))
"""Moment and force of a fin's lift: the one over the other is its lever arm, in lengths of the vehicle."""


def learned_model(filters: BankArrays, mean: Array, covariance: Array, valid: tuple[bool, ...]) -> LearnedModel:
    """Return what may be kept of a filter.

    Args:
        filters: a bank.
        mean: its whole state, (n,), averaged over the bank.
        covariance: of this state, (n, n): of the mixture, so with what the filters of the bank differ by.
        valid: of the coefficients, (names,).
    """
    model, first, count = filters.model, filters.model.first, filters.learning
    P = covariance[first : first + count, first : first + count]
    P = 0.5 * (P + P.T)
    return LearnedModel(
        model.names[:count],
        tuple(model.believed[:count]),
        tuple(mean[first : first + count].tolist()),
        (*valid, *[False] * (count - len(valid))),
        tuple([tuple(row[: i + 1]) for i, row in enumerate(P.tolist())]),
    )


def prior(restored: Restored, filters: BankArrays) -> tuple[tuple[str, ...], Array, Array]:
    """Return what a filter begins with: names, values (k,), and their covariance (k, k).

    `restored.widening` is the 1 sigma that is added, as a share of that before any flight; no coefficient becomes less
    certain than that.

    Raises:
        ParamError: no such filter can have learned it: an unknown name, a value out of bounds or that a law could rely
            on though its sign is not that of the vehicle file, or a covariance that is none.
    """
    model, known = restored.model, filters.model.names[: filters.learning]
    for name in model.names:
        if name not in _NAMES:
            raise ParamError(f"coefficients: {quoted(name)} is no coefficient")
    chosen = [i for i, name in enumerate(model.names) if name in known]
    names = tuple([model.names[i] for i in chosen])
    if not names:
        raise ParamError("has no coefficient that this filter learns")
    places = [filters.model.place(name) for name in names]
    value, P, before = np.array(model.value), _square(model.covariance), filters.prior[places]
    value, P = value[chosen], P[np.ix_(chosen, chosen)]
    std = np.sqrt(P.diagonal())
    low, high = filters.tuning.lower[places], filters.tuning.upper[places]
    file = [filters.model.believed[place - filters.model.first] for place in places]
    valid = [model.valid[i] for i in chosen]
    each = zip(names, value, low, high, std, before, file, valid, strict=True)
    for name, x, lowest, highest, sigma, widest, believed, relied_on in each:
        if not lowest <= x <= highest:
            raise ParamError(f"{name} = {x:g}: must be in [{lowest:g}, {highest:g}]")
        if relied_on and name != X_G and not x * believed > 0.0:  # no fin turns a hull the other way round, no drag
            raise ParamError(f"{name} = {x:g}: must have the sign of the vehicle file, {believed:g}")
        if not sigma >= STD_LEAST * widest:
            raise ParamError(f"{name}: a 1 sigma of {sigma:g} is less than any flight can leave")
    sizes = {name: abs(x) for name, x, ok in zip(names, value, valid, strict=True) if ok}
    for moment, force in _LEVERS:
        if sizes.get(moment, 0.0) > sizes.get(force, np.inf):
            raise ParamError(f"{moment} and {force}: no fin is farther from the vehicle's middle than its length")
    correlation = P / np.outer(std, std)
    if not np.linalg.eigvalsh(correlation)[0] > _EIGENVALUE_LEAST:
        raise ParamError("covariance: is not positive definite")
    P = P + np.diag(np.square(restored.widening * before))
    shrink = np.minimum(1.0, before / np.sqrt(P.diagonal()))
    return names, value, P * np.outer(shrink, shrink)


def _square(rows: tuple[tuple[float, ...], ...]) -> Array:
    """Return the symmetric matrix of a lower triangle."""
    P = np.zeros((len(rows), len(rows)))
    for i, row in enumerate(rows):
        P[i, : i + 1] = P[: i + 1, i] = row
    return P
