"""Chance: how far a figure over n seeds may scatter although the filter is right.

Every band is as wide as `K_SIGMA` standard deviations of a normal figure, two-sided: a right filter misses a row with
probability `MISS` = erfc(K_SIGMA / sqrt 2) = 6.8e-6. The study has some 130 such rows, so that a right filter
fails it by chance in less than one of a thousand runs. The RMS of n errors over their bound scatters by 1 / sqrt(2 n);
its band is that of chi-square, which for few seeds is not symmetric.
"""

from __future__ import annotations

import math
from statistics import NormalDist

K_SIGMA = 4.5
MISS = math.erfc(K_SIGMA / math.sqrt(2.0))
"""Probability that chance alone takes a figure out of its band, both sides together."""
_EXACT = 200.0
"""Degrees of freedom up to which the quantile is exact; above it Wilson and Hilferty's is right to 0.1 %."""


def chi_square_band(freedom: float) -> tuple[float, float]:
    """Return the band of chi-square over its degrees of freedom."""
    if freedom > _EXACT or freedom != round(freedom):
        return mean_square_at(freedom, -K_SIGMA), mean_square_at(freedom, K_SIGMA)
    n = round(freedom)
    return _quantile(n, 1.0 - 0.5 * MISS) / n, _quantile(n, 0.5 * MISS) / n


def mean_square_at(freedom: float, sigmas: float) -> float:
    """Return the quantile of chi-square over its degrees of freedom that is `sigmas` from the median of a normal one.

    Wilson and Hilferty (1931).
    """
    a = 2.0 / (9.0 * freedom)
    return max(1.0 - a + sigmas * math.sqrt(a), 0.0) ** 3


def rms_band(n: int, ratio: float = 1.0) -> tuple[float, float]:
    """Return the band of the RMS of n errors over their bound, for a filter whose true ratio is 1 to `ratio`."""
    low, high = chi_square_band(n)
    return math.sqrt(low), ratio * math.sqrt(high)


def greatest_of(n: int) -> float:
    """Return how many sigmas the greatest of n normal errors stays below."""
    return NormalDist().inv_cdf(1.0 - 0.25 * MISS / n)


def median_of(n: int) -> float:
    """Return how many sigmas the median of the sizes of n normal errors stays below.

    At least half of n (rounded down, so that it holds for the mean of the middle two) must lie above what it is.
    """
    half, low, high = n // 2 + n % 2, 0.0, 8.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        beyond = math.erfc(middle / math.sqrt(2.0))
        low, high = (middle, high) if _binomial_tail(n, half, beyond) > MISS else (low, middle)
    return high


def share_of(n: int, expected: float) -> float:
    """Return the greatest share of n flights that an event of probability `expected` may have."""
    return next(k for k in range(n + 1) if _binomial_tail(n, k + 1, expected) < MISS) / n


def paired_ratio(n: int, correlation: float) -> float:
    """Return how far the RMS of n errors may exceed that of n others of equal sigma that are correlated with them.

    The logarithm of the ratio scatters by sqrt((1 - correlation^2) / n) (Pitman 1939, Morgan 1939).
    """
    return math.exp(K_SIGMA * math.sqrt(max(1.0 - correlation**2, 0.0) / n))


def _binomial_tail(n: int, least: int, p: float) -> float:
    """The probability of `least` or more of n."""
    return math.fsum(math.comb(n, k) * p**k * (1.0 - p) ** (n - k) for k in range(least, n + 1))


def _quantile(n: int, upper: float) -> float:
    """The chi-square of n degrees of freedom that is exceeded with probability `upper`."""
    low, high = 0.0, 10.0 * n + 100.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _survival(n, middle) > upper else (low, middle)
    return 0.5 * (low + high)


def _survival(n: int, x: float) -> float:
    """Probability that chi-square exceeds x, by the recurrence from n to n + 2 degrees of freedom."""
    if x <= 0.0:
        return 1.0
    half, at = 0.5 * x, 1.0 if n % 2 else 2.0
    terms = [math.erfc(math.sqrt(half)) if n % 2 else math.exp(-half)]
    while at < n:
        terms.append(math.exp(0.5 * at * math.log(half) - half - math.lgamma(0.5 * at + 1.0)))
        at += 2.0
    return math.fsum(terms)
