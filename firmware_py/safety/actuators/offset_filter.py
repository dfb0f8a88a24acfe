"""A Kalman filter of a rate of turn with a constant moment of unknown size beside the disturbance that eddies make."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.vehicle.turning import Follower

PRIOR_STD = math.radians(10.0)
"""1 sigma of the moment in the beginning, as the angle of a fin."""

Covariance = tuple[float, float, float, float, float, float]
"""Of rate, disturbance and angle: rr, rd, dd, ra, da, aa."""


class Offset(NamedTuple):
    """The filter: rate, rad/s; disturbance, rad/s^2; the moment as an angle of a fin, rad; covariance."""

    rate: float
    disturbance: float
    angle: float
    covariance: Covariance


class Step(NamedTuple):
    """What is alike for all filters of an axis in a step.

    Attributes:
        rate: mean of the measured rate of turn over the step, rad/s.
        damping: of the rate, 1/s, negative.
        noise: variance of the mean rate, rad^2/s^2.
        variance: that of innovations, over what the filters expect.
        dt: s.
    """

    rate: float
    damping: float
    noise: float
    variance: float
    dt: float


def begin_offset(follower: Follower, gains: tuple[float, float], noise: float, dt: float, angle: float) -> Offset:
    """Return a filter that begins from one without such a moment, of stationary `gains`, with the moment at `angle`."""
    rr, rd = noise * gains[0], noise * gains[1]
    covariance = rr, rd, max(rd * gains[0] / dt, rd * rd / rr), 0.0, 0.0, PRIOR_STD * PRIOR_STD
    return Offset(*follower, angle, covariance)


def follow_offset(was: Offset, step: Step, known: float, unit: float, walk: float) -> tuple[Offset, float]:
    """Return the filter after a step, and the negative log-likelihood of what was measured, nats.

    Args:
        was: the filter before.
        step: what was measured.
        known: angular acceleration that the model knows, but for damping, rad/s^2.
        unit: that of the moment, by the angle, 1/s^2.
        walk: variance that the disturbance gains, rad^2/s^4.
    """
    dt = step.dt
    r, d, a, (rr, rd, dd, ra, da, aa) = was
    keep, by = 1.0 + dt * step.damping, dt * unit
    predicted = keep * r + dt * (known + d + unit * a)
    x_r, x_d, x_a = keep * rr + dt * rd + by * ra, keep * rd + dt * dd + by * da, keep * ra + dt * da + by * aa
    p_rr, p_dd = keep * x_r + dt * x_d + by * x_a, dd + walk
    s, e = p_rr + step.noise, step.rate - predicted
    k_r, k_d, k_a = p_rr / s, x_d / s, x_a / s
    after = (1.0 - k_r) * p_rr, (1.0 - k_r) * x_d, p_dd - k_d * x_d, (1.0 - k_r) * x_a, da - k_d * x_a, aa - k_a * x_a
    loss = 0.5 * (e * e / (s * step.variance) + math.log(s))
    return Offset(predicted + k_r * e, d + k_d * e, a + k_a * e, after), loss
