"""Sliding-mode design by pole placement, and the control law (paper Eq. 19-25)."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.vehicle.linear_models import LinearModel, Vector3

_SINGULAR = 1e-12
"""Relative size below which a determinant, or the last entry of s, counts as zero."""


class DesignError(ValueError):
    """A model whose poles no gain can place."""


class SlidingDesign(NamedTuple):
    """A sliding-mode design for a model x_dot = A x + b delta.

    Attributes:
        s: sliding surface, shape (3,): sigma = s . (x - x_d).
        k: linear feedback gain, shape (3,).
        s_b: s'b.
        eta: switching gain, in units of sigma per second, > 0.
        phi_b: boundary layer thickness, in units of sigma, > 0.
    """

    s: Vector3
    k: Vector3
    s_b: float
    eta: float
    phi_b: float


def sliding_surface(model: LinearModel, poles: tuple[float, float], s_last: float) -> tuple[Vector3, Vector3, float]:
    """Return the sliding surface s, the gain k and s'b for one pole at the origin and two at `poles`.

    s is the left eigenvector of A - b k' at the origin (Eq. 24). With h' = e3' [b, A b, A^2 b]^-1, Ackermann's formula
    gives k' = h' (A - p1 I) (A - p2 I) A. Hence s' = h' (A - p1 I) (A - p2 I), up to a scale, and k' = s'A / (s'b).

    Args:
        model: A, shape (3, 3), and b, shape (3,).
        poles: p1 and p2, 1/s, < 0: the motion on the surface.
        s_last: value that the last entry of s is scaled to.

    Raises:
        DesignError: (A, b) is not controllable, or sigma does not contain the last state.
    """
    A, b = model
    Ab = _matrix_times(A, b)
    AAb = _matrix_times(A, Ab)
    cross = (b[1] * Ab[2] - b[2] * Ab[1], b[2] * Ab[0] - b[0] * Ab[2], b[0] * Ab[1] - b[1] * Ab[0])
    determinant = cross[0] * AAb[0] + cross[1] * AAb[1] + cross[2] * AAb[2]  # of the controllability matrix
    if not abs(determinant) > _SINGULAR * _norm1(b) * _norm1(Ab) * _norm1(AAb):
        raise DesignError("the model (A, b) is not controllable: no gain places its poles")
    h = (cross[0] / determinant, cross[1] / determinant, cross[2] / determinant)
    p1, p2 = poles
    hA = _times_matrix(h, A)
    hAA = _times_matrix(hA, A)
    s = (
        hAA[0] - (p1 + p2) * hA[0] + p1 * p2 * h[0],
        hAA[1] - (p1 + p2) * hA[1] + p1 * p2 * h[1],
        hAA[2] - (p1 + p2) * hA[2] + p1 * p2 * h[2],
    )
    if not abs(s[2]) > _SINGULAR * _norm1(s):
        raise DesignError("the sliding variable of (A, b) does not contain the last state")
    scale = s_last / s[2]  # s'b of the unscaled s is h'A^2 b = 1, so this is s'b of the scaled one
    return (s[0] * scale, s[1] * scale, s[2] * scale), _times_matrix(s, A), scale


def cautious_poles(model: LinearModel, poles: tuple[float, float], caution: float) -> tuple[float, float]:
    """Return poles that are, with all the caution, so fast that the gain takes no damping away.

    b'k is trace(A) - p1 - p2, the third pole being 0. Poles that are slower than the model's own make it negative: the
    feedback drives the motion. Where the true damping is less than believed, or the fins do more, that is unstable. In
    between the poles change in proportion to `caution`, in [0, 1].
    """
    A, _ = model
    trace = A[0][0] + A[1][1] + A[2][2]
    scale = 1.0 + caution * max(0.0, trace / (poles[0] + poles[1]) - 1.0)
    return poles[0] * scale, poles[1] * scale


def design_sliding_mode(
    model: LinearModel, poles: tuple[float, float], s_last: float, delta_sw: float, phi_b: float
) -> SlidingDesign:
    """Return the design whose switching term moves the fin by at most `delta_sw`, rad: eta = |s'b| delta_sw.

    The other arguments are those of `sliding_surface` and `SlidingDesign`.

    Raises:
        DesignError: as `sliding_surface`.
    """
    s, k, s_b = sliding_surface(model, poles, s_last)
    return SlidingDesign(s, k, s_b, abs(s_b) * delta_sw, phi_b)


def control_law(design: SlidingDesign, error: Vector3, delta_ff: float) -> tuple[float, float]:
    """Return the fin angle delta (rad) and sigma of Eq. 25, without its disturbance term.

    delta = delta_ff - k'(x - x_d) - eta / (s'b) tanh(sigma / phi_b), with sigma = s'(x - x_d).

    Eq. 25 has -k'x + (s'b)^-1 s'x_d_dot in place of the first two terms. They are the same: x_d_dot = A x_d +
    b delta_ff and s'A = (s'b) k' make s'x_d_dot / (s'b) = k'x_d + delta_ff.

    Args:
        design: the design for the model at this speed.
        error: x - x_d, shape (3,), in the units of the model's states.
        delta_ff: feed-forward fin angle, rad, which keeps the model on x_d.
    """
    s, k = design.s, design.k
    sigma = s[0] * error[0] + s[1] * error[1] + s[2] * error[2]
    feedback = k[0] * error[0] + k[1] * error[1] + k[2] * error[2]
    return delta_ff - feedback - design.eta / design.s_b * math.tanh(sigma / design.phi_b), sigma


def _matrix_times(A: tuple[Vector3, Vector3, Vector3], x: Vector3) -> Vector3:
    """Return A x."""
    (a, b, c), (d, e, f), (g, h, i) = A
    x0, x1, x2 = x
    return a * x0 + b * x1 + c * x2, d * x0 + e * x1 + f * x2, g * x0 + h * x1 + i * x2


def _times_matrix(x: Vector3, A: tuple[Vector3, Vector3, Vector3]) -> Vector3:
    """Return x' A."""
    (a, b, c), (d, e, f), (g, h, i) = A
    x0, x1, x2 = x
    return a * x0 + d * x1 + g * x2, b * x0 + e * x1 + h * x2, c * x0 + f * x1 + i * x2


def _norm1(x: Vector3) -> float:
    return abs(x[0]) + abs(x[1]) + abs(x[2])
