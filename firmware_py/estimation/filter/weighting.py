"""The weights of the filters of the bank, compiled: probabilities by Bayes' rule (Magill 1965), and their mean."""

from __future__ import annotations

import math

from firmware_py.compiled import Vector, kernel
from firmware_py.estimation.filter.kernel_arguments import FilterBank
from firmware_py.estimation.filter.measurement_update import wrapped
from firmware_py.estimation.model.state import PHI, PSI

REPLACED_BELOW = 100.0
"""A filter so far behind the most likely in log-likelihood is replaced by its copy, half as far behind."""


@kernel()
def most_likely(log_likelihood: Vector) -> int:
    """The filter with the greatest log-likelihood."""
    best = 0
    for b in range(1, len(log_likelihood)):
        if log_likelihood[b] > log_likelihood[best]:
            best = b
    return best


@kernel()
def weigh(log_likelihood: Vector, weights: Vector) -> int:
    """Fills the filters' probabilities from their log-likelihoods, both (filters,); returns the most likely."""
    best, total = most_likely(log_likelihood), 0.0
    for b in range(len(log_likelihood)):
        weights[b] = math.exp(log_likelihood[b] - log_likelihood[best])
        total += weights[b]
    for b in range(len(log_likelihood)):
        weights[b] /= total
    return best


@kernel()
def replace_unlikely(bank: FilterBank) -> None:
    """Makes filters that are far behind copies of the most likely one, before they become non-finite."""
    x, P, log_likelihood = bank.x, bank.P, bank.log_likelihood
    best = most_likely(log_likelihood)
    for b in range(len(log_likelihood)):
        if log_likelihood[b] < log_likelihood[best] - REPLACED_BELOW:
            for i in range(x.shape[1]):
                x[b, i] = x[best, i]
            for i in range(P.shape[1]):
                for j in range(P.shape[2]):
                    P[b, i, j] = P[best, i, j]
            log_likelihood[b] = log_likelihood[best] - 0.5 * REPLACED_BELOW


@kernel()
def combine(bank: FilterBank, weights: Vector, mean: Vector, std: Vector) -> None:
    """Mean and 1 sigma of each state over the bank (moments of a mixture).

    Args:
        bank: the filters; an angle is averaged about the first one's.
        weights: out, their probabilities, (filters,).
        mean: out, (n,).
        std: out, (n,).
    """
    x, P = bank.x, bank.P
    weigh(bank.log_likelihood, weights)
    for i in range(len(mean)):
        mean[i], std[i] = 0.0, 0.0
    for i in range(len(mean)):
        origin = x[0, i]
        for b in range(len(x)):
            off = x[b, i] - origin
            if i in (PHI, PSI):
                off = wrapped(off)
            mean[i] += weights[b] * off
            std[i] += weights[b] * (P[b, i, i] + off * off)
        std[i] = math.sqrt(max(std[i] - mean[i] * mean[i], 0.0))
        mean[i] += origin
        if i in (PHI, PSI):
            mean[i] = wrapped(mean[i])
