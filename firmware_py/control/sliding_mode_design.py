"""The sliding-mode design by pole placement, and its law (paper Eq. 19-25)."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.vehicle.linear_models import Linear, Row


class DesignError(ValueError):
    """A model that no gain can place the poles of."""


class Sliding(NamedTuple):
    """A design: sigma = s . error and u = -k . x + ... (Eq. 25); eta and phi_b in units of sigma (per s, and plain)."""

    s: Row
    k: Row
    s_b: float
    eta: float
    phi_b: float


def surface(model: Linear, poles: tuple[float, float], last: float) -> tuple[Row, Row, float]:
    """The sliding surface s, the gain k and s'b for one pole at the origin and two at `poles`, 1/s.

    With h' = e3' [b, Ab, A^2 b]^-1, Ackermann's k' = h' (A - p1)(A - p2) A is s'A / (s'b) for s' = h' (A - p1)(A - p2):
    that s is the left eigenvector of A - b k' at the origin (Eq. 24). It is scaled so that its last entry is `last`.

    Raises:
        DesignError: (A, b) is not controllable, or sigma does not contain the last state.
    """
    A, b = model
    Ab = _product(A, b)
    AAb = _product(A, Ab)
    cross = (b[1] * Ab[2] - b[2] * Ab[1], b[2] * Ab[0] - b[0] * Ab[2], b[0] * Ab[1] - b[1] * Ab[0])
    volume = cross[0] * AAb[0] + cross[1] * AAb[1] + cross[2] * AAb[2]
    if not abs(volume) > 1e-12 * _size(b) * _size(Ab) * _size(AAb):
        raise DesignError("the model (A, b) is not controllable: no gain places its poles")
    h = (cross[0] / volume, cross[1] / volume, cross[2] / volume)
    p1, p2 = poles
    hA = _row_product(h, A)
    hAA = _row_product(hA, A)
    s = (
        hAA[0] - (p1 + p2) * hA[0] + p1 * p2 * h[0],
        hAA[1] - (p1 + p2) * hA[1] + p1 * p2 * h[1],
        hAA[2] - (p1 + p2) * hA[2] + p1 * p2 * h[2],
    )
    if not abs(s[2]) > 1e-12 * _size(s):
        raise DesignError("the sliding variable of (A, b) does not contain the last state")
    scale = last / s[2]
    return (s[0] * scale, s[1] * scale, s[2] * scale), _row_product(s, A), scale


def design(model: Linear, poles: tuple[float, float], last: float, delta_sw: float, phi_b: float) -> Sliding:
    """`surface`, with the switching gain eta = |s'b| delta_sw for a switching authority of delta_sw, rad."""
    s, k, s_b = surface(model, poles, last)
    return Sliding(s, k, s_b, abs(s_b) * delta_sw, phi_b)


def law(sliding: Sliding, error: Row, delta_d: float) -> tuple[float, float]:
    """(u, sigma) of Eq. 25 without its disturbance term, for error = x - x_d.

    `delta_d` is the input that keeps the model on x_d. Then x_d_dot = A x_d + b delta_d, and since s'A = (s'b) k' the
    terms -k'x + (s'b)^-1 s'x_d_dot of Eq. 25 are delta_d - k' error: the feed-forward follows from the law.
    """
    s, k = sliding.s, sliding.k
    sigma = s[0] * error[0] + s[1] * error[1] + s[2] * error[2]
    linear = k[0] * error[0] + k[1] * error[1] + k[2] * error[2]
    return delta_d - linear - sliding.eta / sliding.s_b * math.tanh(sigma / sliding.phi_b), sigma


def _product(A: tuple[Row, Row, Row], x: Row) -> Row:
    (a, b, c), (d, e, f), (g, h, i) = A
    x0, x1, x2 = x
    return a * x0 + b * x1 + c * x2, d * x0 + e * x1 + f * x2, g * x0 + h * x1 + i * x2


def _row_product(x: Row, A: tuple[Row, Row, Row]) -> Row:
    (a, b, c), (d, e, f), (g, h, i) = A
    x0, x1, x2 = x
    return a * x0 + d * x1 + g * x2, b * x0 + e * x1 + h * x2, c * x0 + f * x1 + i * x2


def _size(x: Row) -> float:
    return abs(x[0]) + abs(x[1]) + abs(x[2])
