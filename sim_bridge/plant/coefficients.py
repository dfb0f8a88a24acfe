"""The hydrodynamic coefficients of the truth, nondimensional as published, and the dimension each has by its name."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass
from typing import Any

from firmware_py.params import param

_SYMBOL = re.compile(r"[uvwpqr]dot|d[srb]|prop|[uvwpqr]|n")
_LENGTHS = {"udot": 1, "vdot": 1, "wdot": 1, "pdot": 2, "qdot": 2, "rdot": 2, "p": 1, "q": 1, "r": 1}
"""Powers of L that a factor of a term brings, since the terms are scaled by rho/2 L^2 U^2 (forces)."""


def _coefficient() -> Any:
    return param(0.0, low=-10.0, high=10.0)


def _needed() -> Any:
    return param(low=-10.0, high=10.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class PlantCoefficients:
    """Healey and Lienard (1993), all of them; `db` terms are those of one bow plane. One that is left out is 0.

    Damping of heave, pitch, sway and yaw and fins have no default: without them nothing can be steered.

    The name spells the term: `X_qdsn` multiplies u q delta_s eps(n) in the surge equation.
    """

    X_pp: float = _coefficient()
    X_qq: float = _coefficient()
    X_rr: float = _coefficient()
    X_pr: float = _coefficient()
    X_udot: float = _coefficient()
    X_wq: float = _coefficient()
    X_vp: float = _coefficient()
    X_vr: float = _coefficient()
    X_qds: float = _coefficient()
    X_rdr: float = _coefficient()
    X_vv: float = _coefficient()
    X_ww: float = _coefficient()
    X_vdr: float = _coefficient()
    X_wds: float = _coefficient()
    X_dsds: float = _coefficient()
    X_drdr: float = _coefficient()
    X_qdsn: float = _coefficient()
    X_wdsn: float = _coefficient()
    X_dsdsn: float = _coefficient()
    X_qdb: float = _coefficient()
    X_wdb: float = _coefficient()
    X_dbdb: float = _coefficient()

    Y_pdot: float = _coefficient()
    Y_rdot: float = _coefficient()
    Y_pq: float = _coefficient()
    Y_qr: float = _coefficient()
    Y_vdot: float = _coefficient()
    Y_p: float = _coefficient()
    Y_r: float = _needed()
    Y_vq: float = _coefficient()
    Y_wp: float = _coefficient()
    Y_wr: float = _coefficient()
    Y_v: float = _needed()
    Y_vw: float = _coefficient()
    Y_dr: float = _needed()

    Z_qdot: float = _coefficient()
    Z_pp: float = _coefficient()
    Z_pr: float = _coefficient()
    Z_rr: float = _coefficient()
    Z_wdot: float = _coefficient()
    Z_q: float = _coefficient()
    Z_vp: float = _coefficient()
    Z_vr: float = _coefficient()
    Z_w: float = _needed()
    Z_vv: float = _coefficient()
    Z_ds: float = _coefficient()
    Z_db: float = _coefficient()
    Z_qn: float = _coefficient()
    Z_wn: float = _coefficient()
    Z_dsn: float = _coefficient()

    K_pdot: float = _coefficient()
    K_rdot: float = _coefficient()
    K_pq: float = _coefficient()
    K_qr: float = _coefficient()
    K_vdot: float = _coefficient()
    K_p: float = _coefficient()
    K_r: float = _coefficient()
    K_vq: float = _coefficient()
    K_wp: float = _coefficient()
    K_wr: float = _coefficient()
    K_v: float = _coefficient()
    K_vw: float = _coefficient()
    K_pn: float = _coefficient()
    K_prop: float = _coefficient()

    M_qdot: float = _coefficient()
    M_pp: float = _coefficient()
    M_pr: float = _coefficient()
    M_rr: float = _coefficient()
    M_wdot: float = _coefficient()
    M_q: float = _needed()
    M_vp: float = _coefficient()
    M_vr: float = _coefficient()
    M_w: float = _coefficient()
    M_vv: float = _coefficient()
    M_ds: float = _needed()
    M_db: float = _coefficient()
    M_qn: float = _coefficient()
    M_wn: float = _coefficient()
    M_dsn: float = _coefficient()

    N_pdot: float = _coefficient()
    N_rdot: float = _coefficient()
    N_pq: float = _coefficient()
    N_qr: float = _coefficient()
    N_vdot: float = _coefficient()
    N_p: float = _coefficient()
    N_r: float = _needed()
    N_vq: float = _coefficient()
    N_wp: float = _coefficient()
    N_wr: float = _coefficient()
    N_v: float = _needed()
    N_vw: float = _coefficient()
    N_dr: float = _needed()
    N_prop: float = _coefficient()


def length_power(name: str) -> int:
    """Return the power of L in the scale rho/2 L^k of a coefficient: X_vv 2, X_wq 3, Y_rdot 4, M_qdot 5.

    Raises:
        ValueError: the name is not a force or moment and a product of known factors.
    """
    equation, _, term = name.partition("_")
    factors = _SYMBOL.findall(term)
    if equation not in tuple("XYZKMN") or not term or "".join(factors) != term:
        raise ValueError(f"{name!r} does not spell a hydrodynamic term")
    return 2 + (equation in "KMN") + sum(_LENGTHS.get(factor, 0) for factor in factors)


def dimensional(coefficients: PlantCoefficients, rho: float, L: float) -> dict[str, float]:
    """Return every coefficient by name times rho/2 L^k, so that SI motion gives N and N m."""
    names = (field.name for field in dataclasses.fields(PlantCoefficients))
    return {name: getattr(coefficients, name) * 0.5 * rho * L ** length_power(name) for name in names}
