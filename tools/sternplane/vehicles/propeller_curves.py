"""Open-water curves of a propeller, K_T and K_Q over J (ITTC), made into the propeller of this model.

The model's thrust goes with n|n| alone. A hull whose drag goes with u|u| runs at one advance ratio J at every steady
speed, so that there the two agree; while it speeds up, or is braked, they do not, and by how much is told.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from firmware_py.params import ParamError

_SHARES = (0.0, 0.5, 0.8, 1.0, 1.2)
"""Of the advance ratio of steady motion, at which the fit is compared."""


_POOR = 0.15
"""A propeller whose efficiency is nowhere better is not built; its K_Q is ten times too large, or its J ends early."""


class OpenWater(NamedTuple):
    """K_T and K_Q at advance ratios J, ascending; K_Q may be empty."""

    J: Sequence[float]
    K_T: Sequence[float]
    K_Q: Sequence[float]


class PropellerFit(NamedTuple):
    """The propeller of a hull at its trim.

    Attributes:
        J: advance ratio of every steady speed.
        n_trim: shaft speed at the trim, rev/s.
        thrust: on the hull at the trim, N: (1 - t) T.
        torque: of the shaft at the trim, N m; NaN without K_Q.
        power: at the shaft at the trim, W; NaN without K_Q.
        best: greatest efficiency of the curves, and its J; NaN without K_Q.
        errors: (share of J, thrust of the model over that of the curve) where the curve gives a thrust.
    """

    J: float
    n_trim: float
    thrust: float
    torque: float
    power: float
    best: tuple[float, float]
    errors: tuple[tuple[float, float], ...]


def is_curve(name: str) -> bool:
    """Return whether a column is one of those of open-water curves."""
    return _plain(name) in ("J", "KT", "KQ", "10KQ")


def _plain(name: str) -> str:
    return name.replace("_", "").replace(" ", "").upper()


def open_water(columns: Mapping[str, Sequence[float]], where: str) -> OpenWater | None:
    """Return the curves of a table, or None where it has none; K_Q may be written as 10KQ.

    Raises:
        ParamError: J is not ascending from 0, a column is missing or of another length, or the propeller would give
            more power than it takes.
    """
    plain = {_plain(name): values for name, values in columns.items()}
    if "J" not in plain:
        return None
    if "KT" not in plain:
        raise ParamError(f"{where}: there is J, but no K_T over it")
    tenth = plain.get("10KQ")
    torque = plain.get("KQ", [] if tenth is None else [0.1 * value for value in tenth])
    found = OpenWater(plain["J"], plain["KT"], torque)
    if len(found.J) < 2 or len(found.K_T) != len(found.J) or len(found.K_Q) not in (0, len(found.J)):
        raise ParamError(f"{where}: J, K_T and K_Q must be lists of the same length, of two or more numbers")
    if any(b <= a for a, b in zip(found.J, found.J[1:], strict=False)) or found.J[0] < 0.0:
        raise ParamError(f"{where}: J must rise from 0 or more")
    efficiency, J = best_efficiency(found)
    if efficiency > 1.0:
        text = f"K_T and K_Q make an efficiency of {efficiency:.3g} at J = {J:g}, and none is over 1"
        hint = "they may be K_Q under the name 10KQ" if tenth is not None else "check their powers of ten"
        raise ParamError(f"{where}: {text}; {hint}")
    return found


def best_efficiency(curves: OpenWater) -> tuple[float, float]:
    """Return the greatest efficiency J K_T / (2 pi K_Q) while it drives, and its J; NaN without K_Q."""
    rows = zip(curves.J, curves.K_T, curves.K_Q, strict=True) if curves.K_Q else ()
    found = [(J * K_T / (math.tau * K_Q), J) for J, K_T, K_Q in rows if K_T > 0.0 and K_Q > 0.0]
    return max(found, default=(math.nan, math.nan))


def fit_propeller(
    curves: OpenWater, C_d0: float, L: float, rho: float, u: float, diameter: float, wake: float, deduction: float
) -> PropellerFit:
    """Return the propeller that drives a hull of drag rho/2 L^2 C_d0 u|u| at its trim speed u.

    Args:
        curves: see `OpenWater`.
        C_d0: drag of the hull; > 0.
        L: its length, m.
        rho: density of the water, kg/m^3.
        u: trim speed, m/s.
        diameter: of the propeller, m.
        wake: Taylor's wake fraction w; the propeller meets (1 - w) u.
        deduction: thrust deduction t; the hull feels (1 - t) T.

    Raises:
        ParamError: the curves give too little thrust, or end before the J of steady motion.
    """
    wanted = 0.5 * L * L * C_d0 / (diameter**2 * (1.0 - wake) ** 2)
    J = _advance_ratio(curves, wanted / (1.0 - deduction))
    n = (1.0 - wake) * u / (J * diameter)
    thrust = 0.5 * rho * L * L * C_d0 * u * u
    torque = rho * n * n * diameter**5 * float(np.interp(J, curves.J, curves.K_Q)) if curves.K_Q else math.nan
    at_trim = float(np.interp(J, curves.J, curves.K_T))
    errors = []
    for share in _SHARES:
        K_T = float(np.interp(share * J, curves.J, curves.K_T))
        if curves.J[0] <= share * J <= curves.J[-1] and K_T > 0.0:
            errors.append((share, at_trim / K_T))
    return PropellerFit(J, n, thrust, torque, math.tau * n * torque, best_efficiency(curves), tuple(errors))


def _advance_ratio(curves: OpenWater, wanted: float) -> float:
    """Return the J at which K_T / J^2 is as wanted; it falls with J."""

    def excess(J: float) -> float:
        return float(np.interp(J, curves.J, curves.K_T)) - wanted * J * J

    low, high = max(curves.J[0], 1e-6), curves.J[-1]
    if not excess(low) > 0.0 or not excess(high) < 0.0:
        raise ParamError(
            f"propeller: K_T / J^2 = {wanted:.4g} is needed to drive this hull, and the curves, J = {curves.J[0]:g} to "
            f"{curves.J[-1]:g}, do not reach it: check the drag (Xuu), the diameter, and the curves' end"
        )
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) > 0.0 else (low, middle)
    return 0.5 * (low + high)


def errors_text(fit: PropellerFit) -> str:
    """Return by how much the model's thrust is off the curve's, in words, and the efficiency of the curves."""
    shares = [f"{100.0 * (ratio - 1.0):+.0f} % at {share:g} J" for share, ratio in fit.errors]
    text = f"steady at J = {fit.J:.3f}; thrust off the curve by {', '.join(shares)}"
    efficiency, J = fit.best
    if not math.isnan(efficiency):
        text += f"; efficiency at most {efficiency:.2g}, at J = {J:g}"
    if efficiency < _POOR:
        text += ": too little for a propeller; K_Q may be 10 K_Q, whose column is 10KQ, or J ends too early"
    return text
