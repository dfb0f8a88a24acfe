"""The weights of the filters of the bank, compiled: probabilities by Bayes' rule (Magill 1965), and their mean.

Of a sea between two intensities of the bank no filter is right, and Bayes' rule takes the less wrong one for certain.
Where the water moves the hull more than its fins do, a filter that takes eddies for 2/3 of what they are finds
coefficients 3/2 of what they are, and is sure of both. So what the bank believes (`combine`) is shared between the most
likely filter and that beside it, as near as each is to where a parabola through three log-likelihoods peaks.
"""

from __future__ import annotations

import math

from firmware_py.compiled import Vector, kernel
from firmware_py.estimation.filter.kernel_arguments import FilterBank
from firmware_py.estimation.filter.measurement_update import wrapped
from firmware_py.estimation.model.state import PHI, PSI

REPLACED_BELOW = 100.0
"""A filter so far behind the most likely in log-likelihood is replaced by its copy, half as far behind."""
NEIGHBOUR_REPLACED_BELOW = 400.0
"""The same for the two beside the most likely one: in a sea at its intensity these are some 150 to 400 behind, and in
one between two the second of them some 10 to 120."""


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
def share_with_neighbour(intensity: Vector, log_likelihood: Vector, best: int, weights: Vector) -> None:
    """Gives the filter beside the most likely one at least its share of what both weigh, if the sea is between them.

    Args:
        intensity: of the eddies, rising, (filters,), m/s; one below half of the next counts as that half: 0 has no
            logarithm, and with 0.02 beside 0.05 at its own place, which is worth more below, sigma is too small above.
        log_likelihood: (filters,).
        best: the most likely one; the least and the greatest intensity have none beyond them, and share nothing.
        weights: changed, (filters,).
    """
    if not 0 < best < len(weights) - 1:
        return
    below = math.log(max(intensity[best - 1], 0.5 * intensity[best]) / intensity[best])
    above = math.log(intensity[best + 1] / intensity[best])
    slope_below = (log_likelihood[best - 1] - log_likelihood[best]) / below
    slope_above = (log_likelihood[best + 1] - log_likelihood[best]) / above
    bend = (slope_above - slope_below) / (above - below)
    if not bend < 0.0:
        return
    peak = -0.5 * (slope_above - bend * above) / bend
    beside = best + 1 if peak > 0.0 else best - 1
    share = min(peak / (above if peak > 0.0 else below), 1.0)
    both = weights[best] + weights[beside]
    if weights[beside] < share * both:
        weights[best], weights[beside] = (1.0 - share) * both, share * both


@kernel()
def replace_unlikely(bank: FilterBank) -> None:
    """Makes filters that are far behind copies of the most likely one, before they become non-finite."""
    x, P, log_likelihood = bank.x, bank.P, bank.log_likelihood
    best = most_likely(log_likelihood)
    for b in range(len(log_likelihood)):
        limit = NEIGHBOUR_REPLACED_BELOW if abs(b - best) == 1 else REPLACED_BELOW
        if log_likelihood[b] < log_likelihood[best] - limit:
            for i in range(x.shape[1]):
                x[b, i] = x[best, i]
            for i in range(P.shape[1]):
                for j in range(P.shape[2]):
                    P[b, i, j] = P[best, i, j]
            log_likelihood[b] = log_likelihood[best] - 0.5 * limit


@kernel()
def combine(bank: FilterBank, weights: Vector, mean: Vector, std: Vector) -> None:
    """Mean and 1 sigma of each state over the bank (moments of a mixture).

    Args:
        bank: the filters; an angle is averaged about the first one's.
        weights: out, (filters,): their probabilities, and the share of `share_with_neighbour`.
        mean: out, (n,).
        std: out, (n,).
    """
    x, P = bank.x, bank.P
    share_with_neighbour(bank.intensity, bank.log_likelihood, weigh(bank.log_likelihood, weights), weights)
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
