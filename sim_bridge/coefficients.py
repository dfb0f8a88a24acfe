"""The hydrodynamic coefficients of the truth, nondimensional as published, and the dimension each has by its name."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass

_SYMBOL = re.compile(r"[uvwpqr]dot|d[srb]|prop|[uvwpqr]|n")
_LENGTHS = {"udot": 1, "vdot": 1, "wdot": 1, "pdot": 2, "qdot": 2, "rdot": 2, "p": 1, "q": 1, "r": 1}
"""Powers of L that a factor of a term brings, since the terms are scaled by rho/2 L^2 U^2 (forces)."""


@dataclass(frozen=True, slots=True)
class Coefficients:
    """Healey and Lienard (1993), all of them and none by default; `db` terms are those of one bow plane.

    The name spells the term: `X_qdsn` multiplies u q delta_s eps(n) in the surge equation.
    """

    X_pp: float
    X_qq: float
    X_rr: float
    X_pr: float
    X_udot: float
    X_wq: float
    X_vp: float
    X_vr: float
    X_qds: float
    X_rdr: float
    X_vv: float
    X_ww: float
    X_vdr: float
    X_wds: float
    X_dsds: float
    X_drdr: float
    X_qdsn: float
    X_wdsn: float
    X_dsdsn: float
    X_qdb: float
    X_wdb: float
    X_dbdb: float

    Y_pdot: float
    Y_rdot: float
    Y_pq: float
    Y_qr: float
    Y_vdot: float
    Y_p: float
    Y_r: float
    Y_vq: float
    Y_wp: float
    Y_wr: float
    Y_v: float
    Y_vw: float
    Y_dr: float

    Z_qdot: float
    Z_pp: float
    Z_pr: float
    Z_rr: float
    Z_wdot: float
    Z_q: float
    Z_vp: float
    Z_vr: float
    Z_w: float
    Z_vv: float
    Z_ds: float
    Z_db: float
    Z_qn: float
    Z_wn: float
    Z_dsn: float

    K_pdot: float
    K_rdot: float
    K_pq: float
    K_qr: float
    K_vdot: float
    K_p: float
    K_r: float
    K_vq: float
    K_wp: float
    K_wr: float
    K_v: float
    K_vw: float
    K_pn: float
    K_prop: float

    M_qdot: float
    M_pp: float
    M_pr: float
    M_rr: float
    M_wdot: float
    M_q: float
    M_vp: float
    M_vr: float
    M_w: float
    M_vv: float
    M_ds: float
    M_db: float
    M_qn: float
    M_wn: float
    M_dsn: float

    N_pdot: float
    N_rdot: float
    N_pq: float
    N_qr: float
    N_vdot: float
    N_p: float
    N_r: float
    N_vq: float
    N_wp: float
    N_wr: float
    N_v: float
    N_vw: float
    N_dr: float
    N_prop: float


def length_power(name: str) -> int:
    """The power of L in the scale rho/2 L^k of a coefficient: X_vv 2, X_wq 3, Y_rdot 4, M_qdot 5.

    Raises:
        ValueError: the name is not a force or moment and a product of known factors.
    """
    equation, _, term = name.partition("_")
    factors = _SYMBOL.findall(term)
    if equation not in tuple("XYZKMN") or not term or "".join(factors) != term:
        raise ValueError(f"{name!r} does not spell a hydrodynamic term")
    return 2 + (equation in "KMN") + sum(_LENGTHS.get(factor, 0) for factor in factors)


def dimensional(coefficients: Coefficients, rho: float, L: float) -> dict[str, float]:
    """Every coefficient by name times rho/2 L^k, so that SI motion gives N and N m."""
    names = (field.name for field in dataclasses.fields(Coefficients))
    return {name: getattr(coefficients, name) * 0.5 * rho * L ** length_power(name) for name in names}
