"""Hydrodynamic coefficients of the autopilot's model: nondimensional with rho/2 L^n, in SNAME notation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from firmware_py.params import param


def _coefficient() -> Any:
    return param(0.0, low=-10.0, high=10.0)


def _needed() -> Any:
    return param(low=-10.0, high=10.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Coefficients:
    """The coefficients of Healey and Lienard (1993); one that a file leaves out is 0, as tables leave them out.

    Those without which no law can be designed (Eq. 26, Eq. 30, and Z_w for climbing) have no default: 0 there is a
    table read halfway.

    A name spells its term: force or moment, then the factors that the coefficient multiplies. `dot` marks added mass;
    ds, dr and db are stern planes, rudders and *one* bow plane; a final n marks a term in the propeller's slipstream,
    which is multiplied by eps(n).
    """

    X_pp: float = _coefficient()
    X_qq: float = _coefficient()
    X_rr: float = _coefficient()
    X_pr: float = _coefficient()
    X_udot: float = _coefficient()
    X_wq: float = _coefficient()
    X_vp: float = _coefficient()
    X_vr: float = _coefficient()
    X_vv: float = _coefficient()
    X_ww: float = _coefficient()
    X_qds: float = _coefficient()
    X_wds: float = _coefficient()
    X_dsds: float = _coefficient()
    X_rdr: float = _coefficient()
    X_vdr: float = _coefficient()
    X_drdr: float = _coefficient()
    X_qdb: float = _coefficient()
    X_wdb: float = _coefficient()
    X_qdsn: float = _coefficient()
    X_wdsn: float = _coefficient()
    X_dsdsn: float = _coefficient()

    Y_pdot: float = _coefficient()
    Y_rdot: float = _coefficient()
    Y_vdot: float = _coefficient()
    Y_pq: float = _coefficient()
    Y_qr: float = _coefficient()
    Y_p: float = _coefficient()
    Y_r: float = _needed()
    Y_v: float = _needed()
    Y_vq: float = _coefficient()
    Y_wp: float = _coefficient()
    Y_wr: float = _coefficient()
    Y_vw: float = _coefficient()
    Y_dr: float = _needed()

    Z_qdot: float = _coefficient()
    Z_wdot: float = _coefficient()
    Z_pp: float = _coefficient()
    Z_pr: float = _coefficient()
    Z_rr: float = _coefficient()
    Z_q: float = _coefficient()
    Z_w: float = _needed()
    Z_vp: float = _coefficient()
    Z_vr: float = _coefficient()
    Z_vv: float = _coefficient()
    Z_ds: float = _coefficient()
    Z_db: float = _coefficient()
    Z_qn: float = _coefficient()
    Z_wn: float = _coefficient()
    Z_dsn: float = _coefficient()

    K_pdot: float = _coefficient()
    K_rdot: float = _coefficient()
    K_vdot: float = _coefficient()
    K_pq: float = _coefficient()
    K_qr: float = _coefficient()
    K_p: float = _coefficient()
    K_r: float = _coefficient()
    K_v: float = _coefficient()
    K_vq: float = _coefficient()
    K_wp: float = _coefficient()
    K_wr: float = _coefficient()
    K_vw: float = _coefficient()
    K_pn: float = _coefficient()
    K_prop: float = _coefficient()

    M_qdot: float = _coefficient()
    M_wdot: float = _coefficient()
    M_pp: float = _coefficient()
    M_pr: float = _coefficient()
    M_rr: float = _coefficient()
    M_q: float = _needed()
    M_w: float = _coefficient()
    M_vp: float = _coefficient()
    M_vr: float = _coefficient()
    M_vv: float = _coefficient()
    M_ds: float = _needed()
    M_db: float = _coefficient()
    M_qn: float = _coefficient()
    M_wn: float = _coefficient()
    M_dsn: float = _coefficient()

    N_pdot: float = _coefficient()
    N_rdot: float = _coefficient()
    N_vdot: float = _coefficient()
    N_pq: float = _coefficient()
    N_qr: float = _coefficient()
    N_p: float = _coefficient()
    N_r: float = _needed()
    N_v: float = _needed()
    N_vq: float = _coefficient()
    N_wp: float = _coefficient()
    N_wr: float = _coefficient()
    N_vw: float = _coefficient()
    N_dr: float = _needed()
    N_prop: float = _coefficient()
